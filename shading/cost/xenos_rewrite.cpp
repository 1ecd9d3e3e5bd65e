#include "shading/cost/xenos_rewrite.hpp"

#include "platform/host/error.hpp"
#include "shading/cost/xenos_packing.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <tuple>

namespace aluminate::cost {
namespace {

using vm::Opcode;

bool all_literal(const Operand& operand, double number) {
  for (int i = 0; i < operand.count; ++i) {
    const Ref& ref = operand.refs[static_cast<std::size_t>(i)];
    if (ref.kind != Ref::Kind::Literal || ref.value != number) return false;
  }
  return operand.count > 0;
}

bool is_lane(const Operand& operand, Opcode op, const Graph& graph) {
  return operand.count == 1 && operand.refs[0].kind == Ref::Kind::Node && !operand.absolute &&
         graph.nodes[operand.refs[0].index].op == op && graph.nodes[operand.refs[0].index].special == Special::None;
}

class Rewriter {
 public:
  explicit Rewriter(BlockResults results)
      : graph_(std::move(results.graph)), exports_(std::move(results.exports)), homes_(std::move(results.homes)) {}

  Graph run(Packing packing) {
    prune();
    fold_roots();
    fold_doubling();
    prune();
    split_by_destiny();
    place_exports();
    place_homes();
    fold_dot_products();
    prune();
    do {
      gather_operands();
    } while (!order_home_writes());
    if (packing != Packing::Off) {
      pack_lanes(graph_, packing);
      order_home_writes();
    }
    return std::move(graph_);
  }

 private:
  // --- uses ---------------------------------------------------------------------------------------------------------

  template <class Visit>
  void for_each_ref(Visit&& visit) {
    for (Node& node : graph_.nodes) {
      if (node.removed) continue;
      for (std::size_t s = 0; s < static_cast<std::size_t>(node.sources); ++s) {
        for (int i = 0; i < node.src[s].count; ++i) visit(node.src[s].refs[static_cast<std::size_t>(i)]);
      }
    }
    for (Leaving& leaving : exports_) visit(leaving.ref);
    for (Leaving& leaving : homes_) visit(leaving.ref);
  }

  /// Reads of node results by operations of the block, all lanes together.
  std::vector<int> internal_uses() const {
    std::vector<int> uses(graph_.nodes.size(), 0);
    for (const Node& node : graph_.nodes) {
      if (!node.removed) for_each_dependency(node, [&](int n) { ++uses[static_cast<std::size_t>(n)]; });
    }
    return uses;
  }

  /// Removes operations and lanes nobody reads. Fetches lose lanes too: the fetch word masks its destination.
  void prune() {
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
      const bool root = node.dest == DestKind::Effect && node.special != Special::LoadAddress && node.special != Special::FetchSetup;
      if (!node.removed && (root || node.dest == DestKind::Export || node.dest == DestKind::Home || used[n] != 0)) reach(static_cast<int>(n));
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
    for (std::size_t n = 0; n < graph_.nodes.size(); ++n) graph_.nodes[n].removed = graph_.nodes[n].removed || !live[n];
    drop_unused_lanes();
  }

  static void mark(std::vector<std::uint8_t>& used, const Ref& ref) {
    if (ref.kind == Ref::Kind::Node) used[ref.index] |= static_cast<std::uint8_t>(1 << ref.component);
  }

  void drop_unused_lanes() {
    // Operands of later operations shrink first, so walking backwards in creation order is not enough after rewriting:
    // repeat until nothing changes.
    for (bool changed = true; changed;) {
      changed = false;
      std::vector<std::uint8_t> used(graph_.nodes.size(), 0);
      for_each_ref([&](Ref& ref) { mark(used, ref); });
      for (std::size_t n = 0; n < graph_.nodes.size(); ++n) {
        Node& node = graph_.nodes[n];
        if (node.removed || node.dest != DestKind::Value || node.special != Special::None || node.is_reduction()) continue;
        const std::uint8_t all = static_cast<std::uint8_t>((1 << node.width) - 1);
        if (node.width == 1 || (used[n] & all) == all || used[n] == 0) continue;
        keep_lanes(static_cast<int>(n), used[n]);
        changed = true;
      }
    }
  }

