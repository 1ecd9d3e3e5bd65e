// Direct3D 9 ps_3_0 instruction slots: the headline convention. Swizzles, write masks, negate, absolute and
// saturate are free; texture instructions are counted apart [MSD, MOJO].
#pragma once

#include "shading/vm/program.hpp"

#include <vector>

namespace aluminate::cost {

/// Arithmetic and flow slots of each instruction; 0 for texture instructions. A comparison that only feeds
/// the branch behind it is that branch's own: if_lt and break_lt compare two operands themselves [MSD].
std::vector<int> instruction_slots(const vm::Program& program);

/// texld 1 (cube 4), texldl 2 (cube 5), texldb 6, texldd 3; 0 for everything else.
constexpr int texture_slots(const vm::Program& program, const vm::Instruction& instruction) {
  const auto cube = [&] {
    return program.samplers[instruction.sampler].dimension == vm::SamplerDimension::TexCube;
  };
  switch (instruction.op) {
    case vm::Opcode::Tex:
      return cube() ? 4 : 1;
    case vm::Opcode::TexLod:
      return cube() ? 5 : 2;
    case vm::Opcode::TexBias:
      return 6;
    case vm::Opcode::TexGrad:
      return 3;
    default:
      return 0;
  }
}

constexpr bool is_texture(vm::Opcode op) {
  return op == vm::Opcode::Tex || op == vm::Opcode::TexBias || op == vm::Opcode::TexLod ||
         op == vm::Opcode::TexGrad;
}

}  // namespace aluminate::cost
