// Scheduled blocks to physical registers: 64 vec4 GPRs handed out one component at a time, as the period
// compiler did. Interpolants arrive in the first registers; a component is free again in the word that reads
// it last.
#pragma once

#include "shading/cost/schedule.hpp"
#include "shading/cost/xenos_graph.hpp"

#include <array>
#include <vector>

namespace aluminate::cost {

/// Where the lanes of a node's result are. gpr -1: the node writes no register.
struct Location {
  int gpr = -1;
  std::array<std::uint8_t, 4> component{};
};

struct ScheduledBlock {
  Graph graph;
  BlockSchedule schedule;
  std::vector<Location> results;  // parallel to graph.nodes
};

struct RegisterMap {
  std::vector<int> input_gpr;  // v# -> GPR, -1 when nothing reads it
  std::vector<int> home_gpr;   // temp -> GPR, -1 when it never crosses a block; components stay in place
  int gprs = 1;                // highest GPR + 1; 1 is the least a program can have
};

/// Fills `results` of every block. Any count is handed out: refusing more than the platform has is the
/// caller's.
RegisterMap assign_registers(const vm::Program& program, const std::vector<vm::Block>& blocks,
                             const std::vector<std::uint8_t>& homes, std::vector<ScheduledBlock>& scheduled);

}  // namespace aluminate::cost