  /// Narrows a node to the lanes in `keep` and renames the reads of the others away.
  void keep_lanes(int n, std::uint8_t keep) {
    Node& node = graph_.nodes[static_cast<std::size_t>(n)];
    std::array<int, 4> renamed = {-1, -1, -1, -1};
    int width = 0;
    for (int lane = 0; lane < node.width; ++lane) {
      if ((keep >> lane & 1) == 0) continue;
      renamed[static_cast<std::size_t>(lane)] = width;
      const bool elementwise = !node.is_fetch() || node.op == Opcode::DsX || node.op == Opcode::DsY;
      for (Operand& operand : node.src) {
        if (elementwise && operand.count == node.width) operand.refs[static_cast<std::size_t>(width)] = operand.refs[static_cast<std::size_t>(lane)];
      }
      ++width;
    }
    const bool per_lane = !node.is_fetch() || node.op == Opcode::DsX || node.op == Opcode::DsY;
    if (node.is_fetch() && !per_lane) select_fetch_lanes(node, keep);
    for (std::size_t s = 0; per_lane && s < static_cast<std::size_t>(node.sources); ++s) node.src[s].count = width;
    node.width = width;
    graph_.groups.set_width(n, width);
    for_each_ref([&](Ref& ref) {
      if (ref.kind == Ref::Kind::Node && static_cast<int>(ref.index) == n) {
        ref.component = static_cast<std::uint8_t>(renamed[ref.component]);
      }
    });
  }

  static void select_fetch_lanes(Node& node, std::uint8_t keep) {
    std::array<std::uint8_t, 4> texel{};
    int width = 0;
    for (int lane = 0; lane < node.width; ++lane) {
      if (keep >> lane & 1) texel[static_cast<std::size_t>(width++)] = node.texel_component[static_cast<std::size_t>(lane)];
    }
    node.texel_component = texel;
  }

  // --- folding --------------------------------------------------------------------------------------------------------

  /// rcp(rsq(x)) and x * rsq(x) are one sqrt (rule 6).
  void fold_roots() {
    std::vector<int> uses = all_uses();
    for (Node& node : graph_.nodes) {
      if (node.removed || node.special != Special::None || node.width != 1) continue;
      const bool reciprocal = node.op == Opcode::Rcp && is_lane(node.src[0], Opcode::Rsq, graph_) && !node.src[0].negate;
      if (reciprocal && uses[node.src[0].refs[0].index] == 1) {
        const Operand inner = graph_.nodes[node.src[0].refs[0].index].src[0];
        node.op = Opcode::Sqrt;
        node.src[0] = inner;
        continue;
      }
      if (node.op != Opcode::Mul) continue;
      for (std::size_t s = 0; s < 2; ++s) {
        if (!is_lane(node.src[s], Opcode::Rsq, graph_) || node.src[s].negate || uses[node.src[s].refs[0].index] != 1) continue;
        const Node& root = graph_.nodes[node.src[s].refs[0].index];
        if (root.saturate || !(root.src[0] == node.src[1 - s])) continue;
        node.op = Opcode::Sqrt;
        node.src[0] = root.src[0];
        node.sources = 1;
        break;
      }
    }
  }

  std::vector<int> all_uses() const {
    std::vector<int> uses = internal_uses();
    for (const auto* list : {&exports_, &homes_}) {
      for (const Leaving& leaving : *list) {
        if (leaving.ref.kind == Ref::Kind::Node) ++uses[leaving.ref.index];
      }
    }
    return uses;
  }

  /// 2 * x is x + x: no literal, and one register for the scalar half (rule 6).
  void fold_doubling() {
    for (Node& node : graph_.nodes) {
      if (node.removed || node.op != Opcode::Mul || node.special != Special::None) continue;
      for (std::size_t s = 0; s < 2; ++s) {
        const Operand& other = node.src[1 - s];
        if (!all_literal(node.src[s], node.src[s].negate ? -2.0 : 2.0) || node.src[s].absolute || other.refs[0].is_constant()) continue;
        const Operand doubled = other;
        node.op = Opcode::Add;
        node.src[0] = node.src[1] = doubled;
        break;
      }
    }
  }

