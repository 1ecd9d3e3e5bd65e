// Integers are numbers without a fraction. Every result below is exact while operands and results stay under
// 2^20 in magnitude, in every number format that can hold them; nothing wraps around.
#include "shading/compiler/lowerer.hpp"

#include <spirv/unified1/spirv.hpp11>

#include <bit>
#include <cmath>

namespace aluminate::compiler {

using vm::Opcode;

// Quotient towards zero. (|a| + 1/2) * rcp(|b|) is off the true quotient by less than one for |a|, |b| < 2^20
// on any grid of 2^-16 or finer, so its floor is at most one away; one comparison of the remainder on each
// side settles it.
Lanes Lowerer::divide_integers(const Lanes& a, const Lanes& b, bool is_signed) {
  Lanes n = a, d = b;
  if (is_signed) {
    for (Ref& r : n) r = b_.value_of(r) ? num(std::fabs(*b_.value_of(r))) : absolute(r);
    for (Ref& r : d) r = b_.value_of(r) ? num(std::fabs(*b_.value_of(r))) : absolute(r);
  }
  bool power_of_two = true;
  for (Ref r : d) {
    const auto v = b_.value_of(r);
    power_of_two = power_of_two && v && *v >= 1 && *v <= 0x1p16 &&
                   std::has_single_bit(static_cast<std::uint32_t>(*v)) && *v == std::floor(*v);
  }
  if (power_of_two) {
    const Lanes scaled = b_.mul(a, b_.op(Opcode::Rcp, d));
    const Lanes q = is_signed ? b_.op(Opcode::Trunc, scaled) : b_.floor(scaled);
    if (!is_signed) return q;
    return b_.choose(b_.op(Opcode::Sge, b, num(0)), q, negated(q));
  }
  Lanes q = b_.floor(b_.mul(b_.add(n, num(0.5)), b_.op(Opcode::Rcp, d)));
  const Lanes rest = b_.sub(n, b_.mul(q, d));
  q = b_.add(q, b_.op(Opcode::Sge, rest, d));
  q = b_.sub(q, b_.op(Opcode::Sgt, num(0), rest));
  if (!is_signed) return q;
  q = b_.choose(b_.op(Opcode::Sge, a, num(0)), q, negated(q));
  return b_.choose(b_.op(Opcode::Sge, b, num(0)), q, negated(q));
}

bool Lowerer::integer_arithmetic(const SpirvInstruction& i) {
  const auto op = static_cast<spv::Op>(i.op);
  const auto a = [&] { return vec(i.operands[0]); };
  const auto b = [&] { return vec(i.operands[1]); };
  // The value every component of an operand has, when it is known.
  const auto known = [&](SpvId id) -> std::optional<double> {
    const Lanes v = vec(id);
    const auto first = b_.value_of(v[0]);
    for (Ref r : v)
      if (b_.value_of(r) != first) return std::nullopt;
    return first;
  };
  switch (op) {
    case spv::Op::OpSNegate:
      define(i, negated(a()));
      return true;
    case spv::Op::OpIAdd:
      define(i, b_.add(a(), b()));
      return true;
    case spv::Op::OpISub:
      define(i, b_.sub(a(), b()));
      return true;
    case spv::Op::OpIMul:
      define(i, b_.mul(a(), b()));
      return true;
    case spv::Op::OpSDiv:
    case spv::Op::OpUDiv:
      define(i, divide_integers(a(), b(), op == spv::Op::OpSDiv));
      return true;
    case spv::Op::OpSRem:
    case spv::Op::OpUMod:
    case spv::Op::OpSMod: {
      const bool is_signed = op != spv::Op::OpUMod;
      Lanes rest = b_.sub(a(), b_.mul(b(), divide_integers(a(), b(), is_signed)));
      if (op == spv::Op::OpSMod &&
          !m_.is_hlsl()) {  // (HLSL's % truncates; glslang writes OpSMod for it) the sign of the divisor: add
                            // it once where the remainder has the other sign
        const Lanes opposite = b_.op(Opcode::Sgt, num(0), b_.mul(rest, b()));
        rest = b_.add(rest, b_.mul(b(), opposite));
      }
      define(i, rest);
      return true;
    }
    case spv::Op::OpConvertFToS:
    case spv::Op::OpConvertFToU:
      define(i, b_.op(Opcode::Trunc, a()));
      return true;
    case spv::Op::OpConvertSToF:
    case spv::Op::OpConvertUToF:
    case spv::Op::OpSConvert:
    case spv::Op::OpUConvert:
      define(i, value(i.operands[0]));
      return true;
    case spv::Op::OpBitcast: {
      const auto kind_of = [&](SpvId type) {
        const SpirvType& t = m_.type(type);
        return t.kind == SpirvType::Kind::Vector ? m_.type(t.element).kind : t.kind;
      };
      if (kind_of(i.type) != kind_of(m_.definition(i.operands[0])->type))
        refuse(i, "OpBitcast between float and int", "registers hold numbers, not bit patterns");
      define(i, value(i.operands[0]));
      return true;
    }
    case spv::Op::OpShiftLeftLogical:
    case spv::Op::OpShiftRightLogical:
    case spv::Op::OpShiftRightArithmetic: {
      const auto bits = known(i.operands[1]);
      if (!bits || *bits < 0 || *bits > 20)
        refuse(i, spirv_op_name(i.op) + " by a value that is not a constant from 0 to 20",
               "multiply or divide instead");
      const double factor = std::ldexp(1.0, static_cast<int>(*bits));
      define(i, op == spv::Op::OpShiftLeftLogical ? b_.mul(a(), num(factor))
                                                  : b_.floor(b_.mul(a(), num(1 / factor))));
      return true;
    }
    case spv::Op::OpBitwiseAnd: {
      SpvId x = i.operands[0];
      auto mask = known(i.operands[1]);
      if (!mask) {
        mask = known(i.operands[0]);
        x = i.operands[1];
      }
      const double size = mask ? *mask + 1 : 0;
      if (size < 2 || size > 0x1p16 || !std::has_single_bit(static_cast<std::uint32_t>(size)))
        refuse(i, "OpBitwiseAnd", "only masks of low bits (1, 3, 7, ...) have a meaning for numbers");
      // two's complement low bits: x - size * floor(x / size), also for negative x
      define(i, b_.mul(b_.op(Opcode::Frc, b_.mul(vec(x), num(1 / size))), num(size)));
      return true;
    }
    case spv::Op::OpBitwiseOr:
    case spv::Op::OpBitwiseXor:
    case spv::Op::OpNot:
    case spv::Op::OpBitFieldInsert:
    case spv::Op::OpBitFieldSExtract:
    case spv::Op::OpBitFieldUExtract:
    case spv::Op::OpBitReverse:
    case spv::Op::OpBitCount:
      refuse(i, spirv_op_name(i.op), "registers hold numbers, not bit patterns; use arithmetic");
    default:
      return false;
  }
}

}  // namespace aluminate::compiler
