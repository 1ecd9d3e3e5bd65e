// Results that leave the block: which operation writes an export or a register other blocks read, and where
// copies stay.
#include "shading/cost/xenos_packing.hpp"
#include "shading/cost/xenos_rewriter.hpp"

#include <algorithm>
#include <map>
#include <tuple>

namespace aluminate::cost {

using vm::Opcode;

void Rewriter::split_by_destiny() {
  const std::size_t count = graph_.nodes.size();
  std::vector<std::array<int, 4>> destiny(count, std::array<int, 4>{});
  constexpr int kHome = 1 << 20;
  for (const Leaving& leaving : homes_) {
    if (leaving.ref.kind == Ref::Kind::Node)
      destiny[leaving.ref.index][leaving.ref.component] = kHome + leaving.index;
  }
  for (const Leaving& leaving : exports_) {
    if (leaving.ref.kind == Ref::Kind::Node)
      destiny[leaving.ref.index][leaving.ref.component] = 1 + leaving.index;
  }
  for (std::size_t n = 0; n < count; ++n) {
    const Node& node = graph_.nodes[n];
    if (node.removed || node.is_fetch() || node.is_reduction() || node.dest != DestKind::Value ||
        node.width == 1)
      continue;
    const int width = node.width;
    std::uint8_t todo = static_cast<std::uint8_t>((1 << width) - 1);
    std::vector<std::uint8_t> parts;
    for (int lane = 0; lane < width; ++lane) {
      if ((todo >> lane & 1) == 0) continue;
      std::uint8_t part = 0;
      for (int other = lane; other < width; ++other) {
        if (destiny[n][static_cast<std::size_t>(other)] == destiny[n][static_cast<std::size_t>(lane)])
          part |= static_cast<std::uint8_t>(1 << other);
      }
      todo &= static_cast<std::uint8_t>(~part);
      parts.push_back(part);
    }
    for (std::size_t p = 1; p < parts.size(); ++p) split_off(static_cast<int>(n), parts[p]);
    if (parts.size() > 1) keep_lanes(static_cast<int>(n), parts[0]);
  }
}

void Rewriter::split_off(int n, std::uint8_t part) {
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

Node Rewriter::copy_node(const Leaving& first) const {
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

void Rewriter::add_lane(Node& copy, const Leaving& leaving) {
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

void Rewriter::place_exports() {
  std::stable_sort(exports_.begin(), exports_.end(),
                   [](const Leaving& a, const Leaving& b) { return a.index < b.index; });
  for (std::size_t begin = 0; begin < exports_.size();) {
    std::size_t end = begin;
    while (end < exports_.size() && exports_[end].index == exports_[begin].index) ++end;
    place_output({exports_.begin() + static_cast<std::ptrdiff_t>(begin),
                  exports_.begin() + static_cast<std::ptrdiff_t>(end)});
    begin = end;
  }
  graph_.has_export = !exports_.empty();
  exports_.clear();
}

void Rewriter::place_output(const std::vector<Leaving>& components) {
  const std::vector<int> internal = internal_uses();
  const auto node_of = [&](const Leaving& leaving) -> const Node* {
    return leaving.ref.kind == Ref::Kind::Node ? &graph_.nodes[leaving.ref.index] : nullptr;
  };
  const auto leaves_elsewhere = [&](const Leaving& leaving) {
    for (const Leaving& same : components) {  // the same result with a sign needs a register to be read from
      if (same.ref.kind == Ref::Kind::Node && same.ref.index == leaving.ref.index &&
          (same.negate || same.absolute))
        return true;
    }
    for (const Leaving& home : homes_) {
      if (home.ref.kind == Ref::Kind::Node && home.ref.index == leaving.ref.index) return true;
    }
    for (const Leaving& other : exports_) {
      if (other.index > leaving.index && other.ref.kind == Ref::Kind::Node &&
          other.ref.index == leaving.ref.index)
        return true;
    }
    return false;
  };
  std::vector<Leaving> moving;
  std::uint8_t free_constants = 0;
  bool whole = false, same_modifiers = true;
  for (const Leaving& leaving : components) {
    const bool zero_or_one =
        leaving.ref.kind == Ref::Kind::Literal && (leaving.ref.value == 0.0 || leaving.ref.value == 1.0);
    if (zero_or_one && components.size() > 1) {
      free_constants |= static_cast<std::uint8_t>(1 << leaving.component);
      free_values_[leaving.component] = leaving.ref.value;
      continue;
    }
    const Node* node = node_of(leaving);
    whole = whole || (node != nullptr && !node->is_fetch() && internal[leaving.ref.index] > 0 &&
                      !leaving.negate && !leaving.absolute);
    if (!moving.empty())
      same_modifiers =
          same_modifiers && leaving.negate == moving[0].negate && leaving.absolute == moving[0].absolute;
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
    const bool direct = !whole && node != nullptr && !leaving.negate && !leaving.absolute &&
                        node->special == Special::None && !node->is_fetch() &&
                        internal[leaving.ref.index] == 0 && !leaves_elsewhere(leaving);
    if (direct) {
      Node& writer = graph_.nodes[leaving.ref.index];
      writer.dest = DestKind::Export;
      writer.dest_index = leaving.index;
      writer.dest_lane[leaving.component] = static_cast<std::int8_t>(leaving.ref.component);
      writers.push_back(static_cast<int>(leaving.ref.index));
      continue;
    }
    auto key = std::make_tuple(static_cast<int>(leaving.ref.kind), leaving.ref.index, leaving.negate,
                               leaving.absolute);
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

void Rewriter::place_homes() {
  const std::vector<int> internal = internal_uses();
  std::map<std::pair<std::uint16_t, std::uint32_t>, std::vector<Leaving>> by_node;
  std::vector<Leaving> copied;
  for (const Leaving& home : homes_) {
    bool direct = home.ref.kind == Ref::Kind::Node && !home.negate && !home.absolute;
    if (direct) {
      const Node& node = graph_.nodes[home.ref.index];
      direct = node.dest == DestKind::Value && node.special == Special::None;
      for (const Leaving& other : homes_) {
        direct = direct && (other.ref.kind != Ref::Kind::Node || other.ref.index != home.ref.index ||
                            other.index == home.index);
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
    for (const Leaving& home : list)
      node.dest_lane[home.component] = static_cast<std::int8_t>(home.ref.component);
  }
  std::map<std::tuple<std::uint16_t, int, std::uint32_t, bool, bool>, int> copies;
  for (const Leaving& home : copied) {
    const auto key =
        std::make_tuple(home.index, static_cast<int>(home.ref.kind),
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

bool Rewriter::order_home_writes() {
  graph_.write_after_read.clear();
  for (std::size_t w = 0; w < graph_.nodes.size(); ++w) {
    const Node& writer = graph_.nodes[w];
    if (writer.removed || writer.dest != DestKind::Home) continue;
    for (std::size_t r = 0; r < graph_.nodes.size(); ++r) {
      if (r == w || graph_.nodes[r].removed) continue;
      if (reads_home(graph_.nodes[r], writer))
        graph_.write_after_read.emplace_back(static_cast<int>(r), static_cast<int>(w));
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
  for (int lane = 0; lane < node.width; ++lane)
    copy.src[0].refs[static_cast<std::size_t>(lane)] = node_ref(bad, lane);
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

bool Rewriter::reads_home(const Node& reader, const Node& writer) {
  for (std::size_t s = 0; s < static_cast<std::size_t>(reader.sources); ++s) {
    for (int i = 0; i < reader.src[s].count; ++i) {
      const Ref& ref = reader.src[s].refs[static_cast<std::size_t>(i)];
      if (ref.kind == Ref::Kind::Home && ref.index == writer.dest_index &&
          writer.dest_lane[ref.component] >= 0)
        return true;
    }
  }
  return false;
}

}  // namespace aluminate::cost