  /// mad(a, b, mad(c, d, e)) on single components is one dp2add where both pairs can share registers (rule 6).
  void fold_dot_products() {
    std::vector<int> uses = all_uses();
    for (Node& outer : graph_.nodes) {
      if (outer.removed || outer.op != Opcode::Mad || outer.special != Special::None || outer.width != 1) continue;
      const Operand addend = outer.src[2];
      if (addend.refs[0].kind != Ref::Kind::Node || addend.absolute) continue;
      Node& inner = graph_.nodes[addend.refs[0].index];
      const bool product = inner.op == Opcode::Mad || inner.op == Opcode::Mul;
      if (!product || inner.special != Special::None || inner.width != 1 || inner.saturate || inner.dest != DestKind::Value ||
          uses[addend.refs[0].index] != 1) {
        continue;
      }
      if (fold_pair(outer, inner, addend.negate)) inner.removed = true;
    }
  }

  bool fold_pair(Node& outer, const Node& inner, bool subtract) {
    for (std::size_t s = 0; s < 2; ++s) {
      if (outer.src[s].absolute || inner.src[s].absolute) return false;
    }
    const bool outer_sign = outer.src[0].negate != outer.src[1].negate;
    const bool inner_sign = (inner.src[0].negate != inner.src[1].negate) != subtract;
    if (outer_sign != inner_sign) return false;
    for (int order = 0; order < 2; ++order) {
      const Operand& first = inner.src[static_cast<std::size_t>(order)];
      const Operand& second = inner.src[static_cast<std::size_t>(1 - order)];
      RegisterGroups groups = graph_.groups;
      if (!share(groups, first.refs[0], outer.src[0].refs[0]) || !share(groups, second.refs[0], outer.src[1].refs[0])) continue;
      graph_.groups = groups;
      Node dot = outer;
      dot.op = Opcode::Dp2Add;
      dot.src[0] = pair_of(first.refs[0], outer.src[0].refs[0], outer_sign);
      dot.src[1] = pair_of(second.refs[0], outer.src[1].refs[0], false);
      if (inner.op == Opcode::Mad) {
        dot.src[2] = inner.src[2];
        if (subtract && dot.src[2].refs[0].kind == Ref::Kind::Literal) {
          dot.src[2].refs[0].value = 0.0 - dot.src[2].refs[0].value;
        } else {
          dot.src[2].negate ^= subtract;
        }
      } else {
        dot.src[2] = Operand{};
        dot.src[2].count = 1;
      }
      outer = dot;
      return true;
    }
    return false;
  }

  Operand pair_of(const Ref& x, const Ref& y, bool negate) {
    Operand operand;
    operand.count = 2;
    operand.refs[0] = x;
    operand.refs[1] = y;
    operand.negate = negate;
    return operand;
  }

  bool share(RegisterGroups& groups, const Ref& a, const Ref& b) const { return share_register(graph_, groups, a, b); }

  // --- leaving the block ------------------------------------------------------------------------------------------------

  /// A vector operation whose components go different ways is split: export words cannot write a register too, and the
  /// period compiler names final components apart from temporary ones.
  void split_by_destiny() {
    const std::size_t count = graph_.nodes.size();
    std::vector<std::array<int, 4>> destiny(count, std::array<int, 4>{});
    constexpr int kHome = 1 << 20;
    for (const Leaving& leaving : homes_) {
      if (leaving.ref.kind == Ref::Kind::Node) destiny[leaving.ref.index][leaving.ref.component] = kHome + leaving.index;
    }
    for (const Leaving& leaving : exports_) {
      if (leaving.ref.kind == Ref::Kind::Node) destiny[leaving.ref.index][leaving.ref.component] = 1 + leaving.index;
    }
    for (std::size_t n = 0; n < count; ++n) {
      const Node& node = graph_.nodes[n];
      if (node.removed || node.is_fetch() || node.is_reduction() || node.dest != DestKind::Value || node.width == 1) continue;
      const int width = node.width;
      std::uint8_t todo = static_cast<std::uint8_t>((1 << width) - 1);
      std::vector<std::uint8_t> parts;
      for (int lane = 0; lane < width; ++lane) {
        if ((todo >> lane & 1) == 0) continue;
        std::uint8_t part = 0;
        for (int other = lane; other < width; ++other) {
          if (destiny[n][static_cast<std::size_t>(other)] == destiny[n][static_cast<std::size_t>(lane)]) part |= static_cast<std::uint8_t>(1 << other);
        }
        todo &= static_cast<std::uint8_t>(~part);
        parts.push_back(part);
      }
      for (std::size_t p = 1; p < parts.size(); ++p) split_off(static_cast<int>(n), parts[p]);
      if (parts.size() > 1) keep_lanes(static_cast<int>(n), parts[0]);
    }
  }

