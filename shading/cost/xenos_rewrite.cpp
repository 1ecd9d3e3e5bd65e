#include "shading/cost/xenos_rewrite.hpp"

#include "shading/cost/xenos_packing.hpp"
#include "shading/cost/xenos_rewriter.hpp"

#include <algorithm>

namespace aluminate::cost {

using vm::Opcode;

Graph Rewriter::run(Packing packing) && {
  prune();
  fold_roots();
  fold_doubling();
  prune();
  split_by_destiny();
  place_exports();
  place_homes();
  fold_dot_products();
  prune();
  const auto settle = [this] {  // a copy made to break a cycle is one more operand to gather
    do {
      gather_operands();
    } while (!order_home_writes());
  };
  settle();
  if (packing != Packing::Off) {
    pack_lanes(graph_, packing);
    settle();
  }
  return std::move(graph_);
}

std::vector<int> Rewriter::internal_uses() const {
  std::vector<int> uses(graph_.nodes.size(), 0);
  for (const Node& node : graph_.nodes) {
    if (!node.removed) for_each_dependency(node, [&](int n) { ++uses[static_cast<std::size_t>(n)]; });
  }
  return uses;
}

std::vector<int> Rewriter::all_uses() const {
  std::vector<int> uses = internal_uses();
  for (const auto* list : {&exports_, &homes_}) {
    for (const Leaving& leaving : *list) {
      if (leaving.ref.kind == Ref::Kind::Node) ++uses[leaving.ref.index];
    }
  }
  return uses;
}

void Rewriter::prune() {
  std::vector<std::uint8_t> used(graph_.nodes.size(), 0);
  for (const Leaving& leaving : exports_) mark(used, leaving.ref);
  for (const Leaving& leaving : homes_) mark(used, leaving.ref);
  std::vector<int> pending;
  std::vector<bool> live(graph_.nodes.size(), false);
  const auto reach = [&](int n) {
    if (!live[static_cast<std::size_t>(n)]) {
      live[static_cast<std::size_t>(n)] = true;
      pending.push_back(n);
    }
  };
  for (std::size_t n = 0; n < graph_.nodes.size(); ++n) {
    const Node& node = graph_.nodes[n];
    // Address loads and fetch set-up live through their users; kills and predicates by themselves.
    const bool root = node.dest == DestKind::Effect && node.special != Special::LoadAddress &&
                      node.special != Special::FetchSetup;
    if (!node.removed &&
        (root || node.dest == DestKind::Export || node.dest == DestKind::Home || used[n] != 0))
      reach(static_cast<int>(n));
  }
  for (const auto* list : {&exports_, &homes_}) {
    for (const Leaving& leaving : *list) {
      if (leaving.ref.address_node >= 0) reach(leaving.ref.address_node);
    }
  }
  while (!pending.empty()) {
    const int n = pending.back();
    pending.pop_back();
    for_each_dependency(graph_.nodes[static_cast<std::size_t>(n)], reach);
  }
  for (std::size_t n = 0; n < graph_.nodes.size(); ++n)
    graph_.nodes[n].removed = graph_.nodes[n].removed || !live[n];
  drop_unused_lanes();
}

void Rewriter::mark(std::vector<std::uint8_t>& used, const Ref& ref) {
  if (ref.kind == Ref::Kind::Node) used[ref.index] |= static_cast<std::uint8_t>(1 << ref.component);
}

void Rewriter::drop_unused_lanes() {
  // Operands of later operations shrink first, so walking backwards in creation order is not enough after
  // rewriting: repeat until nothing changes.
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<std::uint8_t> used(graph_.nodes.size(), 0);
    for_each_ref([&](Ref& ref) { mark(used, ref); });
    for (std::size_t n = 0; n < graph_.nodes.size(); ++n) {
      Node& node = graph_.nodes[n];
      if (node.removed || node.dest != DestKind::Value || node.special != Special::None ||
          node.is_reduction())
        continue;
      const std::uint8_t all = static_cast<std::uint8_t>((1 << node.width) - 1);
      if (node.width == 1 || (used[n] & all) == all || used[n] == 0) continue;
      keep_lanes(static_cast<int>(n), used[n]);
      changed = true;
    }
  }
}

