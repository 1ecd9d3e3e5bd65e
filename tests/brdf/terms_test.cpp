// Single terms against printed values of the sources and against a second way to compute them.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "shading/brdf/blinn_phong.hpp"
#include "shading/brdf/fresnel.hpp"
#include "shading/brdf/quadrature.hpp"
#include "shading/brdf/visibility.hpp"

namespace aluminate::brdf {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Clamped, KeepsTheUnitIntervalAndMapsTheRestToItsEnds) {
  EXPECT_EQ(clamped(-1e-300), 0.0);
  EXPECT_EQ(clamped(0.25), 0.25);
  EXPECT_EQ(clamped(1.0 + 1e-15), 1.0);
  EXPECT_EQ(clamped(std::numeric_limits<double>::quiet_NaN()), 0.0);
}

TEST(BlinnPhong, PowerIsExactAtBothEndsOfGloss) {
  EXPECT_EQ(power_from_gloss(0.0), 1.0);
  EXPECT_EQ(power_from_gloss(1.0), 8192.0);
  EXPECT_NEAR(power_from_gloss(1.0 / 255.0), 1.0360, 5e-5);  // one 8-bit step: half of the last printed digit
}

TEST(BlinnPhong, EightBitGlossSurvivesThePower) {
  for (int stored = 0; stored <= 255; ++stored)
    EXPECT_EQ(std::lround(gloss_from_power(power_from_gloss(stored / 255.0)) * 255.0), stored);
}

TEST(BlinnPhong, PowerZeroToTheZeroIsOne) {
  EXPECT_EQ(blinn_phong_lobe(0.0, 0.0), 1.0);
  EXPECT_EQ(blinn_phong_lobe(8192.0, 0.5), 0.0);  // 2^-8192 underflows: right, not an accident
  EXPECT_EQ(blinn_phong_lobe(8192.0, 1.0), 1.0);
}

TEST(BlinnPhong, DistributionNormalisesProjectedArea) {
  for (const double m : {0.0, 1.0, 7.5, 100.0, 8192.0}) {
    const double area = integrate(
        [&](double t) {
          return blinn_phong_distribution(m, std::cos(t)) * std::cos(t) * 2.0 * kPi * std::sin(t);
        },
        0.0, kPi / 2.0, 1e-12);
    EXPECT_NEAR(area, 1.0, 1e-10) << m;  // the quadrature's own tolerance
  }
}

TEST(BlinnPhong, NormalisationIsPiQuarterOfTheDistributions) {
  for (const double m : {0.0, 1.0, 33.0, 8192.0})
    EXPECT_NEAR(norm_m_plus_2(m), kPi / 4.0 * blinn_phong_distribution(m, 1.0), 1e-12 * (m + 2.0));
  EXPECT_EQ(norm_m_plus_2(1.0), 0.375);
  EXPECT_EQ(norm_2m_plus_1(1.0), 0.375);
  EXPECT_EQ(norm_3m(1.0), 0.375);
  EXPECT_EQ(norm_m_plus_2(8192.0), 1024.25);
  EXPECT_EQ(norm_2m_plus_1(8192.0), 2048.125);
}

TEST(Fresnel, IsOneAtGrazingInEveryVariant) {
  for (const FresnelTerm& row : kFresnelTerms)
    for (const double cspec : {0.0, 0.02, 0.04, 0.5, 1.0})
      EXPECT_EQ(fresnel(row.id, cspec, 0.0), 1.0) << row.name;
}

TEST(Fresnel, HeadOnValuesOfEachVariant) {
  EXPECT_EQ(fresnel(Fresnel::Schlick, 0.04, 1.0), 0.04);
  EXPECT_NEAR(fresnel(Fresnel::Sg, 0.04, 1.0), 0.04 + 0.96 * 0.0024787521766663585, 1e-15);
  EXPECT_NEAR(fresnel(Fresnel::Sg, 0.04, 1.0), 0.04238, 5e-6);
  EXPECT_NEAR(fresnel(Fresnel::SgLagarde, 0.04, 1.0) - 0.04, 0.00017 * 0.96, 5e-6);
}

TEST(Fresnel, SphericalGaussianIsTheExp2TheShaderUses) {
  for (double x = 0.0; x <= 1.0; x += 1.0 / 64.0)
    EXPECT_NEAR(fresnel_weight_sg(x), std::exp2(-8.65617024533378 * x),
                1e-14);  // constant rounded to 15 digits
}

TEST(Fresnel, FallsMonotonicallyFromGrazingToHeadOn) {
  for (const FresnelTerm& row : kFresnelTerms)
    for (int i = 1; i <= 1000; ++i)
      EXPECT_LT(row.weight(i / 1000.0), row.weight((i - 1) / 1000.0)) << row.name;
}

