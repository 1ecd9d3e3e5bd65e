// The keyed day: linear between keys, closed over midnight, strict about its input.
#include "shading/sky/day_cycle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "shading/sky/sh9.hpp"

namespace aluminate::sky {
namespace {

TEST(DayCycle, IsLinearBetweenKeysAndOverMidnight) {
  const DayCycle cycle({{6.0, {1, 0, 0}, {0, 0, 1}, 1.0}, {18.0, {0, 1, 0}, {0, 0, 3}, 3.0}});
  EXPECT_EQ(cycle.at(6.0).zenith_lin, glm::dvec3(1, 0, 0));
  EXPECT_EQ(cycle.at(18.0).intensity, 3.0);
  EXPECT_NEAR(cycle.at(9.0).intensity, 1.5, 1e-15);
  EXPECT_NEAR(cycle.at(21.0).intensity, 2.5, 1e-15);
  EXPECT_NEAR(cycle.at(0.0).intensity, 2.0, 1e-15);
  EXPECT_NEAR(cycle.at(3.0).zenith_lin.x, 0.75, 1e-15);
  EXPECT_EQ(cycle.at(24.0 + 9.0).intensity, cycle.at(9.0).intensity);
  EXPECT_EQ(cycle.at(-15.0).intensity, cycle.at(9.0).intensity);
}

TEST(DayCycle, OneKeyIsAConstantSky) {
  const DayCycle cycle({{12.0, {1, 2, 3}, {4, 5, 6}, 7.0}});
  for (const double hours : {0.0, 11.9, 12.0, 23.0}) {
    EXPECT_EQ(cycle.at(hours).zenith_lin, glm::dvec3(1, 2, 3));
    EXPECT_EQ(cycle.at(hours).intensity, 7.0);
  }
}

TEST(DayCycle, RefusesKeysThatDoNotMakeADay) {
  EXPECT_THROW(DayCycle({}), UserError);
  EXPECT_THROW(DayCycle({{24.0, {}, {}, 1}}), UserError);
  EXPECT_THROW(DayCycle({{-1.0, {}, {}, 1}}), UserError);
  EXPECT_THROW(DayCycle({{5.0, {}, {}, 1}, {5.0, {}, {}, 1}}), UserError);
}

TEST(DayCycle, ClearDayKeysAreChromaticities) {
  for (const SkyKey& key : clear_day().keys())
    for (const glm::dvec3& c : {key.zenith_lin, key.horizon_lin}) EXPECT_EQ(std::max({c.r, c.g, c.b}), 1.0);
}

TEST(DayCycle, SkyLightIsContinuousOverTheWholeDayAndDarkestAtNight) {
  double previous = 0.0, darkest = 1e9, brightest = 0.0, largest_step = 0.0;
  for (int minute = 0; minute <= 24 * 60; minute += 10) {
    const double light = irradiance(project(sky_at(minute / 60.0, clear_day())), {0, 0, 1}).y;
    EXPECT_TRUE(std::isfinite(light) && light >= 0.0);
    if (minute > 0) largest_step = std::max(largest_step, std::fabs(light - previous));
    previous = light;
    darkest = std::min(darkest, light);
    brightest = std::max(brightest, light);
  }
  // Ten minutes move the sun 2.5 degrees; sunset takes 24 minutes of twilight: no step may be near the whole
  // range.
  EXPECT_LT(largest_step, 0.15 * brightest);
  EXPECT_GT(darkest, 0.0);
  EXPECT_LT(darkest, 0.02 * brightest);
}

}  // namespace
}  // namespace aluminate::sky
