#include "shading/compiler/lowerer.hpp"

#include <spirv/unified1/GLSL.std.450.h>

#include <cmath>

namespace aluminate::compiler {

using vm::Opcode;

Lanes Lowerer::normalize(const Lanes& v) {
  const Ref scale = b_.op1(Opcode::Rsq, b_.dot(v, v));
  return b_.mul(v, scale);
}

// Whole powers whose products cost no more than log, mul, exp become products.
Lanes Lowerer::power(const Lanes& x, const Lanes& y) {
  const auto e = b_.value_of(y[0]);
  bool same = e.has_value();
  for (Ref r : y) same = same && b_.value_of(r) == e;
  if (same && *e == 0) return splat(num(1), x.size);
  if (same && *e == 0.5) return b_.op(Opcode::Sqrt, x);
  if (same && *e == -0.5) return b_.op(Opcode::Rsq, x);
  const double n = same ? std::fabs(*e) : 0;
  if (n == 1 || n == 2 || n == 3 || n == 4 || n == 5 || n == 6 || n == 8) {
    Lanes result = x, square = x;
    bool have = false;
    for (int bits = static_cast<int>(n);;) {
      if ((bits & 1) != 0) {
        result = have ? b_.mul(result, square) : square;
        have = true;
      }
      bits >>= 1;
      if (bits == 0) break;
      square = b_.mul(square, square);
    }
    return *e < 0 ? b_.op(Opcode::Rcp, result) : result;
  }
  return b_.op(Opcode::Exp, b_.mul(b_.op(Opcode::Log, x), y));
}

// acos(x) = sqrt(1 - |x|) p(|x|), mirrored for x < 0 [AS64 4.4.45]: absolute error below 6.8e-5.
Lanes Lowerer::arc_cosine(const Lanes& x) {
  Lanes a = x;
  for (Ref& r : a) r = b_.value_of(r) ? num(std::fabs(*b_.value_of(r))) : absolute(r);
  Lanes p = b_.add(b_.mul(a, num(-0.0187293)), num(0.0742610));
  p = b_.add(b_.mul(p, a), num(-0.2121144));
  p = b_.add(b_.mul(p, a), num(1.5707288));
  const Lanes positive = b_.mul(b_.op(Opcode::Sqrt, b_.sub(num(1), a)), p);
  return b_.choose(b_.op(Opcode::Sge, x, num(0)), positive, b_.sub(num(3.14159265358979), positive));
}

// atan on [0, 1] as an odd polynomial [AS64 4.4.49], absolute error below 2e-8; above 1: pi/2 - atan(1/x).
Lanes Lowerer::arc_tangent(const Lanes& x) {
  Lanes a = x;
  for (Ref& r : a) r = b_.value_of(r) ? num(std::fabs(*b_.value_of(r))) : absolute(r);
  const Lanes low = b_.op(Opcode::Min, a, num(1)), high = b_.op(Opcode::Max, a, num(1));
  const Lanes t = b_.mul(low, b_.op(Opcode::Rcp, high));
  const Lanes s = b_.mul(t, t);
  Lanes p = num(0.0028662257);
  for (double k :
       {-0.0161657367, 0.0429096138, -0.0752896400, 0.1065626393, -0.1420889944, 0.1999355085, -0.3333314528})
    p = b_.add(b_.mul(p, s), num(k));
  p = b_.add(b_.mul(b_.mul(p, s), t), t);
  p = b_.choose(b_.op(Opcode::Sgt, a, num(1)), b_.sub(num(1.57079632679490), p), p);
  return b_.choose(b_.op(Opcode::Sge, x, num(0)), p, negated(p));
}

void Lowerer::glsl_std(const SpirvInstruction& i) {
  const std::uint32_t op = i.operands[1];
  const auto arg = [&](std::size_t k) { return vec(i.operands[2 + k]); };
  if (m_.scalar_count(i.type) <= 4 && (glsl_geometric(op, i) || glsl_transcendental(op, i))) return;
  const auto magnitude = [&](Lanes v) {
    for (Ref& r : v) r = b_.value_of(r) ? num(std::fabs(*b_.value_of(r))) : absolute(r);
    return v;
  };
  switch (op) {
    case GLSLstd450FAbs:
    case GLSLstd450SAbs:
      define(i, magnitude(arg(0)));
      return;
    case GLSLstd450FSign:
    case GLSLstd450SSign:
      define(i, b_.op(Opcode::CndGt, arg(0), num(1), b_.op(Opcode::CndGe, arg(0), num(0), num(-1))));
      return;
    case GLSLstd450Floor:
      define(i, b_.floor(arg(0)));
      return;
    case GLSLstd450Ceil:
      define(i, negated(b_.floor(negated(arg(0)))));
      return;
    case GLSLstd450Fract:
      define(i, b_.op(Opcode::Frc, arg(0)));
      return;
    case GLSLstd450Trunc:
      define(i, b_.op(Opcode::Trunc, arg(0)));
      return;
    case GLSLstd450Round:
      define(i, b_.floor(b_.add(arg(0), num(0.5))));
      return;
    case GLSLstd450RoundEven: {
      // floor(x + 1/2), one less where that is an odd number met exactly halfway
      const Lanes x = arg(0), up = b_.floor(b_.add(x, num(0.5)));
      const Lanes halfway = b_.op(Opcode::Seq, b_.sub(up, x), num(0.5));
      const Lanes odd = b_.mul(b_.op(Opcode::Frc, b_.mul(up, num(0.5))), num(2));
      define(i, b_.sub(up, b_.mul(halfway, odd)));
      return;
    }
    case GLSLstd450FMin:
    case GLSLstd450NMin:
    case GLSLstd450SMin:
    case GLSLstd450UMin: {
      const Lanes x = arg(0), y = arg(1);
      // min(max(x, 0), 1) is the saturate modifier, whichever way round it is written
      for (const auto& [v, bound] : {std::pair(x, y), std::pair(y, x)}) {
        if (!b_.all_constant(bound, 1)) continue;
        const Node n = b_.node(v[0]);
        bool one = is_instruction(n) && n.op == Opcode::Max && !n.saturate && n.width == v.size;
        for (int k = 0; k < v.size; ++k)
          one = one && v[k] == Ref{v[0].node, static_cast<std::uint8_t>(k), false, false};
        if (!one) continue;
        if (b_.all_constant(n.src[1], 0)) return define(i, b_.saturate(n.src[0]));
        if (b_.all_constant(n.src[0], 0)) return define(i, b_.saturate(n.src[1]));
      }
      define(i, b_.op(Opcode::Min, x, y));
      return;
    }
    case GLSLstd450FMax:
    case GLSLstd450NMax:
    case GLSLstd450SMax:
    case GLSLstd450UMax: {
      const Lanes x = arg(0), y = arg(1);
      for (const auto& [v, bound] : {std::pair(x, y), std::pair(y, x)}) {
        if (!b_.all_constant(bound, 0)) continue;
        const Node n = b_.node(v[0]);
        bool one = is_instruction(n) && n.op == Opcode::Min && !n.saturate && n.width == v.size;
        for (int k = 0; k < v.size; ++k)
          one = one && v[k] == Ref{v[0].node, static_cast<std::uint8_t>(k), false, false};
        if (!one) continue;
        if (b_.all_constant(n.src[1], 1)) return define(i, b_.saturate(n.src[0]));
        if (b_.all_constant(n.src[0], 1)) return define(i, b_.saturate(n.src[1]));
      }
      define(i, b_.op(Opcode::Max, x, y));
      return;
    }
    case GLSLstd450FClamp:
    case GLSLstd450NClamp:
    case GLSLstd450SClamp:
    case GLSLstd450UClamp:
      define(i, clamp(arg(0), arg(1), arg(2)));
      return;
    case GLSLstd450FMix:
      define(i, mix(arg(0), arg(1), arg(2)));
      return;
    case GLSLstd450Step:
      define(i, b_.op(Opcode::Sge, arg(1), arg(0)));
      return;
    case GLSLstd450SmoothStep: {
      const Lanes t = b_.saturate(b_.divide(b_.sub(arg(2), arg(0)), b_.sub(arg(1), arg(0))));
      define(i, b_.mul(b_.mul(t, t), b_.add(b_.mul(t, num(-2)), num(3))));
      return;
    }
    case GLSLstd450Fma:
      define(i, b_.add(b_.mul(arg(0), arg(1)), arg(2)));
      return;
    case GLSLstd450Radians:
      define(i, b_.mul(arg(0), num(0.017453292519943295)));
      return;
    case GLSLstd450Degrees:
      define(i, b_.mul(arg(0), num(57.29577951308232)));
      return;
    case GLSLstd450InterpolateAtCentroid:
      refuse(i, "InterpolateAtCentroid", "interpolate at the pixel centre");
    default:
      refuse(i, glsl_std_name(op),
             op == GLSLstd450MatrixInverse || op == GLSLstd450Determinant
                 ? "compute it outside the shader and pass it in"
                 : "");
  }
}

bool Lowerer::glsl_transcendental(std::uint32_t op, const SpirvInstruction& i) {
  constexpr double kLog2E = 1.4426950408889634, kLn2 = 0.6931471805599453;
  const auto arg = [&](std::size_t k) { return vec(i.operands[2 + k]); };
  switch (op) {
    case GLSLstd450Sqrt:
      define(i, b_.op(Opcode::Sqrt, arg(0)));
      return true;
    case GLSLstd450InverseSqrt:
      define(i, b_.op(Opcode::Rsq, arg(0)));
      return true;
    case GLSLstd450Exp2:
      define(i, b_.op(Opcode::Exp, arg(0)));
      return true;
    case GLSLstd450Log2:
      define(i, b_.op(Opcode::Log, arg(0)));
      return true;
    case GLSLstd450Exp:
      define(i, b_.op(Opcode::Exp, b_.mul(arg(0), num(kLog2E))));
      return true;
    case GLSLstd450Log:
      define(i, b_.mul(b_.op(Opcode::Log, arg(0)), num(kLn2)));
      return true;
    case GLSLstd450Pow:
      define(i, power(arg(0), arg(1)));
      return true;
    case GLSLstd450Ldexp:
      define(i, b_.mul(arg(0), b_.op(Opcode::Exp, arg(1))));
      return true;
    case GLSLstd450Sin:
      define(i, b_.op(Opcode::Sin, arg(0)));
      return true;
    case GLSLstd450Cos:
      define(i, b_.op(Opcode::Cos, arg(0)));
      return true;
    case GLSLstd450Tan:
      define(i, b_.divide(b_.op(Opcode::Sin, arg(0)), b_.op(Opcode::Cos, arg(0))));
      return true;
    case GLSLstd450Acos:
      define(i, arc_cosine(arg(0)));
      return true;
    case GLSLstd450Asin:
      define(i, b_.sub(num(1.5707963267949), arc_cosine(arg(0))));
      return true;
    case GLSLstd450Atan:
      define(i, arc_tangent(arg(0)));
      return true;
    case GLSLstd450Atan2: {
      // atan(y/x), moved by pi with the sign of y on the left half plane
      const Lanes y = arg(0), x = arg(1);
      const Lanes right = arc_tangent(b_.divide(y, x));
      const Lanes turn =
          b_.choose(b_.op(Opcode::Sge, y, num(0)), num(3.14159265358979), num(-3.14159265358979));
      define(i, b_.choose(b_.op(Opcode::Sge, x, num(0)), right, b_.add(right, turn)));
      return true;
    }
    case GLSLstd450Sinh:
    case GLSLstd450Cosh:
    case GLSLstd450Tanh: {
      const Lanes e = b_.op(Opcode::Exp, b_.mul(arg(0), num(kLog2E))), inverse = b_.op(Opcode::Rcp, e);
      const Lanes sum = b_.add(e, inverse), difference = b_.sub(e, inverse);
      if (op == GLSLstd450Sinh)
        define(i, b_.mul(difference, num(0.5)));
      else if (op == GLSLstd450Cosh)
        define(i, b_.mul(sum, num(0.5)));
      else
        define(i, b_.divide(difference, sum));
      return true;
    }
    case GLSLstd450Asinh: {  // odd: of |x|, so that nothing cancels
      Lanes x = arg(0);
      const Lanes negative = b_.op(Opcode::Sgt, num(0), x);
      for (Ref& r : x) r = b_.value_of(r) ? num(std::fabs(*b_.value_of(r))) : absolute(r);
      const Lanes root = b_.op(Opcode::Sqrt, b_.add(b_.mul(x, x), num(1)));
      const Lanes result = b_.mul(b_.op(Opcode::Log, b_.add(x, root)), num(kLn2));
      define(i, b_.choose(negative, negated(result), result));
      return true;
    }
    case GLSLstd450Acosh: {
      const Lanes x = arg(0);
      const Lanes root = b_.op(Opcode::Sqrt, b_.add(b_.mul(x, x), num(-1)));
      define(i, b_.mul(b_.op(Opcode::Log, b_.add(x, root)), num(kLn2)));
      return true;
    }
    case GLSLstd450Atanh: {
      const Lanes x = arg(0);
      const Lanes ratio = b_.divide(b_.add(x, num(1)), b_.sub(num(1), x));
      define(i, b_.mul(b_.op(Opcode::Log, ratio), num(kLn2 / 2)));
      return true;
    }
    default:
      return false;
  }
}

bool Lowerer::glsl_geometric(std::uint32_t op, const SpirvInstruction& i) {
  const auto arg = [&](std::size_t k) { return vec(i.operands[2 + k]); };
  const auto length = [&](const Lanes& v) -> Lanes {
    if (v.size == 1)
      return b_.value_of(v[0]) ? Lanes(num(std::fabs(*b_.value_of(v[0])))) : Lanes(absolute(v[0]));
    return b_.op(Opcode::Sqrt, b_.dot(v, v));
  };
  switch (op) {
    case GLSLstd450Length:
      define(i, length(arg(0)));
      return true;
    case GLSLstd450Distance:
      define(i, length(b_.sub(arg(0), arg(1))));
      return true;
    case GLSLstd450Normalize:
      define(i, normalize(arg(0)));
      return true;
    case GLSLstd450Cross: {
      const Lanes a = arg(0), b = arg(1);
      const auto turn = [](const Lanes& v, int first) {
        Lanes r;
        for (int k = 0; k < 3; ++k) r.push(v[(first + k) % 3]);
        return r;
      };
      define(i, b_.sub(b_.mul(turn(a, 1), turn(b, 2)), b_.mul(turn(a, 2), turn(b, 1))));
      return true;
    }
    case GLSLstd450Reflect: {
      const Lanes incident = arg(0), n = arg(1);
      const Lanes d = b_.mul(b_.dot(n, incident), num(2));
      define(i, b_.sub(incident, b_.mul(n, d)));
      return true;
    }
    case GLSLstd450Refract: {
      // k = 1 - eta^2 (1 - (n.i)^2); k < 0 ? 0 : eta i - (eta n.i + sqrt k) n
      const Lanes incident = arg(0), n = arg(1), eta = arg(2);
      const Lanes d = b_.dot(n, incident);
      const Lanes k = b_.sub(num(1), b_.mul(b_.mul(eta, eta), b_.sub(num(1), b_.mul(d, d))));
      const Lanes bend = b_.add(b_.mul(eta, d), b_.op(Opcode::Sqrt, k));
      const Lanes bent = b_.sub(b_.mul(incident, eta), b_.mul(n, bend));
      define(i, b_.choose(b_.op(Opcode::Sge, k, num(0)), bent, splat(num(0), n.size)));
      return true;
    }
    case GLSLstd450FaceForward: {
      const Lanes n = arg(0);
      define(i, b_.choose(b_.op(Opcode::Sgt, num(0), b_.dot(arg(2), arg(1))), n, negated(n)));
      return true;
    }
    default:
      return false;
  }
}

}  // namespace aluminate::compiler