TEST(Fresnel, SphericalGaussianLiftsTheMiddleByAThirdAtFourPercent) {
  double worst_relative = 0.0, at = 0.0, worst_absolute = 0.0;
  for (double x = 0.0; x <= 1.0; x += 1e-3) {
    const double schlick = fresnel(Fresnel::Schlick, 0.04, x), sg = fresnel(Fresnel::Sg, 0.04, x);
    if (sg / schlick - 1.0 > worst_relative) worst_relative = sg / schlick - 1.0, at = x;
    worst_absolute = std::max(worst_absolute, schlick - sg);
  }
  EXPECT_NEAR(worst_relative, 0.33, 0.005);  // published to two digits
  EXPECT_NEAR(at, 0.625, 0.02);
  EXPECT_NEAR(worst_absolute, 0.040, 0.0005);
}

TEST(Visibility, SchlickSmithParameterAtTheEndsOfTheRange) {
  EXPECT_NEAR(schlick_smith_a(1.0), 0.651470, 5e-7);
  EXPECT_NEAR(schlick_smith_a(8192.0), 0.0124654, 5e-8);
  EXPECT_NEAR(schlick_smith_a(0.0), std::sqrt(2.0 / kPi), 1e-15);
}

TEST(Visibility, SchlickSmithParameterIsBeckmannRoughnessTimesRootTwoOverPi) {
  for (const double m : {0.0, 1.0, 50.0, 8192.0})
    EXPECT_NEAR(schlick_smith_a(m), std::sqrt(2.0 / (m + 2.0)) * std::sqrt(2.0 / kPi), 1e-15);
}

TEST(Visibility, IntegratedIsTheProductOfTwoHemisphereAverages) {
  EXPECT_NEAR(visibility_integrated(1.0, 1, 1), 1.5117, 5e-5);
  EXPECT_NEAR(visibility_integrated(8192.0, 1, 1), 19.715, 5e-4);
  for (const double m : {1.0, 30.0, 8192.0}) {
    const double a = schlick_smith_a(m);
    const double average = integrate([&](double u) { return 1.0 / (u * (1.0 - a) + a); }, 0.0, 1.0, 1e-12);
    EXPECT_NEAR(visibility_integrated(m, 1, 1), average * average, 1e-10 * average * average);
  }
}

TEST(Visibility, SchlickSmithRunsFromOneHeadOnToInverseSquareOfAAtDoubleGrazing) {
  for (const double m : {0.0, 1.0, 8192.0}) {
    EXPECT_NEAR(visibility_schlick_smith(m, 1.0, 1.0), 1.0, 1e-15);
    const double a = schlick_smith_a(m);
    EXPECT_NEAR(visibility_schlick_smith(m, 0.0, 0.0) * a * a, 1.0, 1e-14);
  }
  EXPECT_NEAR(visibility_schlick_smith(8192.0, 0.0, 0.0), 6435.6, 0.1);
}

TEST(Visibility, FallsAsEitherCosineRises) {
  for (const double m : {1.0, 64.0, 8192.0})
    for (int i = 1; i <= 100; ++i) {
      const double low = (i - 1) / 100.0, high = i / 100.0;
      EXPECT_LT(visibility_schlick_smith(m, high, 0.3), visibility_schlick_smith(m, low, 0.3));
      EXPECT_LT(visibility_schlick_smith(m, 0.3, high), visibility_schlick_smith(m, 0.3, low));
    }
}

TEST(Variants, NamesOfTheCommandLineReadBackAndNothingElseDoes) {
  for (std::size_t i = 0; i < kVisibilityTerms.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(kVisibilityTerms[i].id), i);  // term() indexes by id
    EXPECT_EQ(parse_visibility(to_string(kVisibilityTerms[i].id)), kVisibilityTerms[i].id);
  }
  for (std::size_t i = 0; i < kFresnelTerms.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(kFresnelTerms[i].id), i);
    EXPECT_EQ(parse_fresnel(to_string(kFresnelTerms[i].id)), kFresnelTerms[i].id);
  }
  EXPECT_EQ(to_string(Visibility::SchlickSmith), "schlick-smith");
  EXPECT_EQ(to_string(Fresnel::SgLagarde), "sg-lagarde");
  EXPECT_FALSE(parse_visibility("Schlick-Smith"));
  EXPECT_FALSE(parse_visibility(""));
  EXPECT_FALSE(parse_fresnel("sg-"));
}

}  // namespace
}  // namespace aluminate::brdf
