#include "shading/cost/xenos_program.hpp"

#include "shading/cost/xenos_lowering.hpp"

#include <algorithm>
#include <array>

namespace aluminate::cost {
namespace {

constexpr int kNearly = 1;  // words

}  // namespace

ScheduledProgram schedule_program(const vm::Program& program, PairingRule pairing) {
  ScheduledProgram result;
  result.blocks = vm::find_blocks(program);
  const std::vector<std::uint8_t> homes = components_across_blocks(program, result.blocks);
  for (const vm::Block& block : result.blocks) {
    // All three quickly; then the shortest with all effort, and those that nearly were.
    constexpr Packing kPackings[] = {Packing::OffCriticalPath, Packing::Off, Packing::Everything};
    std::array<Graph, 3> graphs;
    std::array<int, 3> quick{};
    for (std::size_t i = 0; i < 3; ++i) {
      graphs[i] = lower_block(program, block, homes, kPackings[i]);
      quick[i] = schedule_block(graphs[i], pairing, Effort::Plain).words;
    }
    const int shortest = *std::min_element(quick.begin(), quick.end());
    ScheduledBlock best;
    bool first = true;
    for (std::size_t i = 0; i < 3; ++i) {
      if (quick[i] > shortest + kNearly) continue;
      ScheduledBlock candidate;
      candidate.graph = std::move(graphs[i]);
      candidate.schedule = schedule_block(candidate.graph, pairing, Effort::Full);
      if (first || candidate.schedule.words < best.schedule.words) best = std::move(candidate);
      first = false;
    }
    result.scheduled.push_back(std::move(best));
  }
  result.registers = assign_registers(program, result.blocks, homes, result.scheduled);
  return result;
}

}  // namespace aluminate::cost
