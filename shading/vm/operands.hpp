// Which components an instruction reads, and how its result comes about: the facts isa.def states in words.
#pragma once

#include <cstdint>

#include "shading/vm/program.hpp"

namespace aluminate::vm {

enum class Shape : std::uint8_t {
  PerComponent,  // each result component from the same position of every source
  Dot,           // one number, replicated to the write mask: positions of a dot product
  ScalarUnit,    // one number from position x of the source, replicated
  Texture,       // four numbers from coordinates
  Test,          // no result: position x of every source decides (Kill, If, Break, Continue)
  Marker,        // no operands
};

constexpr Shape shape_of(Opcode op) {
  switch (op) {
    case Opcode::Dp2Add:
    case Opcode::Dp3:
    case Opcode::Dp4: return Shape::Dot;
    case Opcode::Tex:
    case Opcode::TexBias:
    case Opcode::TexLod:
    case Opcode::TexGrad: return Shape::Texture;
    case Opcode::KillGt:
    case Opcode::KillGe:
    case Opcode::KillNe:
    case Opcode::KillEq:
    case Opcode::If:
    case Opcode::Break:
    case Opcode::Continue: return Shape::Test;
    case Opcode::Else:
    case Opcode::EndIf:
    case Opcode::Loop:
    case Opcode::EndLoop: return Shape::Marker;
    default: return info(op).pipe == Pipe::Scalar ? Shape::ScalarUnit : Shape::PerComponent;
  }
}

constexpr bool is_kill(Opcode op) {
  return op == Opcode::KillGt || op == Opcode::KillGe || op == Opcode::KillNe || op == Opcode::KillEq;
}

/// Reads other lanes of the quad: their registers count whatever the mask.
constexpr bool reads_quad(Opcode op) {
  return op == Opcode::DsX || op == Opcode::DsY || op == Opcode::Tex || op == Opcode::TexBias;
}

/// Positions (bit 0 = x .. bit 3 = w, before the swizzle) that source `index` reads when the result components in
/// `result_mask` are wanted. Position p reads component swizzle[p].
inline std::uint8_t positions_read(const Program& program, const Instruction& i, int index, std::uint8_t result_mask) {
  switch (shape_of(i.op)) {
    case Shape::PerComponent: return result_mask;
    case Shape::Dot:
      if (result_mask == 0) return 0;
      if (i.op == Opcode::Dp2Add) return index == 2 ? 0x1 : 0x3;
      return i.op == Opcode::Dp3 ? 0x7 : 0xf;
    case Shape::ScalarUnit: return result_mask != 0 ? 0x1 : 0;
    case Shape::Texture: {  // a fetch costs time whether its result is used or not, so it always runs
      const std::uint8_t coordinates = program.samplers[i.sampler].dimension == SamplerDimension::Tex2D ? 0x3 : 0x7;
      const bool has_level = index == 0 && (i.op == Opcode::TexBias || i.op == Opcode::TexLod);
      return static_cast<std::uint8_t>(coordinates | (has_level ? 0x8 : 0));
    }
    case Shape::Test: return 0x1;
    case Shape::Marker: break;
  }
  return 0;
}

}  // namespace aluminate::vm
