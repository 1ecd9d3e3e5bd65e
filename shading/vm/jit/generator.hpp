// Decoded program -> LLVM IR. One function: void kernel(NativeFrame*).
//   Rows live in memory between stretches of code and in vector registers inside them; a stretch ends at a texture fetch
//   and at control flow. Each operation is written out for all lanes of a step before the next one, which gives the
//   processor independent work; a step is `width` lanes, and a stretch is repeated for as many steps as the batch has.
#pragma once

#include <llvm/IR/Module.h>

#include "shading/vm/range_plan.hpp"

namespace aluminate::vm::jit {

inline constexpr const char* kFunctionName = "kernel";


struct Form {
  unsigned vector_lanes = 8;  // doubles in one register of the target, 4 or 8
  unsigned width = 8;         // lanes of a step: a multiple of vector_lanes and a divisor of 64
  unsigned stretch = 48;      // operations of a stretch at most
  unsigned window = 1;        // of schedule()
};

void generate(const Decoded& decoded, const RangePlan& ranges, const Form& form, llvm::Module& module);

}  // namespace aluminate::vm::jit
