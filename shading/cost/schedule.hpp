// Scheduling for the "vec4+scalar" machine: a block's graph comes in, the order of its issue words and
// fetches comes out. Bottom-up like the period compiler: work is placed as late as its readers allow, which
// also keeps registers few. No register is assigned here (xenos_registers).
#pragma once

#include "shading/cost/slot_choice.hpp"
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

/// Plain: quick, to choose between graphs of one block; its bound is 0. Full: shorter where the bound leaves
/// room.
enum class Effort : std::uint8_t { Plain, Full };

/// The bound is that of schedule_bound.hpp. Deterministic.
BlockSchedule schedule_block(const Graph& graph, PairingRule pairing, Effort effort);

inline constexpr int kClauseIssues = 6;

}  // namespace aluminate::cost
