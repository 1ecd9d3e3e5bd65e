// List scheduling for the "vec4+scalar" machine, and what no schedule of the block can beat. A block's graph
// comes in, the order of its issue words and fetches comes out. Bottom-up like the period compiler: work is
// placed as late as its readers allow, which also keeps registers few. No register is assigned here
// (xenos_registers).
#pragma once

#include "shading/cost/static_cost.hpp"
#include "shading/cost/xenos_graph.hpp"

#include <vector>

namespace aluminate::cost {

/// One ALU word or one fetch. In an ALU word at least one of vector, scalar, previous_move is set.
struct Issue {
  int fetch = -1;              // node
  int vector = -1;             // node on the vec4 half
  int scalar = -1;             // node on the scalar half
  int previous_move = -1;      // node whose first operand a movs loads into the previous-scalar register
  bool uses_previous = false;  // `scalar` is the second slot of that pair: muls_prev, adds_prev (rule 3)
  bool is_fetch() const { return fetch >= 0; }
};

struct BlockSchedule {
  std::vector<Issue> issues;
  int words = 0, fetch_words = 0;
  int clauses = 0;  // exec clauses of at most six issues; a new one starts where the exports are allocated
  int export_start = -1;  // issue where that clause begins, -1 without exports
  int bound_words = 0;
};

/// Operand of a two-slot scalar operation that the movs carries: the one known earlier.
int carried_operand(const Graph& graph, const Node& node);

/// No schedule is shorter: the chain of dependencies, and for every window between a head and a tail of that
/// chain the words its operations fill: three-operand operations alone under the strict rule, plus the most
/// of vector-only, scalar-only and half of all.
int lower_bound_words(const Graph& graph, PairingRule pairing);

/// Tries several priorities and keeps the shortest; ties go to the first. Deterministic.
BlockSchedule schedule_block(const Graph& graph, PairingRule pairing);

inline constexpr int kClauseIssues = 6;

}  // namespace aluminate::cost