  /// A copy of node n that computes only `part`; reads of those lanes move to it. Lane numbers of n stay.
  void split_off(int n, std::uint8_t part) {
    Node piece = graph_.nodes[static_cast<std::size_t>(n)];
    std::array<int, 4> renamed = {-1, -1, -1, -1};
    int width = 0;
    for (int lane = 0; lane < piece.width; ++lane) {
      if ((part >> lane & 1) == 0) continue;
      renamed[static_cast<std::size_t>(lane)] = width;
      for (std::size_t s = 0; s < static_cast<std::size_t>(piece.sources); ++s) {
        piece.src[s].refs[static_cast<std::size_t>(width)] = piece.src[s].refs[static_cast<std::size_t>(lane)];
      }
      ++width;
    }
    piece.width = width;
    for (std::size_t s = 0; s < static_cast<std::size_t>(piece.sources); ++s) piece.src[s].count = width;
    const int added = graph_.add(piece);
    for_each_ref([&](Ref& ref) {
      if (ref.kind == Ref::Kind::Node && static_cast<int>(ref.index) == n && renamed[ref.component] >= 0) {
        ref = node_ref(added, renamed[ref.component]);
      }
    });
  }

  Node copy_node(const Leaving& first) const {
    Node copy;
    copy.op = Opcode::Mov;
    copy.width = 0;
    copy.sources = 1;
    copy.src[0].negate = first.negate;
    copy.src[0].absolute = first.absolute;
    copy.origin = first.origin;
    if (first.ref.kind == Ref::Kind::Node) copy.line = graph_.nodes[first.ref.index].line;
    return copy;
  }

  static void add_lane(Node& copy, const Leaving& leaving) {
    for (int lane = 0; lane < copy.width; ++lane) {
      if (copy.src[0].refs[static_cast<std::size_t>(lane)] == leaving.ref) {
        copy.dest_lane[leaving.component] = static_cast<std::int8_t>(lane);
        return;
      }
    }
    copy.dest_lane[leaving.component] = static_cast<std::int8_t>(copy.width);
    copy.src[0].refs[static_cast<std::size_t>(copy.width++)] = leaving.ref;
    copy.src[0].count = copy.width;
  }

  /// The last operation writes the export itself; a copy remains for fetched, constant and input components, and for the
  /// whole output when one of its computed components is read again (rule 4). 0 and 1 come free from the write masks.
  void place_exports() {
    std::stable_sort(exports_.begin(), exports_.end(), [](const Leaving& a, const Leaving& b) { return a.index < b.index; });
    for (std::size_t begin = 0; begin < exports_.size();) {
      std::size_t end = begin;
      while (end < exports_.size() && exports_[end].index == exports_[begin].index) ++end;
      place_output({exports_.begin() + static_cast<std::ptrdiff_t>(begin), exports_.begin() + static_cast<std::ptrdiff_t>(end)});
      begin = end;
    }
    graph_.has_export = !exports_.empty();
    exports_.clear();
  }

