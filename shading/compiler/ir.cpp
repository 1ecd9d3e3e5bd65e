#include "shading/compiler/ir.hpp"

namespace aluminate::compiler {

using vm::Opcode;

Lanes splat(Ref r, int width) {
  Lanes v;
  for (int i = 0; i < width; ++i) v.push(r);
  return v;
}

Lanes negated(Lanes v) {
  for (Ref& r : v) r.negate = !r.negate;
  return v;
}

bool is_kill(Opcode op) {
  return op == Opcode::KillGt || op == Opcode::KillGe || op == Opcode::KillNe || op == Opcode::KillEq;
}

bool is_fetch(Opcode op) { return vm::info(op).pipe == vm::Pipe::Fetch; }

bool is_texture(Opcode op) {
  return op == Opcode::Tex || op == Opcode::TexBias || op == Opcode::TexLod || op == Opcode::TexGrad;
}

bool is_scalar_pipe(Opcode op) { return vm::info(op).pipe == vm::Pipe::Scalar; }

bool is_reduction(Opcode op) {
  return is_scalar_pipe(op) || op == Opcode::Dp2Add || op == Opcode::Dp3 || op == Opcode::Dp4;
}

bool has_effect(const Node& n) {
  return is_instruction(n) && (n.sink != Sink::Value || is_flow(n) || is_kill(n.op));
}

}  // namespace aluminate::compiler
