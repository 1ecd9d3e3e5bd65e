// Which way a program runs. All ways give the same bits and counts, so this is about time only.
//   in   an executable and the user's wish
//   out  code in its slot, now or later
#pragma once

#include "shading/vm/executable.hpp"
#include "shading/vm/range_plan.hpp"

namespace aluminate::vm::jit {

enum class Tier : std::uint8_t {
  Interpreter,
  Jit,   // compiled before select_tier() returns
  Auto,  // kept code at once; else interpreted until there has been so much work that compiling pays, then compiled on
         // another thread while the interpreter goes on
};

/// Interpreted batches of 64 after which compiling a program pays: then interpreting has cost about as much as compiling
/// will, so the sum is never more than twice the better choice. Both grow with the length of the program. Measured:
/// 0.3 ms to compile one operation, 15 ns to interpret it for a batch.
inline constexpr std::int64_t kPatienceBatches = 20000;

/// Takes effect for every copy of the executable. Where code cannot be made the interpreter goes on; --vm jit says so.
void select_tier(const Executable& executable, Tier tier);

/// Compiles now and publishes; for batches that used up the patience, on the background thread. Called by run().
void compile_later(const Executable& executable, Assume assume) noexcept;

/// Until the background thread has nothing to do. For tests and benchmarks.
void wait_for_background();

}  // namespace aluminate::vm::jit
