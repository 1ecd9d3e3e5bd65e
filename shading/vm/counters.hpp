// What running a program cost: exact integer counts, so sums over threads and tiles do not depend on their order.
//   in   one Counters per worker, shaped by the Executable it counts for
//   out  counts per basic block and per instruction of Program::code; the cost model turns them into words and cycles
// Only covered lanes cost something on their own account; helper lanes are counted beside them.
#pragma once

#include <cstdint>
#include <vector>

namespace aluminate::vm {

class Executable;
struct Program;

struct BlockCount {
  std::uint64_t executions = 0;     // times the block ran for a batch with at least one lane
  std::uint64_t covered_lanes = 0;  // sum over executions of covered lanes
  std::uint64_t helper_lanes = 0;   // sum over executions of the other active lanes
  bool operator==(const BlockCount&) const = default;
};

struct Counters {
  std::vector<BlockCount> blocks;          // by index into find_blocks(program)
  std::vector<std::uint64_t> saturations;  // by index into Program::code: covered lanes x live components clamped
  std::uint64_t sanitised_inputs = 0;      // NaN, infinite or out-of-range input values replaced at the border
  std::uint64_t fetches = 0;               // texture instructions executed by covered lanes
  std::uint64_t fetch_cycles = 0;          // bilinear cycles of those: 2 where two mip levels are blended, else 1
  std::int32_t overrun_loop = -1;          // first Loop instruction that reached kLoopLimit; -1 = none

  Counters() = default;
  explicit Counters(const Executable& executable);
  Counters& operator+=(const Counters& other);
  bool operator==(const Counters&) const = default;
};

/// Iterations after which a loop is left and reported: a shader that never ends must not hang the machine.
inline constexpr int kLoopLimit = 65535;

/// Throws UserError naming the source line when a loop overran.
void raise_loop_overrun(const Program& program, const Counters& counters);

}  // namespace aluminate::vm
