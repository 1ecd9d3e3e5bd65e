// A number format: the grid and the range every register value lies on.
//   in   a name a user typed: "fx31", "auto", "q16.16", "ref64"
//   out  constants of the arithmetic in platform/number/scalar.hpp
//   never touches a value itself, never allocates after parsing.
// Exact definitions: docs/number_formats.md.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace aluminate::number {

enum class Kind : unsigned char {
  Fixed,       // fxN: integer X, |X| < 2^51, value X * 2^-f; f belongs to the instruction, N is the default
  Saturating,  // qI.F: one grid and one range [-2^(I-1), 2^(I-1) - 2^-F] for every value
  Reference,   // ref64: no grid, binary64 throughout; the accuracy reference
};

/// Bits of the carried integer without its sign: |X| < 2^kIntegerBits, one less than a binary64 significand so that
/// the rounding constant leaves room for a carry.
inline constexpr int kIntegerBits = 51;

/// Fraction bits of results that their own definition bounds by 1 (saturate, sin, cos, texels): |X| <= 2^50 < 2^51.
inline constexpr int kUnitFracBits = 50;
static_assert(kUnitFracBits < kIntegerBits);

/// Range of ref64. A product of two such values, and a sum of four products, stays finite: 4 * 2^1000 < 2^1024.
inline constexpr double kReferenceGreatest = 0x1p500;

/// 2^exponent, exactly, for -1022 <= exponent <= 1023.
constexpr double power_of_two(int exponent) {
  double value = 1;
  for (int i = 0; i < exponent; ++i) value *= 2;
  for (int i = 0; i > exponent; --i) value *= 0.5;
  return value;
}

/// What one instruction needs to round and bound its result.
struct Grid {
  int frac_bits = 31;   // f; meaningless for Reference
  double magic = 0;     // M = 1.5 * 2^(52-f): (x + M) - M rounds x to the nearest multiple of 2^-f, ties to even. Reference: 0
  double step = 0;      // 2^-f; Reference: 2^-500
  double least = 0;     // smallest and greatest value of the grid
  double greatest = 0;
  double beyond = 0;    // a power of two outside the range, stand-in for 1/0 and 2^large: 2^(52-f); Reference: 2^501
  double exp2_least = -60;     // exponents are clamped to [exp2_least, exp2_greatest] before 2^x: below, the result rounds
  double exp2_greatest = 21;   // to 0 (2^-60 < 2^-51 <= half a step); above, it is `beyond`
  bool operator==(const Grid&) const = default;
};

struct NumberFormat {
  std::string name = "fx31";
  Kind kind = Kind::Fixed;
  int frac_bits = 31;  // N of fxN, F of qI.F; 0 for ref64
  int int_bits = 0;    // I of qI.F, sign included; 0 otherwise
  bool finest = false; // auto: fx31 whose instructions round to the finest grid that range analysis allows, f <= 50

  /// Grid of a result with the given fraction bits. Saturating and Reference formats have one grid: the argument is
  /// ignored there. Fixed: 0 <= f <= 50.
  Grid grid(int f) const;
  /// Grid of inputs, uniforms and ordinary results.
  Grid default_grid() const { return grid(frac_bits); }
  /// Grid of results bounded by 1: f = 50 in fxN, the format's own grid in qI.F and ref64.
  Grid unit_grid() const { return grid(kUnitFracBits); }
  bool has_unit_grid() const { return kind == Kind::Fixed; }
  bool operator==(const NumberFormat&) const = default;
};

/// fx20 .. fx40, auto, qI.F with 2 <= I (1 must be in range), 0 <= F, I + F <= 32, ref64. Lower case. nullopt: not a format.
std::optional<NumberFormat> parse_number_format(std::string_view name);

/// For help texts and hints: "fx20..fx40 (default fx31), auto (fx31 on finer grids where proven), qI.F with I + F <= 32 (q16.16, q12.20, q8.24), ref64".
std::string_view number_format_names();

}  // namespace aluminate::number