  void place_output(const std::vector<Leaving>& components) {
    const std::vector<int> internal = internal_uses();
    const auto node_of = [&](const Leaving& leaving) -> const Node* {
      return leaving.ref.kind == Ref::Kind::Node ? &graph_.nodes[leaving.ref.index] : nullptr;
    };
    const auto leaves_elsewhere = [&](const Leaving& leaving) {
      for (const Leaving& same : components) {  // the same result with a sign needs a register to be read from
        if (same.ref.kind == Ref::Kind::Node && same.ref.index == leaving.ref.index && (same.negate || same.absolute)) return true;
      }
      for (const Leaving& home : homes_) {
        if (home.ref.kind == Ref::Kind::Node && home.ref.index == leaving.ref.index) return true;
      }
      for (const Leaving& other : exports_) {
        if (other.index > leaving.index && other.ref.kind == Ref::Kind::Node && other.ref.index == leaving.ref.index) return true;
      }
      return false;
    };
    std::vector<Leaving> moving;
    std::uint8_t free_constants = 0;
    bool whole = false, same_modifiers = true;
    for (const Leaving& leaving : components) {
      const bool zero_or_one = leaving.ref.kind == Ref::Kind::Literal && (leaving.ref.value == 0.0 || leaving.ref.value == 1.0);
      if (zero_or_one && components.size() > 1) {
        free_constants |= static_cast<std::uint8_t>(1 << leaving.component);
        free_values_[leaving.component] = leaving.ref.value;
        continue;
      }
      const Node* node = node_of(leaving);
      whole = whole || (node != nullptr && !node->is_fetch() && internal[leaving.ref.index] > 0 && !leaving.negate && !leaving.absolute);
      if (!moving.empty()) same_modifiers = same_modifiers && leaving.negate == moving[0].negate && leaving.absolute == moving[0].absolute;
      moving.push_back(leaving);
    }
    if (moving.empty()) {  // nothing but 0 and 1: one word still has to be issued
      for (const Leaving& leaving : components) moving.push_back(leaving);
      free_constants = 0;
    }
    whole = whole && same_modifiers;

    std::vector<int> writers;
    std::map<std::tuple<int, std::uint32_t, bool, bool>, int> copies;
    for (const Leaving& leaving : moving) {
      const Node* node = node_of(leaving);
      const bool direct = !whole && node != nullptr && !leaving.negate && !leaving.absolute && node->special == Special::None &&
                          !node->is_fetch() && internal[leaving.ref.index] == 0 && !leaves_elsewhere(leaving);
      if (direct) {
        Node& writer = graph_.nodes[leaving.ref.index];
        writer.dest = DestKind::Export;
        writer.dest_index = leaving.index;
        writer.dest_lane[leaving.component] = static_cast<std::int8_t>(leaving.ref.component);
        writers.push_back(static_cast<int>(leaving.ref.index));
        continue;
      }
      auto key = std::make_tuple(static_cast<int>(leaving.ref.kind), leaving.ref.index, leaving.negate, leaving.absolute);
      if (leaving.ref.kind == Ref::Kind::Literal) std::get<1>(key) = 0;
      if (whole) key = {-1, 0, false, false};
      auto found = copies.find(key);
      if (found == copies.end()) {
        Node copy = copy_node(leaving);
        copy.dest = DestKind::Export;
        copy.dest_index = leaving.index;
        found = copies.emplace(key, graph_.add(copy)).first;
        writers.push_back(found->second);
      }
      add_lane(graph_.nodes[static_cast<std::size_t>(found->second)], leaving);
    }
    Node& last = graph_.nodes[static_cast<std::size_t>(writers.back())];
    last.export_constants = free_constants;
    for (std::size_t c = 0; c < 4; ++c) last.export_values[c] = free_values_[c];
  }

  void place_homes() {
    const std::vector<int> internal = internal_uses();
    std::map<std::pair<std::uint16_t, std::uint32_t>, std::vector<Leaving>> by_node;
    std::vector<Leaving> copied;
    for (const Leaving& home : homes_) {
      bool direct = home.ref.kind == Ref::Kind::Node && !home.negate && !home.absolute;
      if (direct) {
        const Node& node = graph_.nodes[home.ref.index];
        direct = node.dest == DestKind::Value && node.special == Special::None;
        for (const Leaving& other : homes_) {
          direct = direct && (other.ref.kind != Ref::Kind::Node || other.ref.index != home.ref.index || other.index == home.index);
        }
      }
      if (direct) {
        by_node[{home.index, home.ref.index}].push_back(home);
      } else {
        copied.push_back(home);
      }
    }
    homes_.clear();
    for (auto& [key, list] : by_node) {
      Node& node = graph_.nodes[key.second];
      std::uint8_t lanes = 0;
      for (const Leaving& home : list) lanes |= static_cast<std::uint8_t>(1 << home.ref.component);
      if (lanes != (1 << node.width) - 1) {  // a lane would have no component of the register to live in
        copied.insert(copied.end(), list.begin(), list.end());
        continue;
      }
      node.dest = DestKind::Home;
      node.dest_index = key.first;
      for (const Leaving& home : list) node.dest_lane[home.component] = static_cast<std::int8_t>(home.ref.component);
    }
    std::map<std::tuple<std::uint16_t, int, std::uint32_t, bool, bool>, int> copies;
    for (const Leaving& home : copied) {
      const auto key = std::make_tuple(home.index, static_cast<int>(home.ref.kind),
                                       home.ref.kind == Ref::Kind::Literal ? 0 : home.ref.index, home.negate, home.absolute);
      auto found = copies.find(key);
      if (found == copies.end()) {
        Node copy = copy_node(home);
        copy.dest = DestKind::Home;
        copy.dest_index = home.index;
        found = copies.emplace(key, graph_.add(copy)).first;
      }
      add_lane(graph_.nodes[static_cast<std::size_t>(found->second)], home);
    }
  }

