// The dome image and its integrals: consistent with SH light, scaled by the filter, untouched elsewhere.
#include "shading/sky/dome.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "shading/sky/sh9.hpp"

namespace aluminate::sky {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180.0;

Sky make_sky(const CieParameters& cie, double sun_zenith_deg, Relative relative) {
  Sky sky;
  sky.cie = cie;
  sky.relative = relative;
  sky.to_sun = direction(sun_zenith_deg * kDegree, 0.0);
  return sky;
}

TEST(DomeIntegral, HorizontalIrradianceFromNoonToSunsetMatchesThePublishedTable) {
  const auto horizontal = [](const CieParameters& cie, double sun, Relative relative) {
    return dome_integral(make_sky(cie, sun, relative)).horizontal.x;
  };
  // zenith-relative rises towards sunset ..., published to three digits
  EXPECT_NEAR(horizontal(cie_type(12), 0.0, Relative::Zenith), .967, 5e-4);
  EXPECT_NEAR(horizontal(cie_type(12), 90.0, Relative::Zenith), 6.96, 5e-3);
  EXPECT_NEAR(horizontal(kFarCry3Sky, 0.0, Relative::Zenith), .773, 5e-4);
  EXPECT_NEAR(horizontal(kFarCry3Sky, 90.0, Relative::Zenith), 11.1, 5e-2);
  // ... sun-relative falls: dusk darkens without tuning
  EXPECT_NEAR(horizontal(cie_type(12), 90.0, Relative::Sun), .168, 5e-4);
  EXPECT_NEAR(horizontal(kFarCry3Sky, 90.0, Relative::Sun), .034, 5e-4);
}

TEST(DomeIntegral, OfAUniformSkyIsTwoPiAndPi) {
  const DomeIntegral dome = dome_integral(make_sky(cie_type(5), 33.0, Relative::Sun));
  EXPECT_NEAR(dome.radiance.x, 2.0 * kPi, 1e-8);
  EXPECT_NEAR(dome.horizontal.x, kPi, 1e-8);
}

TEST(DomeIntegral, IsTheConstantCoefficientOfTheProjection) {
  for (const double sun : {0.0, 40.0, 88.0}) {
    Sky sky = make_sky(kFarCry3Sky, sun, Relative::Sun);
    sky.gradient = zenith_horizon_gradient({0.2, 0.4, 1.0}, {1.0, 0.8, 0.6});
    const glm::dvec3 from_sh = project(sky)[0] * std::sqrt(4.0 * kPi), direct = dome_integral(sky).radiance;
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(from_sh[k], direct[k], 1e-8 * direct[k]);
  }
}

TEST(DirectIrradiance, OfUniformSkyAndGroundIsTheirShareOfTheHemisphere) {
  Sky sky = make_sky(cie_type(5), 20.0, Relative::Sun);
  sky.ground = glm::dvec3(0.5);
  for (const double zenith : {0.0, 0.7, kPi / 2.0, 2.2, kPi})
    for (const double azimuth : {0.0, 2.5}) {
      const double up = 0.5 * (1.0 + std::cos(zenith));
      EXPECT_NEAR(direct_irradiance(sky, direction(zenith, azimuth)).x, kPi * (up + 0.5 * (1.0 - up)), 1e-7);
    }
}

TEST(DirectIrradiance, MatchesASumOverAFineGrid) {
  const Sky sky = make_sky(cie_type(12), 55.0, Relative::Sun);
  const glm::dvec3 normal = direction(1.1, 2.0);
  constexpr int kWidth = 1600, kHeight = 800;
  double sum = 0.0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const glm::dvec3 d = latlong_direction(x, y, kWidth, kHeight);
      sum +=
          radiance(sky, d).x * std::max(0.0, glm::dot(d, normal)) * latlong_solid_angle(y, kWidth, kHeight);
    }
  EXPECT_NEAR(direct_irradiance(sky, normal).x, sum,
              2e-5 * sum);  // midpoint rule, step 0.004 rad: about step^2
}

