// add, mul, mad and the dot products against integers: every carried number is an integer X times 2^-f, so the whole
// arithmetic can be repeated in __int128 with one explicit rounding shift.
#include <gtest/gtest.h>

#include <random>

#include "platform/number/scalar.hpp"

namespace aluminate::number {
namespace {

__extension__ using Int128 = __int128;

// numerator / 2^shift to nearest, ties to even; a negative shift is exact.
Int128 round_shift(Int128 numerator, int shift) {
  if (shift <= 0) return numerator * (Int128{1} << -shift);
  const Int128 one = 1;
  const Int128 floor = numerator >> shift, rest = numerator - (floor << shift), half = one << (shift - 1);
  const bool up = rest > half || (rest == half && (floor & 1) != 0);
  return floor + (up ? 1 : 0);
}

struct Carried {
  std::int64_t integer = 0;
  int f = 0;
  double value() const { return std::ldexp(static_cast<double>(integer), -f); }
};

std::int64_t greatest_integer(const Grid& g) { return static_cast<std::int64_t>(std::ldexp(g.greatest, g.frac_bits)); }
std::int64_t least_integer(const Grid& g) { return static_cast<std::int64_t>(std::ldexp(g.least, g.frac_bits)); }

class Operands {
 public:
  explicit Operands(const NumberFormat& format) : format_(format) {}
  // Every magnitude equally likely; one in eight is an extreme of the format or next to zero. One in four lies on the
  // unit grid where the format has one.
  Carried next() {
    const Grid g = format_.has_unit_grid() && random_() % 4 == 0 ? format_.unit_grid() : format_.default_grid();
    const std::int64_t greatest = g.frac_bits == kUnitFracBits ? std::int64_t{1} << kUnitFracBits : greatest_integer(g);
    switch (random_() % 24) {
      case 0: return {greatest, g.frac_bits};
      case 1: return {g.frac_bits == kUnitFracBits ? -greatest : least_integer(g), g.frac_bits};
      case 2: return {static_cast<std::int64_t>(random_() % 5) - 2, g.frac_bits};
      default: break;
    }
    const int bits = static_cast<int>(random_() % 52);
    const auto magnitude = static_cast<std::int64_t>(random_() & ((std::uint64_t{1} << bits) - 1));
    const std::int64_t clipped = magnitude > greatest ? greatest : magnitude;
    return {random_() % 2 == 0 ? clipped : -clipped, g.frac_bits};
  }
  Grid result_grid() { return format_.has_unit_grid() && random_() % 4 == 0 ? format_.unit_grid() : format_.default_grid(); }

