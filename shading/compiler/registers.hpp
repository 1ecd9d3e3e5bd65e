// Gives every value of an Ir its place: a virtual register and, for each component, a position in it.
// Components that are read together are put into one register where they can be; copies between a variable
// and the value that becomes it disappear where both may share a place. What remains becomes mov
// instructions, inserted into the list.
#pragma once

#include "shading/compiler/ir.hpp"

#include <map>

namespace aluminate::compiler {

struct Place {
  bool output = false;
  int reg = -1;
  std::array<std::uint8_t, 4> component{};  // of each lane
};

/// Rewrites ir (inserts movs, drops copies that became empty) and returns the place of every node that has
/// one. Afterwards every operand reads one register with one pair of modifiers; fetch operands read
/// temporaries or inputs.
std::map<NodeId, Place> assign_registers(Ir& ir, int& register_count);

}  // namespace aluminate::compiler