TEST(Latlong, SolidAnglesCoverTheSphereAndDirectionsAreAsDocumented) {
  double sum = 0.0;
  for (int y = 0; y < 37; ++y) sum += 64 * latlong_solid_angle(y, 64, 37);
  EXPECT_NEAR(sum, 4.0 * kPi, 1e-12);
  const glm::dvec3 middle = latlong_direction(2, 1, 5, 3);  // the exact centre of an odd map
  EXPECT_NEAR(middle.x, 1.0, 1e-15);
  EXPECT_GT(latlong_direction(0, 0, 64, 32).z, 0.99);
  EXPECT_LT(latlong_direction(0, 31, 64, 32).z, -0.99);
  EXPECT_GT(latlong_direction(48, 16, 64, 32).y, 0.99);  // three quarters across: azimuth +90 degrees
}

TEST(DomeImage, IntegratesToTheConstantCoefficientWithinHalfAPercent) {
  for (const double sun : {10.0, 60.0, 85.0}) {
    Sky sky = make_sky(kFarCry3Sky, sun, Relative::Sun);
    sky.gradient = zenith_horizon_gradient({0.2, 0.4, 1.0}, {1.0, 0.8, 0.6});
    const DomeImageOptions options{.width = 256, .height = 128};
    const std::vector<float> image = dome_image(sky, options);
    ASSERT_EQ(image.size(), 256u * 128u * 3u);
    glm::dvec3 sum(0.0);
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 256; ++x)
        for (int k = 0; k < 3; ++k)
          sum[k] += static_cast<double>(image[static_cast<std::size_t>((y * 256 + x) * 3 + k)]) *
                    latlong_solid_angle(y, 256, 128);
    const glm::dvec3 expected = project(sky)[0] * std::sqrt(4.0 * kPi);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(sum[k] / expected[k], 1.0, 0.005);
  }
}

TEST(DomeImage, FilterScalesEveryPixelExactlyAndNotTheLight) {
  const Sky sky = make_sky(cie_type(12), 50.0, Relative::Sun);
  DomeImageOptions options{.width = 16, .height = 8};
  const std::vector<float> plain = dome_image(sky, options);
  options.post_process = {0.5, 0.25, 2.0};  // powers of two: exact in float
  const std::vector<float> filtered = dome_image(sky, options);
  for (std::size_t i = 0; i < plain.size(); i += 3) {
    EXPECT_EQ(filtered[i], 0.5f * plain[i]);
    EXPECT_EQ(filtered[i + 1], 0.25f * plain[i + 1]);
    EXPECT_EQ(filtered[i + 2], 2.0f * plain[i + 2]);
  }
}

TEST(DomeImage, BelowTheHorizonIsGroundOrTheHorizonContinued) {
  Sky sky = make_sky(cie_type(12), 50.0, Relative::Sun);
  sky.ground = {0.25, 0.5, 0.75};
  DomeImageOptions options{.width = 8, .height = 8};
  const std::vector<float> ground = dome_image(sky, options);
  EXPECT_EQ(ground[(7 * 8 + 3) * 3 + 1], 0.5f);
  options.below = BelowHorizon::Extend;
  const std::vector<float> extended = dome_image(sky, options);
  EXPECT_GT(extended[(7 * 8 + 3) * 3], 0.0f);
  EXPECT_NE(extended[(7 * 8 + 3) * 3 + 1], 0.5f);
  for (std::size_t i = 0; i < 4 * 8 * 3; ++i) EXPECT_EQ(extended[i], ground[i]);
}

TEST(DomeImage, RefusesSizesOutOfRange) {
  const Sky sky;
  EXPECT_THROW((void)dome_image(sky, {.width = 0, .height = 8}), UserError);
  EXPECT_THROW((void)dome_image(sky, {.width = 8, .height = 16385}), UserError);
}

}  // namespace
}  // namespace aluminate::sky
