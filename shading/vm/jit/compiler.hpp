// From a decoded program to code that can run, with nothing kept: the caches are in jit/code_cache.hpp.
//   in   a decoded program, what to assume of its inputs, the width
//   out  code, or the reason why this machine has none; the interpreter then does the work
#pragma once

#include <memory>
#include <string>

#include "platform/host/hash.hpp"
#include "shading/vm/jit/module.hpp"
#include "shading/vm/jit/native.hpp"

namespace aluminate::vm::jit {

struct Compiled {
  std::vector<std::uint8_t> code;
  Native::Description description;
  std::string problem;         // of an empty code
  std::string ir, assembly;    // CompileOptions::listing
};

/// Lanes of one step, operations of one stretch, and how far operations may overtake each other in it. Wider steps and
/// windows hide latency; a stretch is run once for every step of a batch, so that its code, about 100 bytes an operation,
/// comes from the first-level cache in all steps but one. Figures: bench/shader_bench, docs/performance.md.
inline constexpr std::uint32_t kWidth = 16;
inline constexpr std::uint32_t kStretch = 64;
inline constexpr std::uint32_t kWindow = 48;

struct CompileOptions {
  Assume assume = Assume::Typical;
  std::uint32_t width = kWidth;  // 8 .. 64
  std::uint32_t stretch = kStretch;
  std::uint32_t window = kWindow;
  int level = 1;                 // of LLVM's code generator
  bool listing = false;
};

/// Opens the compiler module on the first call. Never throws: what goes wrong is in `problem`.
Compiled compile(const Decoded& decoded, const CompileOptions& options) noexcept;

/// Of everything but the program that decides what code comes out: the module's own bytes, LLVM, the processor.
const host::Hash128& compiler_identity();

/// The process is about to end: compiling threads stop at their next step. Returns when they have.
void abandon_compilation() noexcept;

}  // namespace aluminate::vm::jit
