// The arithmetic of the machine, one scalar function per definition. This is the specification: literal IEEE binary64
// sequences in round-to-nearest-even; every other implementation must give the same bits.
//   in   finite operands, each a multiple of its own grid step
//   out  the rounded result before the range is enforced; finish() then clamps and tells whether it had to
//   never calls libm except fma and sqrt, which IEEE 754 defines to the last bit.
// In ref64 the magic constant is 0, which turns every rounding into the identity. Prose: docs/number_formats.md.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "platform/number/coefficients.hpp"
#include "platform/number/format.hpp"

namespace aluminate::number {

/// 1.5 * 2^52: adding and subtracting it rounds |x| < 2^51 to an integer, and the sum's low bits are that integer.
inline constexpr double kToInteger = 0x1.8p52;

/// R_f(x): nearest multiple of the step, ties to even. Exact for |x| < 2^(51-f); beyond that the result is still
/// monotone in x and lies outside the range, so finish() clamps it.
inline double to_grid(const Grid& g, double x) { return (x + g.magic) - g.magic; }

struct Ranged {
  double value;
  bool saturated;  // the result left the range and was clamped
};

/// Ends every instruction: the saturate modifier (which is no overflow) or the range of the grid (which is).
inline Ranged finish(const Grid& g, bool saturate, double v) {
  if (saturate) {
    v = v < 1.0 ? v : 1.0;
    return {v > 0.0 ? v : 0.0, false};
  }
  if (v > g.greatest) return {g.greatest, true};
  if (v < g.least) return {g.least, true};
  return {v, false};
}

/// What a value from outside becomes: NaN = 0, infinities and values out of range = the nearest end; both counted.
inline Ranged sanitise(const Grid& g, double x) {
  if (x != x) return {0.0, true};
  if (x > g.greatest) return {g.greatest, true};
  if (x < g.least) return {g.least, true};
  return {to_grid(g, x), false};
}

/// How an addition reaches one rounding, chosen before execution from the statically known grids of its operands.
enum class AddForm : unsigned char {
  Plain,     // both operands on the result's grid (or coarser): a + b is exact, or out of range
  RoundA,    // a is finer, b on the grid: ((b + M) + a) - M
  RoundB,    // b is finer, a on the grid: ((a + M) + b) - M
  RoundSum,  // both finer: ((a + b) + M) - M; a + b is exact when their grids are equal, as they are but in auto
};
inline AddForm add_form(int result_frac_bits, int a_frac_bits, int b_frac_bits) {
  const bool a_finer = a_frac_bits > result_frac_bits, b_finer = b_frac_bits > result_frac_bits;
  return a_finer ? (b_finer ? AddForm::RoundSum : AddForm::RoundA) : (b_finer ? AddForm::RoundB : AddForm::Plain);
}
inline double add(const Grid& g, AddForm form, double a, double b) {
  switch (form) {
    case AddForm::Plain: return a + b;
    case AddForm::RoundA: return ((b + g.magic) + a) - g.magic;
    case AddForm::RoundB: return ((a + g.magic) + b) - g.magic;
    case AddForm::RoundSum: break;
  }
  return ((a + b) + g.magic) - g.magic;
}

/// R_f(a*b): the integer product (A*B) / 2^(fa+fb-f), rounded once.
inline double mul(const Grid& g, double a, double b) { return std::fma(a, b, g.magic) - g.magic; }

/// R_f(a*b + R_f(c)): M + c rounds c to the grid when its own grid is finer and is exact otherwise.
inline double mad(const Grid& g, double a, double b, double c) { return std::fma(a, b, g.magic + c) - g.magic; }

/// Sum of products in order, each step rounded to the grid while the partial sum is in range.
/// c is the addend of dp2add, rounded like mad's; 0 for dp3 and dp4.
inline double dot(const Grid& g, std::span<const double> a, std::span<const double> b, double c) {
  double t = g.magic + c;
  for (std::size_t i = 0; i < a.size(); ++i) t = std::fma(a[i], b[i], t);
  return t - g.magic;
}

/// 1/x. Grids: binary32 reciprocal as a seed and one Newton step, relative error < 2^-45; then R_f. x = 0: beyond.
inline double rcp(const Grid& g, double x) {
  double y;
  if (g.magic != 0.0) {
    const double s = static_cast<double>(1.0f / static_cast<float>(x));
    y = std::fma(std::fma(-x, s, 1.0), s, s);  // x = 0: NaN, which fails the next comparison
  } else {
    y = x == 0.0 ? g.beyond : 1.0 / x;
  }
  y = y < g.beyond ? y : g.beyond;
  y = y > -g.beyond ? y : -g.beyond;
  return to_grid(g, y);
}

/// 1/sqrt(max(x, operand_step)): operand_step is the step of the grid x lies on, its smallest positive value.
inline double rsq(const Grid& g, double operand_step, double x) {
  x = x > operand_step ? x : operand_step;
  if (g.magic == 0.0) return 1.0 / std::sqrt(x);
  const double s = static_cast<double>(1.0f / std::sqrt(static_cast<float>(x)));
  const double e = std::fma(x * s, -s, 1.0);
  return to_grid(g, std::fma(0.5 * s, e, s));
}

inline double sqrt(const Grid& g, double x) { return to_grid(g, std::sqrt(x > 0.0 ? x : 0.0)); }

template <std::size_t N>
double horner(const double (&coefficient)[N], double x) {
  double sum = coefficient[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = std::fma(sum, x, coefficient[i]);
  return sum;
}

/// 2^x. n = rint(x), polynomial in x - n, then n is added to the exponent field.
inline double exp2(const Grid& g, double x) {
  x = x < g.exp2_greatest ? x : g.exp2_greatest;
  x = x > g.exp2_least ? x : g.exp2_least;
  const double k = x + kToInteger;
  const double r = x - (k - kToInteger);
  const double p = g.magic != 0.0 ? horner(kExp2, r) : horner(kExp2Reference, r);
  // |n| <= 1000 and p in (0.7, 1.5): the exponent field neither under- nor overflows.
  const double y = std::bit_cast<double>(std::bit_cast<std::uint64_t>(p) + (std::bit_cast<std::uint64_t>(k) << 52));
  return to_grid(g, y);
}

/// log2(max(x, operand_step)): x = 2^e m with m in [sqrt(1/2), sqrt(2)), s = (m-1)/(m+1), e + s q(s^2).
inline double log2(const Grid& g, double operand_step, double x) {
  x = x > operand_step ? x : operand_step;
  constexpr std::uint64_t kSplit = std::bit_cast<std::uint64_t>(kSqrtHalf);
  constexpr std::uint64_t kBias = std::uint64_t{1024} << 52;  // keeps e + 1024 positive: |e| < 1024
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  const std::uint64_t biased = (bits - kSplit + kBias) >> 52;
  const double m = std::bit_cast<double>(bits - (biased << 52) + kBias);
  const double e = std::bit_cast<double>(biased | std::bit_cast<std::uint64_t>(0x1p52)) - (0x1p52 + 1024.0);
  const double s = (m - 1.0) / (m + 1.0);
  const double z = s * s;
  const double q = g.magic != 0.0 ? horner(kLog2, z) : horner(kLog2Reference, z);
  return to_grid(g, std::fma(s, q, e));
}

/// Arguments of sin and cos beyond this are clamped to it; fx20 .. fx40 and qI.F never get there.
inline constexpr double kAngleGreatest = 0x1p31;

/// sin(x + quarter_turns * pi/2). Reduction by multiples of pi/2 in two fused steps; absolute error < 2^-51.
inline double sin_turned(const Grid& g, double x, unsigned quarter_turns) {
  x = x < kAngleGreatest ? x : kAngleGreatest;
  x = x > -kAngleGreatest ? x : -kAngleGreatest;
  const double k = std::fma(x, kTwoOverPi, kToInteger);
  const double n = k - kToInteger;
  const double r = std::fma(-n, kPiOver2Low, std::fma(-n, kPiOver2High, x));
  const double z = r * r;
  const double sine = std::fma(r * z, horner(kSin, z), r);
  const double cosine = std::fma(z, horner(kCos, z), 1.0);
  const std::uint64_t quadrant = std::bit_cast<std::uint64_t>(k) + quarter_turns;
  const double v = (quadrant & 1) != 0 ? cosine : sine;
  return to_grid(g, std::bit_cast<double>(std::bit_cast<std::uint64_t>(v) ^ ((quadrant & 2) << 62)));
}
inline double sin(const Grid& g, double x) { return sin_turned(g, x, 0); }
inline double cos(const Grid& g, double x) { return sin_turned(g, x, 1); }

}  // namespace aluminate::number
