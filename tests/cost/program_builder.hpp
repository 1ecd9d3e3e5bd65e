// Programs written as text in tests: one instruction a line, the same notation as the listing.
//   in COLOR0 xyzw; uniform tint 4; sampler tex0 2d; lit 1 2 0.5 0
//   tex r0, v0.xy, s0
//   mul_sat r1.xyz, r0.xyz, -|c0|.xxx
#pragma once

#include "shading/vm/program.hpp"

#include <string>

namespace aluminate::test {

/// Throws std::runtime_error naming the line it cannot read. The result is valid: vm::validate is called on
/// it.
vm::Program program_from_text(const std::string& text, const std::string& name = "test");

}  // namespace aluminate::test
