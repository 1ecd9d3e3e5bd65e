// A whole program scheduled for the vec4+scalar machine: every block's graph, order and registers. The
// packing of rule 9 is tried at each strength and the shortest schedule of each block kept.
#pragma once

#include "shading/cost/xenos_registers.hpp"

namespace aluminate::cost {

struct ScheduledProgram {
  std::vector<vm::Block> blocks;
  std::vector<ScheduledBlock> scheduled;  // parallel to blocks
  RegisterMap registers;
};

ScheduledProgram schedule_program(const vm::Program& program, PairingRule pairing);

}  // namespace aluminate::cost
