// rcp, rsq, sqrt, exp2, log2, sin, cos against MPFR at 160 bits. Each bound is derived beside it; the worst input is
// printed so that a reader can try it.
#include <gtest/gtest.h>
#include <mpfr.h>

#include <random>

#include "platform/number/scalar.hpp"

namespace aluminate::number {
namespace {

class Exact {
 public:
  Exact() { mpfr_init2(value_, 160); }
  ~Exact() { mpfr_clear(value_); }
  Exact(const Exact&) = delete;
  Exact& operator=(const Exact&) = delete;
  mpfr_ptr get() { return value_; }
  // |y - value| as a double, rounded up.
  double distance(double y) {
    mpfr_d_sub(difference_.value_, y, value_, MPFR_RNDA);
    return std::fabs(mpfr_get_d(difference_.value_, MPFR_RNDA));
  }

 private:
  struct Raw {
    Raw() { mpfr_init2(value_, 160); }
    ~Raw() { mpfr_clear(value_); }
    mpfr_t value_;
  } difference_;
  mpfr_t value_;
};

using MpfrFunction = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
int reciprocal(mpfr_ptr r, mpfr_srcptr x, mpfr_rnd_t rounding) { return mpfr_ui_div(r, 1, x, rounding); }

struct Bound {
  double relative, absolute;  // beyond half a step of the result's grid
};

// Arguments on the grid: every magnitude, both signs when wanted, and all integers and halves near zero.
std::vector<double> arguments(const Grid& g, double least, double greatest, bool negative, int count) {
  std::mt19937_64 random(7);
  std::vector<double> xs;
  const double low = std::log2(least), high = std::log2(greatest);
  for (int i = 0; i < count; ++i) {
    const double t = std::generate_canonical<double, 53>(random);
    const double x = i % 4 == 0 ? greatest * t : std::exp2(low + (high - low) * t);
    xs.push_back(std::clamp(to_grid(g, x), least, greatest));
  }
  for (int i = 1; i <= 64; ++i)
    for (double x : {0.5 * i, 1 / static_cast<double>(i)}) xs.push_back(std::clamp(to_grid(g, x), least, greatest));
  xs.push_back(least);
  xs.push_back(greatest);
  if (negative)
    for (std::size_t i = 0, n = xs.size(); i < n; i += 2) xs[i] = -xs[i];
  return xs;
}

template <class Function>
void expect_close(const char* name, const Grid& g, const std::vector<double>& xs, Function function, MpfrFunction exact,
                  Bound bound, bool scale_by_result = true) {
  Exact value, argument;
  double worst = -1, worst_x = 0, worst_error = 0;
  for (double x : xs) {
    mpfr_set_d(argument.get(), x, MPFR_RNDN);
    exact(value.get(), argument.get(), MPFR_RNDN);
    const double truth = mpfr_get_d(value.get(), MPFR_RNDN);
    if (!(truth <= g.greatest && truth >= g.least)) continue;  // overflow is another test's subject
    const double error = value.distance(function(x));
    const double half_step = g.magic != 0 ? 0.5 * g.step : 0;
    const double allowed = half_step + bound.absolute + (scale_by_result ? bound.relative * std::fabs(truth) : 0);
    if (error / allowed > worst) {
      worst = error / allowed;
      worst_x = x;
      worst_error = error;
    }
  }
  std::printf("%-5s f=%2d: worst at x = %a: error %.3g = %.3f of the bound (%zu arguments)\n", name, g.frac_bits, worst_x,
              worst_error, worst, xs.size());
  EXPECT_LE(worst, 1.0) << name << " at " << worst_x;
  EXPECT_GT(worst, 0.0) << name << ": no argument was in range";
}

class Functions : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    format_ = *parse_number_format(GetParam());
    g_ = format_.default_grid();
    reference_ = format_.kind == Kind::Reference;
  }
  std::vector<double> positive(double least, double greatest) const {
    return arguments(g_, reference_ ? least : std::max(least, g_.step), std::min(greatest, g_.greatest), false, kCount);
  }
  std::vector<double> both_signs(double least, double greatest) const {
    return arguments(g_, reference_ ? least : std::max(least, g_.step), std::min(greatest, g_.greatest), true, kCount);
  }
  static constexpr int kCount = 60'000;
  NumberFormat format_;
  Grid g_;
  bool reference_ = false;
};

TEST_P(Functions, RcpIsWithinItsBound) {
  // Seed: (float)x and the binary32 division each err by 2^-24, so |e| <= 2^-23 (1 + 2^-24). One Newton step leaves
  // e^2 = 2^-46, its last fma 2^-53. ref64: one IEEE division.
  expect_close("rcp", g_, both_signs(1e-30, 1e30), [&](double x) { return rcp(g_, x); }, reciprocal,
               {reference_ ? 0x1p-53 : 0x1p-46 + 0x1p-52, 0});
}

