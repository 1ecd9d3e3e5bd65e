// An independent look at a schedule: knows the machine's rules and nothing of how the scheduler works. Used
// by tests on random programs and by anyone who changes the scheduler.
#pragma once

#include "shading/cost/static_cost.hpp"
#include "shading/cost/xenos_program.hpp"

#include <string>
#include <vector>

namespace aluminate::cost {

/// Every rule that is broken, in words; empty when the schedule is legal:
///   each operation issues exactly once, results before readers, reads of overwritten registers before the
///   write vector and scalar halves hold operations of their class; three-operand operations and predicates
///   stand alone a scalar half reads one register, one constant, or a constant and a register; _prev directly
///   follows its movs at most two constant and three temporary registers a word; one export register a word
///   an operand comes from one register; no component is overwritten while its value is still to be read
///   clauses hold at most six issues
std::vector<std::string> broken_rules(const vm::Program& program, const ScheduledProgram& scheduled,
                                      PairingRule pairing);

}  // namespace aluminate::cost
