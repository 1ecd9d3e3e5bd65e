// What no schedule of a block's operations can beat. In: the graph, as it will be scheduled. Out: words. Each
// step is proven beside it (schedule_bound.cpp); random programs check that no schedule is shorter.
#pragma once

#include "shading/cost/slot_choice.hpp"

#include <vector>

namespace aluminate::cost {

/// Operations of a set by the halves they can take. A word has one vector and one scalar half.
struct HalfCount {
  int alone = 0, vector = 0, scalar = 0, either = 0, two_slots = 0;

  void add(const SlotChoice& slots);
  void add(const HalfCount& more);
  /// Words the set fills at least. Proof: `alone` take a word each. In the other W words stand `vector`
  /// operations and the t of the two-slot ones that went to the vector half, so vector + t <= W; on the
  /// scalar half `scalar` and two slots for each other two-slot one, except that the movs of one of them may
  /// stand in the word before the set's first (open_front); all halves together are 2 W. The least W over all
  /// t is a bound.
  int words(bool open_front) const;
};

// member: parallel to graph.nodes, the operations to be scheduled; null: all.

/// Longest chain of dependencies, and for every window between the heads and tails of chains the words that
/// the operations which must issue inside it fill.
int window_bound_words(const Graph& graph, const PairRules& rules, const std::vector<bool>* member = nullptr);

/// The least length of at least `bound` (itself a bound) whose operations could still be paired off: each
/// operation only within the words its chain leaves it, only with a partner the machine allows beside it.
/// `bound` itself for more than kMostPaired operations: matching takes the cube of their number.
inline constexpr std::size_t kMostPaired = 400;
int pairing_bound_words(const Graph& graph, const PairRules& rules, int bound,
                        const std::vector<bool>* member = nullptr);

}  // namespace aluminate::cost