void Rewriter::keep_lanes(int n, std::uint8_t keep) {
  Node& node = graph_.nodes[static_cast<std::size_t>(n)];
  std::array<int, 4> renamed = {-1, -1, -1, -1};
  int width = 0;
  for (int lane = 0; lane < node.width; ++lane) {
    if ((keep >> lane & 1) == 0) continue;
    renamed[static_cast<std::size_t>(lane)] = width;
    const bool elementwise = !node.is_fetch() || node.op == Opcode::DsX || node.op == Opcode::DsY;
    for (Operand& operand : node.src) {
      if (elementwise && operand.count == node.width)
        operand.refs[static_cast<std::size_t>(width)] = operand.refs[static_cast<std::size_t>(lane)];
    }
    ++width;
  }
  const bool per_lane = !node.is_fetch() || node.op == Opcode::DsX || node.op == Opcode::DsY;
  if (node.is_fetch() && !per_lane) select_fetch_lanes(node, keep);
  for (std::size_t s = 0; per_lane && s < static_cast<std::size_t>(node.sources); ++s)
    node.src[s].count = width;
  node.width = width;
  graph_.groups.set_width(n, width);
  for_each_ref([&](Ref& ref) {
    if (ref.kind == Ref::Kind::Node && static_cast<int>(ref.index) == n) {
      ref.component = static_cast<std::uint8_t>(renamed[ref.component]);
    }
  });
}

void Rewriter::select_fetch_lanes(Node& node, std::uint8_t keep) {
  std::array<std::uint8_t, 4> texel{};
  int width = 0;
  for (int lane = 0; lane < node.width; ++lane) {
    if (keep >> lane & 1)
      texel[static_cast<std::size_t>(width++)] = node.texel_component[static_cast<std::size_t>(lane)];
  }
  node.texel_component = texel;
}

Graph rewrite_block(BlockResults results, Packing packing) {
  return Rewriter(std::move(results)).run(packing);
}

std::array<int, 4> drop_equal_lanes(Node& node, int count) {
  std::array<int, 4> renamed{};
  int width = 0;
  for (int lane = 0; lane < count; ++lane) {
    int found = -1;
    for (int kept = 0; kept < width && found < 0; ++kept) {
      bool equal = true;
      for (std::size_t s = 0; s < static_cast<std::size_t>(node.sources); ++s) {
        equal = equal && node.src[s].refs[static_cast<std::size_t>(kept)] ==
                             node.src[s].refs[static_cast<std::size_t>(lane)];
      }
      if (equal) found = kept;
    }
    if (found < 0) {
      for (std::size_t s = 0; s < static_cast<std::size_t>(node.sources); ++s) {
        node.src[s].refs[static_cast<std::size_t>(width)] = node.src[s].refs[static_cast<std::size_t>(lane)];
      }
      found = width++;
    }
    renamed[static_cast<std::size_t>(lane)] = found;
  }
  node.width = width;
  for (std::size_t s = 0; s < static_cast<std::size_t>(node.sources); ++s) node.src[s].count = width;
  return renamed;
}

bool reads_lane(const vm::Program& program, const vm::Instruction& instruction, int source, int lane) {
  const vm::Pipe pipe = vm::info(instruction.op).pipe;
  switch (instruction.op) {
    case Opcode::Dp2Add:
      return source == 2 ? lane == 0 : lane < 2;
    case Opcode::Dp3:
      return lane < 3;
    case Opcode::Dp4:
      return true;
    case Opcode::Tex:
    case Opcode::TexBias:
    case Opcode::TexLod:
    case Opcode::TexGrad: {
      const bool flat = program.samplers[instruction.sampler].dimension == vm::SamplerDimension::Tex2D;
      const bool level = lane == 3 && (instruction.op == Opcode::TexBias || instruction.op == Opcode::TexLod);
      return lane < (flat ? 2 : 3) || level;
    }
    default:
      break;
  }
  if (pipe == vm::Pipe::Scalar || pipe == vm::Pipe::Flow || instruction.dst.mask == 0) return lane == 0;
  return (instruction.dst.mask >> lane & 1) != 0;
}

