// The slow, obvious interpreter: lane by lane, instruction by instruction, straight from Program::code and
// platform/number/scalar.hpp. It is the oracle of the fast one, and the tracer behind `aluminate pixel`.
//   in   the Program itself (nothing decoded) and the same Batch
//   out  the same bits in outputs, killed and counters
// Never used on a path that has to be fast; allocates as it likes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shading/vm/executable.hpp"

namespace aluminate::vm {

/// One executed instruction as one lane saw it, in execution order.
struct TraceEntry {
  std::uint32_t instruction = 0;        // index into Program::code
  std::array<double, 4> result{};       // components of the write mask; Kill and Flow: x = the condition as 0 or 1
  std::uint8_t mask = 0;                // components that were written; 0 for Kill and Flow
  std::uint8_t saturated = 0;           // components that were clamped to the range
};

struct Trace {
  int lane = 0;                         // 0..63; recorded whether covered or helper
  std::vector<TraceEntry> entries;
};

/// executable must come from prepare(program, format): it names rows and format. trace may be nullptr.
void run_reference(const Program& program, const Executable& executable, Batch& batch, Counters& counters,
                   Trace* trace = nullptr);

}  // namespace aluminate::vm
