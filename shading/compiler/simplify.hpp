// Peepholes on an Ir: constants collected through sums and products, mad and dp2add, saturate as a modifier,
// dead components and dead code. Never changes how often a value is computed: nothing moves, except that the
// product of a mad is computed where the sum is.
#pragma once

#include "shading/compiler/ir.hpp"

namespace aluminate::compiler {

void simplify(Ir& ir);

}  // namespace aluminate::compiler