  /// Reads of a block's incoming registers stay before their overwriting. Returns false after breaking a cycle with a
  /// copy, which makes operands to be gathered again.
  bool order_home_writes() {
    graph_.write_after_read.clear();
    for (std::size_t w = 0; w < graph_.nodes.size(); ++w) {
      const Node& writer = graph_.nodes[w];
      if (writer.removed || writer.dest != DestKind::Home) continue;
      for (std::size_t r = 0; r < graph_.nodes.size(); ++r) {
        if (r == w || graph_.nodes[r].removed) continue;
        if (reads_home(graph_.nodes[r], writer)) graph_.write_after_read.emplace_back(static_cast<int>(r), static_cast<int>(w));
      }
    }
    const int bad = home_writer_on_cycle(graph_);
    if (bad < 0) return true;
    Node& node = graph_.nodes[static_cast<std::size_t>(bad)];
    Node copy;
    copy.op = Opcode::Mov;
    copy.sources = 1;
    copy.width = node.width;
    copy.src[0].count = node.width;
    for (int lane = 0; lane < node.width; ++lane) copy.src[0].refs[static_cast<std::size_t>(lane)] = node_ref(bad, lane);
    copy.dest = DestKind::Home;
    copy.dest_index = node.dest_index;
    copy.dest_lane = node.dest_lane;
    copy.origin = node.origin;
    copy.line = node.line;
    node.dest = DestKind::Value;
    node.dest_lane = {-1, -1, -1, -1};
    graph_.add(copy);
    return false;
  }

  static bool reads_home(const Node& reader, const Node& writer) {
    for (std::size_t s = 0; s < static_cast<std::size_t>(reader.sources); ++s) {
      for (int i = 0; i < reader.src[s].count; ++i) {
        const Ref& ref = reader.src[s].refs[static_cast<std::size_t>(i)];
        if (ref.kind == Ref::Kind::Home && ref.index == writer.dest_index && writer.dest_lane[ref.component] >= 0) return true;
      }
    }
    return false;
  }

  // --- operands ---------------------------------------------------------------------------------------------------------

  /// Every operand comes from one register: results are placed together where four components suffice, copies are made
  /// where they do not, where a fetch would read a constant, and where a third constant register would be read.
  void gather_operands() {
    for (std::size_t n = 0; n < graph_.nodes.size(); ++n) {
      for (std::size_t s = 0; s < static_cast<std::size_t>(graph_.nodes[n].sources); ++s) {
        if (graph_.nodes[n].removed) break;
        gather(static_cast<int>(n), s);
      }
      while (!graph_.nodes[n].removed && constant_registers(graph_, &graph_.nodes[n]) > 2) copy_constant(static_cast<int>(n));
    }
  }

