// Arithmetic on literals, in IEEE binary64 operations only.
#pragma once

#include "shading/vm/program.hpp"

#include <optional>

namespace aluminate::compiler {

/// The operation on numbers known at compile time; nothing when it has to stay an instruction (textures, sin,
/// ...).
std::optional<double> fold(vm::Opcode op, double a, double b, double c);

/// 2^x and log2(x), x > 0, from their series: no libm, error below 2^-50 relative. Range of exp2_series: |x|
/// <= 60.
double exp2_series(double x);
double log2_series(double x);

}  // namespace aluminate::compiler