TEST_P(Functions, RsqIsWithinItsBound) {
  // Seed: (float)x errs by 2^-24 (halved by the root), the root and the division by 2^-24 each: |e| <= 2.5 * 2^-24.
  // One step leaves 3/2 e^2 = 9.375 * 2^-48. ref64: root and division, 2^-53 each.
  expect_close("rsq", g_, positive(1e-30, 1e30), [&](double x) { return rsq(g_, g_.step, x); }, mpfr_rec_sqrt,
               {reference_ ? 0x1p-52 : 9.4 * 0x1p-48 + 0x1p-51, 0});
}

TEST_P(Functions, SqrtIsTheIeeeRootOnTheGrid) {
  // The IEEE root errs by 2^-53 of itself before the grid rounding.
  expect_close("sqrt", g_, positive(1e-30, 1e30), [&](double x) { return sqrt(g_, x); }, mpfr_sqrt, {0x1p-53, 0});
}

TEST_P(Functions, Exp2IsWithinItsBound) {
  // Polynomial 2^-34.3 (ref64 2^-57.2) and the rounding of Horner's last two steps, 2^-53 (1 + 0.5).
  const std::vector<double> xs = both_signs(1e-9, reference_ ? 450.0 : 60.0);
  expect_close("exp2", g_, xs, [&](double x) { return exp2(g_, x); }, mpfr_exp2,
               {reference_ ? 0x1p-57 + 1.5 * 0x1p-53 : 4.73e-11 + 0x1p-52, 0});
}

TEST_P(Functions, Log2IsWithinItsBound) {
  // |s q| <= 1/2: polynomial 2^-37.8 of that, s and the last fma 2^-52 of the result. ref64 is relative even near 1:
  // s errs by 2^-52 (subtraction exact, addition and division 2^-53 each), Horner's last step and the fma 2^-53 each.
  expect_close("log2", g_, positive(1e-100, 1e100), [&](double x) { return log2(g_, g_.step, x); }, mpfr_log2,
               reference_ ? Bound{0x1p-50, 0} : Bound{0x1p-51, 2.1e-12});
}

TEST_P(Functions, SineAndCosineAreWithinTheirBound) {
  // Two reduction steps and the last fma, each half an ulp below 1: 3 * 2^-54; z = r^2 and Horner contribute less than
  // 2^-53 more; the polynomials 2^-59.
  const Grid unit = format_.unit_grid();
  const double greatest = reference_ ? 0x1p31 : std::min(g_.greatest, 0x1p31);
  const std::vector<double> xs = both_signs(1e-9, greatest);
  expect_close("sin", unit, xs, [&](double x) { return sin(unit, x); }, mpfr_sin, {0, 0x1p-51});
  expect_close("cos", unit, xs, [&](double x) { return cos(unit, x); }, mpfr_cos, {0, 0x1p-51});
}

INSTANTIATE_TEST_SUITE_P(Formats, Functions, ::testing::Values("fx31", "fx24", "fx40", "q16.16", "q8.24", "ref64"),
                         [](const auto& name) {
                           std::string text = name.param;
                           std::replace(text.begin(), text.end(), '.', '_');
                           return text;
                         });

TEST(FunctionsOnTheUnitGrid, SaturatedPowersKeepSmallValues) {
  // exp_sat rounds to 2^-50: a value of 1e-10 keeps a relative error below 2^-34.3 + 2^-51 / 1e-10 = 5.1e-11.
  const Grid unit = parse_number_format("fx31")->unit_grid();
  for (double x = -33.2; x < 0; x += 0.0137) {
    const double truth = std::exp2(x);
    EXPECT_NEAR(exp2(unit, x), truth, 4.74e-11 * truth + 0x1p-51) << x;
  }
}

TEST(Functions, AreMonotoneWhereTheyMustBe) {
  const Grid g = parse_number_format("fx31")->default_grid();
  double previous_exp = -1, previous_log = -100;
  for (double x = -40; x < 20; x += 0x1p-9) {
    const double e = exp2(g, x);
    EXPECT_GE(e, previous_exp) << x;
    previous_exp = e;
  }
  for (double x = 0x1p-31; x < 1000; x *= 1.0009765625) {
    const double y = log2(g, g.step, to_grid(g, x));
    EXPECT_GE(y, previous_log) << x;
    previous_log = y;
  }
}

}  // namespace
}  // namespace aluminate::number
