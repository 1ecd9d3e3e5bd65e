// Toksvig's factor: worked examples, exact identities to 1e-12, and the distribution it approximates.
#include "shading/brdf/toksvig.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "shading/brdf/quadrature.hpp"

namespace aluminate::brdf {
namespace {

const double kLengths[] = {1e-6, 0.01, 0.3, 0.7, 0.9, 0.99, 254.0 / 255.0, 1.0 - 1e-9, 1.0};
const double kPowers[] = {0.5, 1.0, 10.0, 100.0, 512.0, 8192.0};

TEST(Toksvig, OneStepOfAnEightBitLengthIsAFactorOfThirtyThree) {
  EXPECT_NEAR(toksvig_factor(254.0 / 255.0, 8192.0), 0.030, 5e-4);
  EXPECT_NEAR(filtered_power(254.0 / 255.0, 8192.0), 246.0, 0.5);
}

TEST(Toksvig, UnitLengthChangesNothingAndZeroLengthFlattens) {
  for (const double m : kPowers) {
    EXPECT_EQ(toksvig_factor(1.0, m), 1.0);
    EXPECT_EQ(toksvig_factor(1.0 + 1e-3, m), 1.0);
    EXPECT_EQ(toksvig_factor(0.0, m), 0.0);
    EXPECT_EQ(filtered_power(0.0, m), 0.0);
  }
  EXPECT_EQ(toksvig_factor(0.0, 0.0), 0.0);
}

TEST(Toksvig, VarianceFormIsTheSameFunction) {
  for (const double length : kLengths)
    for (const double m : kPowers)
      EXPECT_NEAR(filtered_power_from_variance(normal_variance(length), m), filtered_power(length, m),
                  1e-12 * filtered_power(length, m));
  EXPECT_EQ(filtered_power_from_variance(normal_variance(0.0), 100.0), 0.0);
}

TEST(Toksvig, FactorLiesInUnitIntervalAndFallsWithPowerAndRisesWithLength) {
  for (std::size_t i = 0; i < std::size(kLengths); ++i)
    for (std::size_t j = 0; j < std::size(kPowers); ++j) {
      const double ft = toksvig_factor(kLengths[i], kPowers[j]);
      EXPECT_GT(ft, 0.0);
      EXPECT_LE(ft, 1.0);
      if (i > 0) {
        EXPECT_GT(ft, toksvig_factor(kLengths[i - 1], kPowers[j]));
      }
      if (j > 0 && kLengths[i] < 1.0) {
        EXPECT_LT(ft, toksvig_factor(kLengths[i], kPowers[j - 1]));
      }
    }
}

TEST(Toksvig, FactorForAFixedPowerConvertsExactlyAndBack) {
  for (const double length : kLengths)
    for (const double m : kPowers) {
      const double fixed = toksvig_factor(length, kFixedPower);
      const double converted = convert_toksvig_factor(fixed, kFixedPower, m);
      EXPECT_NEAR(converted, toksvig_factor(length, m), 1e-12);
      EXPECT_NEAR(convert_toksvig_factor(converted, m, kFixedPower), fixed, 1e-12);
      // The published spelling: ft /= lerp(s / fixed_s, 1, ft).
      EXPECT_NEAR(converted, fixed / std::lerp(m / kFixedPower, 1.0, fixed), 1e-12);
    }
  EXPECT_EQ(convert_toksvig_factor(0.0, kFixedPower, 8192.0), 0.0);
}

TEST(Toksvig, LengthIsRecoveredFromTheFactor) {
  for (const double length : kLengths)
    for (const double m : kPowers)
      EXPECT_NEAR(length_from_toksvig_factor(toksvig_factor(length, m), m), length, 1e-12);
}

TEST(Toksvig, AdjustedGlossIsTheLogarithmOfTheFilteredPowerClampedToTheRange) {
  for (const double length : kLengths)
    for (const double gloss : {0.0, 0.2, 0.5, 1.0}) {
      const double m = filtered_power(length, power_from_gloss(gloss));
      EXPECT_NEAR(filtered_gloss(length, gloss), m > 1.0 ? std::log2(m) / 13.0 : 0.0, 1e-12);
    }
  EXPECT_EQ(filtered_gloss(0.0, 1.0), 0.0);
  EXPECT_EQ(filtered_gloss(1.0, 0.3), 0.3);
}

TEST(Toksvig, VonMisesFisherMeanLengthMatchesItsIntegral) {
  for (const double k : {1e-4, 0.019, 0.021, 1.0, 30.0}) {
    // mean of cos over density proportional to exp(k (cos - 1))
    const double mass = integrate([&](double u) { return std::exp(k * (u - 1.0)); }, -1.0, 1.0, 1e-13);
    const double mean =
        integrate([&](double u) { return u * std::exp(k * (u - 1.0)); }, -1.0, 1.0, 1e-13) / mass;
    EXPECT_NEAR(vmf_mean_length(k), mean, 1e-12) << k;
  }
}

TEST(Toksvig, ConcentrationHundredLeavesPowerNinetyEight) {
  const double filtered = filtered_power(vmf_mean_length(100.0), 8192.0);
  EXPECT_NEAR(filtered, 97.8, 0.05);
  EXPECT_NEAR(vmf_filtered_power(100.0, 8192.0), filtered, 1.0);  // differs by about m' / k = 1
}

TEST(Toksvig, MeansOfOneNormalMapDifferByTwentyFiveTimes) {
  const std::vector<double> lengths{1, 1, .99, .9, .7};
  EXPECT_NEAR(mean_toksvig_factor(lengths, 512.0, ToksvigMean::Factor), .4368, 5e-5);
  EXPECT_NEAR(mean_toksvig_factor(lengths, 512.0, ToksvigMean::Gloss), .1049, 5e-5);
  EXPECT_NEAR(mean_toksvig_factor(lengths, 512.0, ToksvigMean::Length), .0214, 5e-5);
  EXPECT_NEAR(mean_toksvig_factor(lengths, 512.0, ToksvigMean::Harmonic), .0175, 5e-5);
}

TEST(Toksvig, MeansAgreeOnAUniformMapAndSurviveZeroLengths) {
  const std::vector<double> uniform(7, 0.9), with_zero{1.0, 0.0};
  for (const ToksvigMeanName& row : kToksvigMeans) {
    EXPECT_NEAR(mean_toksvig_factor(uniform, 300.0, row.id), toksvig_factor(0.9, 300.0), 1e-14) << row.name;
    EXPECT_EQ(mean_toksvig_factor({}, 300.0, row.id), 1.0);
    EXPECT_EQ(parse_toksvig_mean(row.name), row.id);
    EXPECT_EQ(to_string(row.id), row.name);
  }
  EXPECT_EQ(mean_toksvig_factor(with_zero, 300.0, ToksvigMean::Gloss), 0.0);
  EXPECT_EQ(mean_toksvig_factor(with_zero, 300.0, ToksvigMean::Harmonic), 0.0);
  EXPECT_EQ(mean_toksvig_factor(with_zero, 300.0, ToksvigMean::Factor), 0.5);
  EXPECT_FALSE(parse_toksvig_mean("mean"));
}

}  // namespace
}  // namespace aluminate::brdf