 private:
  NumberFormat format_;
  std::mt19937_64 random_{2012};
};

// The integer result clamped to the grid's range, as a double.
double bounded(const Grid& g, Int128 integer) {
  if (integer > greatest_integer(g)) return g.greatest;
  if (integer < least_integer(g)) return g.least;
  return std::ldexp(static_cast<double>(static_cast<std::int64_t>(integer)), -g.frac_bits);
}

// x * 2^(f - x.f) as an integer: exact when the target grid is finer.
Int128 on_grid(const Carried& x, int f) { return round_shift(x.integer, x.f - f); }

class ExactArithmetic : public ::testing::TestWithParam<const char*> {
 protected:
  NumberFormat format_ = *parse_number_format(GetParam());
  Operands operands_{format_};
};

constexpr int kCases = 1'000'000;

TEST_P(ExactArithmetic, AddIsTheIntegerSumRoundedOnce) {
  for (int i = 0; i < kCases; ++i) {
    const Carried a = operands_.next(), b = operands_.next();
    const Grid g = operands_.result_grid();
    const int fine = std::max(a.f, b.f);
    const Int128 sum = on_grid(a, fine) + on_grid(b, fine);
    const double actual = finish(g, false, add(g, add_form(g.frac_bits, a.f, b.f), a.value(), b.value())).value;
    ASSERT_EQ(actual, bounded(g, round_shift(sum, fine - g.frac_bits))) << a.value() << " + " << b.value() << " f " << g.frac_bits;
  }
}

TEST_P(ExactArithmetic, MulIsTheIntegerProductRoundedOnce) {
  for (int i = 0; i < kCases; ++i) {
    const Carried a = operands_.next(), b = operands_.next();
    const Grid g = operands_.result_grid();
    const Int128 product = Int128{a.integer} * b.integer;
    const double actual = finish(g, false, mul(g, a.value(), b.value())).value;
    ASSERT_EQ(actual, bounded(g, round_shift(product, a.f + b.f - g.frac_bits))) << a.value() << " * " << b.value() << " f " << g.frac_bits;
  }
}

TEST_P(ExactArithmetic, MadRoundsTheAddendThenTheSum) {
  int checked = 0;
  for (int i = 0; i < kCases; ++i) {
    const Carried a = operands_.next(), b = operands_.next(), c = operands_.next();
    const Grid g = operands_.result_grid();
    const int shift = a.f + b.f - g.frac_bits;
    // c on the result's grid; a coarser c keeps its value. Skipped where the aligned sum would leave __int128.
    const Int128 addend = on_grid(c, g.frac_bits);
    if (shift > 0 && (addend > (Int128{1} << (125 - shift)) || addend < -(Int128{1} << (125 - shift)))) continue;
    ++checked;
    const Int128 product = Int128{a.integer} * b.integer;
    const Int128 expected = shift > 0 ? round_shift(product + (addend << shift), shift) : round_shift(product, shift) + addend;
    const double actual = finish(g, false, mad(g, a.value(), b.value(), c.value())).value;
    ASSERT_EQ(actual, bounded(g, expected)) << a.value() << " * " << b.value() << " + " << c.value() << " f " << g.frac_bits;
  }
  EXPECT_GT(checked, kCases * 9 / 10);
}

TEST_P(ExactArithmetic, DotProductsRoundAfterEveryStep) {
  int checked = 0;
  for (int i = 0; i < kCases; ++i) {
    const Grid g = operands_.result_grid();
    const std::size_t terms = 2 + static_cast<std::size_t>(i) % 3;
    const Carried c = terms == 2 ? operands_.next() : Carried{0, g.frac_bits};
    double a[4], b[4];
    Int128 sum = on_grid(c, g.frac_bits);
    const Int128 bound = Int128{1} << kIntegerBits;
    bool in_range = sum < bound && sum > -bound;  // the definition is an integer one while partial sums stay in range
    for (std::size_t t = 0; t < terms; ++t) {
      const Carried x = operands_.next(), y = operands_.next();
      a[t] = x.value();
      b[t] = y.value();
      const int shift = x.f + y.f - g.frac_bits;
      if (!in_range || shift > 74) {
        in_range = false;
        continue;
      }
      const Int128 product = Int128{x.integer} * y.integer;
      sum = shift > 0 ? round_shift(product + (sum << shift), shift) : round_shift(product, shift) + sum;
      in_range = sum < bound && sum > -bound;
    }
    if (!in_range) continue;
    ++checked;
    const double actual = finish(g, false, dot(g, std::span(a, terms), std::span(b, terms), c.value())).value;
    ASSERT_EQ(actual, bounded(g, sum)) << terms << " terms, f " << g.frac_bits;
  }
  EXPECT_GT(checked, kCases / 8);
}

TEST_P(ExactArithmetic, ResultsStayOnTheirGridAndInRange) {
  for (int i = 0; i < kCases / 4; ++i) {
    const Carried a = operands_.next(), b = operands_.next();
    const Grid g = operands_.result_grid();
    for (double x : {mul(g, a.value(), b.value()), rcp(g, a.value()), rsq(g, std::ldexp(1.0, -a.f), a.value()), sqrt(g, a.value()),
                     exp2(g, a.value()), log2(g, std::ldexp(1.0, -a.f), a.value()), sin(g, a.value()), cos(g, a.value())}) {
      const double y = finish(g, false, x).value;
      ASSERT_TRUE(y >= g.least && y <= g.greatest) << y;
      ASSERT_EQ(std::ldexp(y, g.frac_bits), std::floor(std::ldexp(y, g.frac_bits))) << y;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, ExactArithmetic,
                         ::testing::Values("fx31", "fx20", "fx24", "fx28", "fx36", "fx40", "q16.16", "q12.20", "q8.24", "q2.30", "q32.0"),
                         [](const auto& name) {
                           std::string text = name.param;
                           std::replace(text.begin(), text.end(), '.', '_');
                           return text;
                         });

TEST(Sanitise, BorderValuesBecomeNumbersOfTheGrid) {
  const Grid g = parse_number_format("fx31")->default_grid();
  EXPECT_EQ(sanitise(g, std::nan("")).value, 0.0);
  EXPECT_TRUE(sanitise(g, std::nan("")).saturated);
  EXPECT_EQ(sanitise(g, INFINITY).value, g.greatest);
  EXPECT_EQ(sanitise(g, -INFINITY).value, -g.greatest);
  EXPECT_EQ(sanitise(g, 0x1p-33).value, 0.0);
  EXPECT_EQ(sanitise(g, 0x1.8p-31).value, 0x1p-30);  // tie to even
  EXPECT_FALSE(sanitise(g, g.greatest).saturated);
}

TEST(Saturation, OverflowClampsAndIsReportedButTheModifierIsNot) {
  const Grid g = parse_number_format("fx31")->default_grid();
  EXPECT_EQ(g.greatest, 0x1p20 - 0x1p-31);
  const Ranged over = finish(g, false, mul(g, 2048.0, 1024.0));
  EXPECT_EQ(over.value, g.greatest);
  EXPECT_TRUE(over.saturated);
  const Ranged under = finish(g, false, mul(g, -2048.0, 1024.0));
  EXPECT_EQ(under.value, -g.greatest);
  const Ranged unit = finish(g, true, mul(g, 2048.0, 1024.0));
  EXPECT_EQ(unit.value, 1.0);
  EXPECT_FALSE(unit.saturated);
  EXPECT_EQ(finish(g, false, rcp(g, 0.0)).value, g.greatest);
}

TEST(NumberFormats, NamesParseAndOthersDoNot) {
  for (const char* good : {"fx20", "fx31", "fx40", "q16.16", "q2.0", "q2.30", "q32.0", "ref64", "auto"})
    EXPECT_TRUE(parse_number_format(good).has_value()) << good;
  for (const char* bad : {"", "fx", "fx19", "fx41", "fx031", "FX31", "q16", "q16.", "q.16", "q1.31", "q16.17", "q0.8", "ref32", "Auto", "auto31", "q-2.8", "fx31 "})
    EXPECT_FALSE(parse_number_format(bad).has_value()) << bad;
}

}  // namespace
}  // namespace aluminate::number
