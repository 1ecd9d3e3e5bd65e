// One register for each operand: results placed together, or copied together.
#include "shading/cost/xenos_rewriter.hpp"

#include <algorithm>

namespace aluminate::cost {

using vm::Opcode;

void Rewriter::gather_operands() {
  for (std::size_t n = 0; n < graph_.nodes.size(); ++n) {
    for (std::size_t s = 0; s < static_cast<std::size_t>(graph_.nodes[n].sources); ++s) {
      if (graph_.nodes[n].removed) break;
      gather(static_cast<int>(n), s);
    }
    while (!graph_.nodes[n].removed && constant_registers(graph_, &graph_.nodes[n]) > 2)
      copy_constant(static_cast<int>(n));
  }
}

void Rewriter::gather(int n, std::size_t s) {
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
  // Which lanes stay: those of a value group that still has room for the copied ones. A fetch with modifiers
  // copies all.
  int keep = -1, keep_lanes = 0;
  for (std::size_t p = 0; p < places.size() && !(fetch && !plain); ++p) {
    if (place_of(graph_, places[p]).kind != 0) continue;
    int lanes = 0;
    for (int i = 0; i < operand.count; ++i)
      lanes += same_place(operand.refs[static_cast<std::size_t>(i)], places[p]);
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
        if (operand.refs[static_cast<std::size_t>(i)] == made.src[0].refs[static_cast<std::size_t>(lane)])
          gathered.refs[static_cast<std::size_t>(i)] = node_ref(copy, lane);
      }
    }
  }
  if (fetch) gathered.negate = gathered.absolute = false;
  replace_operand(operand, gathered, n);
}

bool Rewriter::same_place(const Ref& a, const Ref& b) const {
  return place_of(graph_, a) == place_of(graph_, b);
}

std::vector<Ref> Rewriter::distinct_places(const Operand& operand) const {
  std::vector<Ref> places;
  for (int i = 0; i < operand.count; ++i) {
    const Ref& ref = operand.refs[static_cast<std::size_t>(i)];
    if (std::none_of(places.begin(), places.end(), [&](const Ref& seen) { return same_place(seen, ref); }))
      places.push_back(ref);
  }
  return places;
}

int Rewriter::copy_of(const Operand& operand, const Ref& place, bool with_modifiers, int reader) {
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

void Rewriter::replace_operand(const Operand& before, const Operand& after, int first) {
  const bool modifiers_gone = before.negate != after.negate || before.absolute != after.absolute;
  for (std::size_t n = 0; n < graph_.nodes.size(); ++n) {
    Node& node = graph_.nodes[n];
    if (node.removed || (modifiers_gone && static_cast<int>(n) != first)) continue;
    for (std::size_t s = 0; s < static_cast<std::size_t>(node.sources); ++s) {
      Operand& operand = node.src[s];
      const bool same =
          operand.count == before.count &&
          std::equal(operand.refs.begin(), operand.refs.begin() + operand.count, before.refs.begin());
      if (!same || is_copy_of(node, before, after)) continue;
      for (int i = 0; i < operand.count; ++i)
        operand.refs[static_cast<std::size_t>(i)] = after.refs[static_cast<std::size_t>(i)];
      if (modifiers_gone) operand.negate = operand.absolute = false;
    }
  }
}

bool Rewriter::is_copy_of(const Node& node, const Operand&, const Operand& after) const {
  for (int i = 0; i < after.count; ++i) {
    const Ref& ref = after.refs[static_cast<std::size_t>(i)];
    if (ref.kind == Ref::Kind::Node && &graph_.nodes[ref.index] == &node) return true;
  }
  return false;
}

void Rewriter::copy_constant(int n) {
  const Node& node = graph_.nodes[static_cast<std::size_t>(n)];
  for (std::size_t s = 0; s < static_cast<std::size_t>(node.sources); ++s) {
    if (!node.src[s].refs[0].is_constant()) continue;
    const Operand operand = node.src[s];
    const int copy = copy_of(operand, operand.refs[0], false, n);
    const Node& made = graph_.nodes[static_cast<std::size_t>(copy)];
    Operand moved = operand;
    for (int i = 0; i < operand.count; ++i) {
      for (int lane = 0; lane < made.width; ++lane) {
        if (operand.refs[static_cast<std::size_t>(i)] == made.src[0].refs[static_cast<std::size_t>(lane)])
          moved.refs[static_cast<std::size_t>(i)] = node_ref(copy, lane);
      }
    }
    graph_.nodes[static_cast<std::size_t>(n)].src[s] = moved;
    return;
  }
}

}  // namespace aluminate::cost