  void gather(int n, std::size_t s) {
    Operand operand = graph_.nodes[static_cast<std::size_t>(n)].src[s];
    const bool fetch = graph_.nodes[static_cast<std::size_t>(n)].is_fetch();
    const auto places = distinct_places(operand);
    const bool plain = !operand.negate && !operand.absolute && !operand.refs[0].is_constant();
    if (places.size() == 1 && (!fetch || plain)) return;

    if (!fetch || (!operand.negate && !operand.absolute)) {
      RegisterGroups groups = graph_.groups;
      bool together = true;
      for (const Ref& ref : places) together = together && share_register(graph_, groups, places[0], ref);
      if (together && !places[0].is_constant()) {
        graph_.groups = groups;
        return;
      }
    }
    // Which lanes stay: those of a value group that still has room for the copied ones. A fetch with modifiers copies all.
    int keep = -1, keep_lanes = 0;
    for (std::size_t p = 0; p < places.size() && !(fetch && !plain); ++p) {
      if (place_of(graph_, places[p]).kind != 0) continue;
      int lanes = 0;
      for (int i = 0; i < operand.count; ++i) lanes += same_place(operand.refs[static_cast<std::size_t>(i)], places[p]);
      const int room = 4 - graph_.groups.width(static_cast<int>(places[p].index));
      if (operand.count - lanes <= room && lanes > keep_lanes) {
        keep = static_cast<int>(p);
        keep_lanes = lanes;
      }
    }
    if (fetch && !plain) keep = -1;
    int anchor = keep >= 0 ? static_cast<int>(places[static_cast<std::size_t>(keep)].index) : -1;
    Operand gathered = operand;
    for (std::size_t p = 0; p < places.size(); ++p) {
      if (static_cast<int>(p) == keep) continue;
      const int copy = copy_of(operand, places[p], fetch, n);
      if (anchor >= 0) graph_.groups.merge(anchor, copy);
      anchor = anchor >= 0 ? anchor : copy;
      const Node& made = graph_.nodes[static_cast<std::size_t>(copy)];
      for (int i = 0; i < operand.count; ++i) {
        for (int lane = 0; lane < made.width; ++lane) {
          if (operand.refs[static_cast<std::size_t>(i)] == made.src[0].refs[static_cast<std::size_t>(lane)]) gathered.refs[static_cast<std::size_t>(i)] = node_ref(copy, lane);
        }
      }
    }
    if (fetch) gathered.negate = gathered.absolute = false;
    replace_operand(operand, gathered, n);
  }

  bool same_place(const Ref& a, const Ref& b) const { return place_of(graph_, a) == place_of(graph_, b); }

  std::vector<Ref> distinct_places(const Operand& operand) const {
    std::vector<Ref> places;
    for (int i = 0; i < operand.count; ++i) {
      const Ref& ref = operand.refs[static_cast<std::size_t>(i)];
      if (std::none_of(places.begin(), places.end(), [&](const Ref& seen) { return same_place(seen, ref); })) places.push_back(ref);
    }
    return places;
  }

  /// Copies the operand's components that live at `place`; a fetch's copy applies the modifiers too.
  int copy_of(const Operand& operand, const Ref& place, bool with_modifiers, int reader) {
    Node copy;
    copy.op = Opcode::Mov;
    copy.sources = 1;
    copy.width = 0;
    copy.origin = graph_.nodes[static_cast<std::size_t>(reader)].origin;
    copy.line = graph_.nodes[static_cast<std::size_t>(reader)].line;
    if (with_modifiers) {
      copy.src[0].negate = operand.negate;
      copy.src[0].absolute = operand.absolute;
    }
    for (int i = 0; i < operand.count; ++i) {
      const Ref& ref = operand.refs[static_cast<std::size_t>(i)];
      if (!same_place(ref, place)) continue;
      copy.src[0].refs[static_cast<std::size_t>(copy.width++)] = ref;
    }
    copy.src[0].count = copy.width;
    drop_equal_lanes(copy, copy.width);
    return graph_.add(copy);
  }

  /// Other operations that read the same components use the same copies; modifiers stay their own.
  void replace_operand(const Operand& before, const Operand& after, int first) {
    const bool modifiers_gone = before.negate != after.negate || before.absolute != after.absolute;
    for (std::size_t n = 0; n < graph_.nodes.size(); ++n) {
      Node& node = graph_.nodes[n];
      if (node.removed || (modifiers_gone && static_cast<int>(n) != first)) continue;
      for (std::size_t s = 0; s < static_cast<std::size_t>(node.sources); ++s) {
        Operand& operand = node.src[s];
        const bool same = operand.count == before.count &&
                          std::equal(operand.refs.begin(), operand.refs.begin() + operand.count, before.refs.begin());
        if (!same || is_copy_of(node, before, after)) continue;
        for (int i = 0; i < operand.count; ++i) operand.refs[static_cast<std::size_t>(i)] = after.refs[static_cast<std::size_t>(i)];
        if (modifiers_gone) operand.negate = operand.absolute = false;
      }
    }
  }

