// Ir with registers assigned in, vm::Program out: swizzles, write masks, literal registers, symbol tables
// trimmed to what the code uses.
#pragma once

#include "shading/compiler/lower.hpp"

namespace aluminate::compiler {

/// Throws UserError when the program needs more registers than the format can number.
vm::Program emit(Lowered lowered);

}  // namespace aluminate::compiler
