// Sun position: the model's landmarks, frames, and the messages for what cannot be read.
#include "shading/sky/sun.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace aluminate::sky {
namespace {

TEST(Sun, RisesInTheEastCulminatesInTheSouthAndSetsInTheWestAtEquinox) {
  const SunPosition rise = sun_at(6.0), noon = sun_at(12.0), set = sun_at(18.0);
  EXPECT_NEAR(rise.elevation_deg, 0.0, 1e-12);
  EXPECT_NEAR(rise.azimuth_deg, 0.0, 1e-12);  // +x is east
  EXPECT_NEAR(noon.elevation_deg, 70.0, 1e-12);
  EXPECT_NEAR(noon.azimuth_deg, -90.0, 1e-12);  // -y is south
  EXPECT_NEAR(set.elevation_deg, 0.0, 1e-12);
  EXPECT_NEAR(std::fabs(set.azimuth_deg), 180.0, 1e-12);
  EXPECT_NEAR(sun_at(0.0).elevation_deg, -70.0, 1e-12);
}

TEST(Sun, NoonElevationIsNinetyMinusLatitudePlusDeclination) {
  EXPECT_NEAR(sun_at(12.0, {50.0, 23.44}).elevation_deg, 63.44, 1e-10);
  EXPECT_NEAR(sun_at(12.0, {50.0, -23.44}).elevation_deg, 16.56, 1e-10);
}

TEST(Sun, MorningMirrorsAfternoon) {
  for (const double t : {0.5, 2.0, 5.0}) {
    const glm::dvec3 a = to_sun(sun_at(12.0 - t, {35.0, 10.0})), b = to_sun(sun_at(12.0 + t, {35.0, 10.0}));
    EXPECT_NEAR(a.x, -b.x, 1e-15);
    EXPECT_NEAR(a.y, b.y, 1e-15);
    EXPECT_NEAR(a.z, b.z, 1e-15);
  }
}

TEST(Sun, AzimuthZeroIsTheSunOfTheSphericalHarmonicsCommand) {
  const glm::dvec3 d = to_sun({30.0, 0.0});  // Zs = 60
  EXPECT_NEAR(d.x, std::sqrt(0.75), 1e-15);
  EXPECT_EQ(d.y, 0.0);
  EXPECT_NEAR(d.z, 0.5, 1e-15);
}

TEST(Sun, WorldFrameKeepsHandednessAndReturns) {
  const glm::dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  EXPECT_EQ(z_up_to_world(z), y);
  EXPECT_EQ(glm::cross(z_up_to_world(x), z_up_to_world(y)), z_up_to_world(z));
  const glm::dvec3 v(1, 2, 3);
  EXPECT_EQ(world_to_z_up(z_up_to_world(v)), v);
}

TEST(ParseSun, TakesElevationAndAzimuth) {
  EXPECT_EQ(parse_sun("35,120").elevation_deg, 35.0);
  EXPECT_EQ(parse_sun("35,120").azimuth_deg, 120.0);
  EXPECT_EQ(parse_sun("-5.5,-720").azimuth_deg, -720.0);
  EXPECT_EQ(parse_sun("90").azimuth_deg, 0.0);
}

TEST(ParseSun, RefusesWhatIsNotAPosition) {
  for (const char* text :
       {"", "x", "35,", "35,120,1", "35;120", "91,0", "-91,0", "nan,0", "10,inf", "35 ,120"})
    EXPECT_THROW((void)parse_sun(text), UserError) << text;
}

TEST(ParseTime, TakesHoursAndMinutes) {
  EXPECT_EQ(parse_time("00:00"), 0.0);
  EXPECT_EQ(parse_time("17:30"), 17.5);
  EXPECT_EQ(parse_time("6:15"), 6.25);
  EXPECT_NEAR(parse_time("23:59"), 24.0, 0.017);
}

TEST(ParseTime, RefusesWhatIsNotATimeOfDay) {
  for (const char* text :
       {"", "12", "24:00", "12:60", "12:5", ":30", "012:00", "-1:00", "1:-1", "12:3x", "12:300", "noon"})
    EXPECT_THROW((void)parse_time(text), UserError) << text;
}

}  // namespace
}  // namespace aluminate::sky