  bool is_copy_of(const Node& node, const Operand&, const Operand& after) const {
    for (int i = 0; i < after.count; ++i) {
      const Ref& ref = after.refs[static_cast<std::size_t>(i)];
      if (ref.kind == Ref::Kind::Node && &graph_.nodes[ref.index] == &node) return true;
    }
    return false;
  }

  void copy_constant(int n) {
    const Node& node = graph_.nodes[static_cast<std::size_t>(n)];
    for (std::size_t s = 0; s < static_cast<std::size_t>(node.sources); ++s) {
      if (!node.src[s].refs[0].is_constant()) continue;
      const Operand operand = node.src[s];
      const int copy = copy_of(operand, operand.refs[0], false, n);
      const Node& made = graph_.nodes[static_cast<std::size_t>(copy)];
      Operand moved = operand;
      for (int i = 0; i < operand.count; ++i) {
        for (int lane = 0; lane < made.width; ++lane) {
          if (operand.refs[static_cast<std::size_t>(i)] == made.src[0].refs[static_cast<std::size_t>(lane)]) moved.refs[static_cast<std::size_t>(i)] = node_ref(copy, lane);
        }
      }
      graph_.nodes[static_cast<std::size_t>(n)].src[s] = moved;
      return;
    }
  }

  Graph graph_;
  std::vector<Leaving> exports_, homes_;
  std::array<double, 4> free_values_{};
};

}  // namespace

Graph rewrite_block(BlockResults results, Packing packing) { return Rewriter(std::move(results)).run(packing); }

std::array<int, 4> drop_equal_lanes(Node& node, int count) {
  std::array<int, 4> renamed{};
  int width = 0;
  for (int lane = 0; lane < count; ++lane) {
    int found = -1;
    for (int kept = 0; kept < width && found < 0; ++kept) {
      bool equal = true;
      for (std::size_t s = 0; s < static_cast<std::size_t>(node.sources); ++s) {
        equal = equal && node.src[s].refs[static_cast<std::size_t>(kept)] == node.src[s].refs[static_cast<std::size_t>(lane)];
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
    case Opcode::Dp2Add: return source == 2 ? lane == 0 : lane < 2;
    case Opcode::Dp3: return lane < 3;
    case Opcode::Dp4: return true;
    case Opcode::Tex:
    case Opcode::TexBias:
    case Opcode::TexLod:
    case Opcode::TexGrad: {
      const bool flat = program.samplers[instruction.sampler].dimension == vm::SamplerDimension::Tex2D;
      const bool level = lane == 3 && (instruction.op == Opcode::TexBias || instruction.op == Opcode::TexLod);
      return lane < (flat ? 2 : 3) || level;
    }
    default: break;
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
    case Ref::Kind::Input: return {1, ref.index, {}, {}, -1};
    case Ref::Kind::Home: return {2, ref.index, {}, {}, -1};
    case Ref::Kind::Constant: return {3, ref.index, ref.relative, ref.file, ref.address_node};
    case Ref::Kind::Literal: return {4, 0, {}, {}, -1};
    case Ref::Kind::Counter: return {5, ref.index, {}, {}, -1};
  }
  return {};
}

bool share_register(const Graph& graph, RegisterGroups& groups, const Ref& a, const Ref& b) {
  const Place pa = place_of(graph, a), pb = place_of(graph, b);
  if (pa == pb) return true;
  if (pa.kind != 0 || pb.kind != 0 || !groups.can_merge(static_cast<int>(pa.index), static_cast<int>(pb.index))) return false;
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
          if (std::find(literals.begin(), literals.end(), ref.value) == literals.end()) literals.push_back(ref.value);
          continue;
        }
        const Place place = place_of(graph, ref);
        if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
      }
    }
  }
  return static_cast<int>(places.size() + (literals.size() + 3) / 4);
}

}  // namespace aluminate::cost
