// What a finished program may not exceed, whichever language it came from: nesting the machine has room for, and work
// that counted loops promise. In: a program. Out: nothing, or a UserError at the instruction's line.
#pragma once

#include "shading/vm/program.hpp"

namespace aluminate::compiler {

void check_limits(const vm::Program& program);

}  // namespace aluminate::compiler
