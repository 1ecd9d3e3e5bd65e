// Which halves of an issue word an operation can take, and which two operations can share a word: the rules
// of the machine that the scheduler and its bound both need. Evidence: docs/cost_model.md.
#pragma once

#include "shading/cost/static_cost.hpp"
#include "shading/cost/xenos_graph.hpp"

#include <vector>

namespace aluminate::cost {

/// Where an operation can go. All false: a fetch.
struct SlotChoice {
  bool vector = false, scalar = false;
  bool two_slots = false;  // movs + _prev: two scalar halves of neighbouring words (rule 3)
  bool alone = false;      // shares a word with nothing
};
SlotChoice slots_of(const Graph& graph, const Node& node, PairingRule pairing);

/// Operand of a two-slot scalar operation that the movs carries: the one known earlier.
int carried_operand(const Graph& graph, const Node& node);

/// The choices of a graph that no longer changes, and its legal pairs looked up in constant time.
class PairRules {
 public:
  PairRules(const Graph& graph, PairingRule pairing);
  const SlotChoice& slots(int node) const { return slots_[static_cast<std::size_t>(node)]; }
  /// `vector` on the vector half beside `scalar` on the scalar half (also as the second slot of a pair):
  /// class, destinations and constant registers. Says nothing about dependencies.
  bool legal(int vector, int scalar) const {
    return legal_[static_cast<std::size_t>(vector) * slots_.size() + static_cast<std::size_t>(scalar)] != 0;
  }
  /// A movs can stand beside this vector operation.
  bool beside_move(int vector) const {
    return !slots(vector).alone && graph_.nodes[static_cast<std::size_t>(vector)].dest != DestKind::Export;
  }

 private:
  const Graph& graph_;
  std::vector<SlotChoice> slots_;
  std::vector<std::uint8_t> legal_;  // [vector][scalar]
};

}  // namespace aluminate::cost
