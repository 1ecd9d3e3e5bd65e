#include "shading/compiler/fold.hpp"

#include <cmath>

namespace aluminate::compiler {
namespace {

constexpr double kLn2 = 0x1.62e42fefa39efp-1;

}  // namespace

double exp2_series(double x) {
  const double whole = std::floor(x);
  const double t = (x - whole) * kLn2;  // [0, ln 2): the 24th term is below 2^-90
  double term = 1, sum = 1;
  for (int k = 1; k < 24; ++k) {
    term = term * t / k;
    sum += term;
  }
  return std::ldexp(sum, static_cast<int>(whole));
}

double log2_series(double x) {
  int exponent = 0;
  double m = std::frexp(x, &exponent);  // [1/2, 1)
  if (m < 0.70710678118654752) {
    m *= 2;
    --exponent;
  }
  const double s = (m - 1) / (m + 1), ss = s * s;  // |s| < 0.172: the 24th term is below 2^-110
  double power = s, sum = 0;
  for (int k = 0; k < 24; ++k) {
    sum += power / (2 * k + 1);
    power *= ss;
  }
  return exponent + 2 * sum / kLn2;
}

std::optional<double> fold(vm::Opcode op, double a, double b, double c) {
  using vm::Opcode;
  switch (op) {
    case Opcode::Mov:
      return a;
    case Opcode::Add:
      return a + b;
    case Opcode::Mul:
      return a * b;
    case Opcode::Mad:
      return std::fma(a, b, c);
    case Opcode::Min:
      return a < b ? a : b;
    case Opcode::Max:
      return a >= b ? a : b;
    case Opcode::Frc:
      return a - std::floor(a);
    case Opcode::Flr:
      return std::floor(a);
    case Opcode::Trunc:
      return std::trunc(a);
    case Opcode::Sge:
      return a >= b ? 1 : 0;
    case Opcode::Sgt:
      return a > b ? 1 : 0;
    case Opcode::Seq:
      return a == b ? 1 : 0;
    case Opcode::Sne:
      return a != b ? 1 : 0;
    case Opcode::CndGe:
      return a >= 0 ? b : c;
    case Opcode::CndGt:
      return a > 0 ? b : c;
    case Opcode::CndEq:
      return a == 0 ? b : c;
    case Opcode::Rcp:
      return a != 0 ? std::optional(1 / a) : std::nullopt;
    case Opcode::Rsq:
      return a > 0 ? std::optional(1 / std::sqrt(a)) : std::nullopt;
    case Opcode::Sqrt:
      return a >= 0 ? std::sqrt(a) : 0.0;
    case Opcode::Exp:
      return std::fabs(a) <= 60 ? std::optional(exp2_series(a)) : std::nullopt;
    case Opcode::Log:
      return a > 0 ? std::optional(log2_series(a)) : std::nullopt;
    default:
      return std::nullopt;
  }
}

}  // namespace aluminate::compiler
