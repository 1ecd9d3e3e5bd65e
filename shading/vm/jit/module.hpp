// The border of the compiler module, a shared library opened on first use: nothing else of the project sees LLVM.
//   in   a decoded program, what its values are known to be, the wanted width
//   out  a block of machine code for this processor, or why there is none
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "shading/vm/range_plan.hpp"

namespace aluminate::vm::jit {

struct CompileRequest {
  const Decoded* decoded = nullptr;
  const RangePlan* ranges = nullptr;
  std::uint32_t width = 8;     // lanes of one step
  std::uint32_t stretch = 48;  // operations computed for one step before the next
  std::uint32_t window = 1;    // how far operations may overtake each other
  int level = 1;             // of LLVM's code generator, 0..3
  /// Once set, the compiling thread stops for good at the next chance: the process is about to end.
  const std::atomic<bool>* abandon = nullptr;
  /// Set by the thread when it has stopped.
  std::atomic<bool>* abandoned = nullptr;
  bool listing = false;      // also write what was made
};

struct CompileResult {
  std::vector<std::uint8_t> code;  // empty: `problem` says why
  std::string problem;
  std::string ir, assembly;        // listing
};

struct Module {
  CompileResult (*compile)(const CompileRequest&);
  std::uint32_t (*vector_lanes)();  // doubles in a register of this processor
};

using ModuleEntry = const Module* (*)();
inline constexpr const char* kModuleFile = "libaluminate_jit_module.so";
inline constexpr const char* kModuleEntry = "aluminate_jit_module";

}  // namespace aluminate::vm::jit
