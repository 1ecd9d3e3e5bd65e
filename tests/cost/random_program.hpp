// Valid programs from a seed: every operation, every source modifier, fetches of every dimension, branches
// and loops.
#pragma once

#include "shading/vm/program.hpp"

#include <cstdint>

namespace aluminate::test {

struct RandomShape {
  int instructions = 40;
  bool flow = false;  // If/Else, counted loops, Break
  bool fetches = true;
  bool relative = false;  // constants addressed by a temp or the loop counter
};

vm::Program random_program(std::uint32_t seed, const RandomShape& shape);

}  // namespace aluminate::test