Place place_of(const Graph& graph, const Ref& ref) {
  switch (ref.kind) {
    case Ref::Kind::Node: {
      const Node& node = graph.nodes[ref.index];
      if (node.dest == DestKind::Home) return {2, node.dest_index, {}, {}, -1};
      return {0, static_cast<std::uint32_t>(graph.groups.find(static_cast<int>(ref.index))), {}, {}, -1};
    }
    case Ref::Kind::Input:
      return {1, ref.index, {}, {}, -1};
    case Ref::Kind::Home:
      return {2, ref.index, {}, {}, -1};
    case Ref::Kind::Constant:
      return {3, ref.index, ref.relative, ref.file, ref.address_node};
    case Ref::Kind::Literal:
      return {4, 0, {}, {}, -1};
    case Ref::Kind::Counter:
      return {5, ref.index, {}, {}, -1};
  }
  return {};
}

bool share_register(const Graph& graph, RegisterGroups& groups, const Ref& a, const Ref& b) {
  const Place pa = place_of(graph, a), pb = place_of(graph, b);
  if (pa == pb) return true;
  if (pa.kind != 0 || pb.kind != 0 ||
      !groups.can_merge(static_cast<int>(pa.index), static_cast<int>(pb.index)))
    return false;
  groups.merge(static_cast<int>(pa.index), static_cast<int>(pb.index));
  return true;
}

int constant_registers(const Graph& graph, const Node* a, const Node* b) {
  std::vector<Place> places;
  std::vector<double> literals;
  for (const Node* node : {a, b}) {
    if (node == nullptr) continue;
    for (std::size_t s = 0; s < static_cast<std::size_t>(node->sources); ++s) {
      for (int i = 0; i < node->src[s].count; ++i) {
        const Ref& ref = node->src[s].refs[static_cast<std::size_t>(i)];
        if (!ref.is_constant()) continue;
        if (ref.kind == Ref::Kind::Literal) {
          if (std::find(literals.begin(), literals.end(), ref.value) == literals.end())
            literals.push_back(ref.value);
          continue;
        }
        const Place place = place_of(graph, ref);
        if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
      }
    }
  }
  return static_cast<int>(places.size() + (literals.size() + 3) / 4);
}

ConstantUse::ConstantUse(const Graph& graph) : reads_(graph.nodes.size()) {
  std::vector<Place> places;
  std::vector<double> literals;
  const auto number_of = [](auto& known, const auto& value) {
    const auto found = std::find(known.begin(), known.end(), value);
    if (found != known.end()) return static_cast<int>(found - known.begin());
    known.push_back(value);
    return static_cast<int>(known.size()) - 1;
  };
  const auto insert = [](std::vector<int>& sorted, int number) {
    const auto at = std::lower_bound(sorted.begin(), sorted.end(), number);
    if (at == sorted.end() || *at != number) sorted.insert(at, number);
  };
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const Node& node = graph.nodes[n];
    for (std::size_t s = 0; s < static_cast<std::size_t>(node.sources); ++s)
      for (int i = 0; i < node.src[s].count; ++i) {
        const Ref& ref = node.src[s].refs[static_cast<std::size_t>(i)];
        if (!ref.is_constant()) continue;
        if (ref.kind == Ref::Kind::Literal) {
          insert(reads_[n].literals, number_of(literals, ref.value));
        } else {
          insert(reads_[n].places, number_of(places, place_of(graph, ref)));
        }
      }
  }
}

int ConstantUse::registers(int a, int b) const {
  static const Reads kNothing;
  const Reads& x = a < 0 ? kNothing : reads_[static_cast<std::size_t>(a)];
  const Reads& y = b < 0 ? kNothing : reads_[static_cast<std::size_t>(b)];
  const auto distinct = [](const std::vector<int>& p, const std::vector<int>& q) {
    int both = 0;
    for (auto i = p.begin(), j = q.begin(); i != p.end() && j != q.end();) {
      both += *i == *j;
      const bool advance_i = *i <= *j, advance_j = *j <= *i;
      i += advance_i;
      j += advance_j;
    }
    return static_cast<int>(p.size() + q.size()) - both;
  };
  return distinct(x.places, y.places) + (distinct(x.literals, y.literals) + 3) / 4;
}

}  // namespace aluminate::cost
