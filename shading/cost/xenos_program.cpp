#include "shading/cost/xenos_program.hpp"

#include "shading/cost/xenos_lowering.hpp"

namespace aluminate::cost {

ScheduledProgram schedule_program(const vm::Program& program, PairingRule pairing) {
  ScheduledProgram result;
  result.blocks = vm::find_blocks(program);
  const std::vector<std::uint8_t> homes = components_across_blocks(program, result.blocks);
  for (const vm::Block& block : result.blocks) {
    ScheduledBlock best;
    bool first = true;
    for (Packing packing : {Packing::OffCriticalPath, Packing::Off, Packing::Everything}) {
      ScheduledBlock candidate;
      candidate.graph = lower_block(program, block, homes, packing);
      candidate.schedule = schedule_block(candidate.graph, pairing);
      if (first || candidate.schedule.words < best.schedule.words) best = std::move(candidate);
      first = false;
    }
    result.scheduled.push_back(std::move(best));
  }
  result.registers = assign_registers(program, result.blocks, homes, result.scheduled);
  return result;
}

}  // namespace aluminate::cost
