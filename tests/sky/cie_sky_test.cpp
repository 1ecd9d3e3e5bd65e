// The CIE formula against a second evaluation, the published ratios, its symmetries and its edges; --sky
// parsing.
#include "shading/sky/cie_sky.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace aluminate::sky {
namespace {

// ISO 15469 as printed, typed a second time, in long double and from the spherical law of cosines.
constexpr long double kPrinted[16][5] = {
    {4.0L, -0.70L, 0, -1.0L, 0},       {4.0L, -0.70L, 2, -1.5L, 0.15L},   {1.1L, -0.8L, 0, -1.0L, 0},
    {1.1L, -0.8L, 2, -1.5L, 0.15L},    {0, -1.0L, 0, -1.0L, 0},           {0, -1.0L, 2, -1.5L, 0.15L},
    {0, -1.0L, 5, -2.5L, 0.30L},       {0, -1.0L, 10, -3.0L, 0.45L},      {-1.0L, -0.55L, 2, -1.5L, 0.15L},
    {-1.0L, -0.55L, 5, -2.5L, 0.30L},  {-1.0L, -0.55L, 10, -3.0L, 0.45L}, {-1.0L, -0.32L, 10, -3.0L, 0.45L},
    {-1.0L, -0.32L, 16, -3.0L, 0.30L}, {-1.0L, -0.15L, 16, -3.0L, 0.30L}, {-1.0L, -0.15L, 24, -2.8L, 0.15L},
    {-1.0L, -0.08L, 24, -3.0L, 0.30L}};

long double printed_f(const long double (&p)[5], long double chi) {
  return 1.0L + p[2] * (expl(p[3] * chi) - expl(p[3] * acosl(0.0L))) + p[4] * cosl(chi) * cosl(chi);
}
long double printed_phi(const long double (&p)[5], double zenith_deg) {
  if (zenith_deg >= 90.0) return 1.0L;
  return 1.0L + p[0] * expl(p[1] / cosl(zenith_deg * acosl(-1.0L) / 180.0L));
}
long double printed_chi(double sun_deg, double view_deg, double azimuth_deg) {
  const long double degree = acosl(-1.0L) / 180.0L, zs = sun_deg * degree, z = view_deg * degree;
  const long double cosine = cosl(zs) * cosl(z) + sinl(zs) * sinl(z) * cosl(azimuth_deg * degree);
  return acosl(std::clamp(cosine, -1.0L, 1.0L));
}

TEST(CieSky, EqualsASecondEvaluationForEveryTypeAndDirection) {
  for (std::size_t type = 0; type < kNamedSkies.size(); ++type) {
    const auto& p = kPrinted[type];
    for (const double sun : {0.0, 12.5, 45.0, 78.24, 89.0, 90.0})
      for (const double view : {0.0, 1.0, 30.0, 78.24, 89.9, 90.0})
        for (const double azimuth : {0.0, 33.0, 180.0, -250.0, 720.5}) {
          const SkyTableOutput out = sky_table_row(kNamedSkies[type].parameters, {sun, view, azimuth});
          const long double l = printed_f(p, printed_chi(sun, view, azimuth)) * printed_phi(p, view);
          const double to_zenith =
              static_cast<double>(l / (printed_f(p, sun * acosl(-1.0L) / 180.0L) * printed_phi(p, 0.0)));
          const double to_sun = static_cast<double>(l / (printed_f(p, 0.0L) * printed_phi(p, sun)));
          // The oracle's acos near the sun is good to sqrt(2^-64) = 2e-10, times |c d| = 72, over f(0)
          // near 25.
          EXPECT_NEAR(out.l_over_l_zenith, to_zenith, 1e-9 * (1.0 + to_zenith))
              << type << ' ' << sun << ' ' << view;
          EXPECT_NEAR(out.l_over_l_sun, to_sun, 1e-9 * (1.0 + to_sun)) << type << ' ' << sun << ' ' << view;
        }
  }
}

TEST(CieSky, IsOneAtItsReferenceDirection) {
  for (const NamedSky& row : kNamedSkies)
    for (const double sun : {0.0, 20.0, 70.0, 89.0}) {
      EXPECT_NEAR(sky_table_row(row.parameters, {sun, 0.0, 77.0}).l_over_l_zenith, 1.0, 1e-14) << row.name;
      EXPECT_NEAR(sky_table_row(row.parameters, {sun, sun, 0.0}).l_over_l_sun, 1.0, 1e-14) << row.name;
    }
}

TEST(CieSky, SunOverZenithOfTheClearSkyIsThirtyAtTwelveDegreesOfElevation) {
  const auto ratio = [](const CieParameters& sky, double sun) {
    return sky_table_row(sky, {sun, sun, 0.0}).l_over_l_zenith;
  };
  EXPECT_NEAR(ratio(cie_type(12), 60.0), 13.5, 0.05);  // published digits
  EXPECT_NEAR(ratio(cie_type(12), 75.0), 25.9, 0.05);
  EXPECT_NEAR(ratio(cie_type(12), 78.24), 30.0, 0.05);
  EXPECT_NEAR(ratio(cie_type(12), 85.0), 39.2, 0.05);
  EXPECT_NEAR(ratio(cie_type(12), 90.0), 41.5, 0.05);
  EXPECT_NEAR(ratio(kFarCry3Sky, 62.8), 30.0, 0.1);
  EXPECT_NEAR(ratio(kFarCry3Sky, 85.0), 184.0, 0.5);
  EXPECT_NEAR(ratio(kFarCry3Sky, 90.0), 326.0, 0.5);
}

TEST(CieSky, SunRelativeLuminanceIsBoundedByOneForTheClearSkyButNotForFarCry3) {
  const auto brightest = [](const CieParameters& sky, double sun) {
    double most = 0.0;
    for (double view = 0.0; view <= 90.0; view += 0.25)
      for (double azimuth = 0.0; azimuth <= 180.0; azimuth += 5.0)
        most = std::max(most, sky_table_row(sky, {sun, view, azimuth}).l_over_l_sun);
    return most;
  };
  for (const double sun : {0.0, 30.0, 60.0, 75.0, 90.0}) EXPECT_LE(brightest(cie_type(12), sun), 1.0 + 1e-12);
  EXPECT_NEAR(brightest(kFarCry3Sky, 60.0), 1.67, 5e-3);
  EXPECT_NEAR(brightest(kFarCry3Sky, 75.0), 1.87, 5e-3);
}

TEST(CieSky, IsSymmetricAboutTheSunsPlaneAndUniformWhereTheTypeSaysSo) {
  for (const NamedSky& row : kNamedSkies)
    for (const double azimuth : {10.0, 95.0, 170.0})
      EXPECT_NEAR(sky_table_row(row.parameters, {50, 60, azimuth}).l_over_l_sun,
                  sky_table_row(row.parameters, {50, 60, -azimuth}).l_over_l_sun, 1e-13);
  for (const double view : {0.0, 45.0, 90.0, 135.0})
    EXPECT_EQ(sky_table_row(cie_type(5), {50, view, 20}).l_over_l_zenith, 1.0);
}

TEST(CieSky, IsFiniteAndPositiveInEveryDirectionForEverySunEvenBelowTheHorizon) {
  for (const NamedSky& row : kNamedSkies)
    for (double sun = 0.0; sun <= 180.0; sun += 15.0)
      for (double view = 0.0; view <= 180.0; view += 15.0)
        for (const double azimuth : {0.0, 90.0, 180.0}) {
          const SkyTableOutput out = sky_table_row(row.parameters, {sun, view, azimuth});
          EXPECT_TRUE(std::isfinite(out.l_over_l_zenith) && out.l_over_l_zenith > 0.0)
              << row.name << sun << view;
          EXPECT_TRUE(std::isfinite(out.l_over_l_sun) && out.l_over_l_sun > 0.0) << row.name << sun << view;
        }
}

TEST(CieSky, GradationIsContinuousAtTheHorizonAndConstantBelow) {
  for (const NamedSky& row : kNamedSkies) {
    EXPECT_EQ(gradation(row.parameters, 0.0), 1.0);
    EXPECT_EQ(gradation(row.parameters, -0.5), 1.0);
    EXPECT_NEAR(gradation(row.parameters, 1e-3), 1.0,
                1e-30 + std::fabs(row.parameters.a) * std::exp(row.parameters.b * 1e3));
  }
}

TEST(CieSky, AngleKeepsItsDigitsNearTheSun) {
  const glm::dvec3 sun = direction(1.0, 0.0);
  for (const double offset : {1e-12, 1e-9, 1e-6, 1e-3}) {
    const double chi = angle_between(sun, direction(1.0 + offset, 0.0));
    EXPECT_NEAR(chi, offset, 4e-16);  // rounding of the two unit vectors; acos would be off by 1e-8
  }
  EXPECT_EQ(angle_between(sun, sun), 0.0);
  EXPECT_NEAR(angle_between(sun, -sun), std::numbers::pi, 1e-15);
}

TEST(ParseSky, TakesTypesTheGamesSetAndFiveNumbers) {
  EXPECT_EQ(parse_sky("1"), cie_type(1));
  EXPECT_EQ(parse_sky("15"), cie_type(15));
  EXPECT_EQ(parse_sky("fc3"), kFarCry3Sky);
  EXPECT_EQ(parse_sky("-1, -0.08,+24,-3,.3"), kFarCry3Sky);
  for (int type = 1; type <= 15; ++type) EXPECT_EQ(parse_sky(std::to_string(type)), cie_type(type));
}

TEST(ParseSky, EveryNamedSkyIsPositiveOverTheWholeDome) {
  for (const NamedSky& row : kNamedSkies) EXPECT_NO_THROW(validate(row.parameters)) << row.name;
}

std::string message_of(std::string_view text) {
  try {
    (void)parse_sky(text);
  } catch (const UserError& error) {
    return std::string(error.what()) + " | " + error.hint();
  }
  return "accepted";
}

TEST(ParseSky, SaysWhatIsWrong) {
  using testing::HasSubstr;
  EXPECT_THAT(message_of("16"), HasSubstr("no CIE sky type 16"));
  EXPECT_THAT(message_of("0"), HasSubstr("no CIE sky type 0"));
  EXPECT_THAT(message_of("-3"), HasSubstr("no CIE sky type -3"));
  EXPECT_THAT(message_of("clear"), HasSubstr("unknown sky 'clear' | --sky takes a CIE type 1..15"));
  EXPECT_THAT(message_of(""), HasSubstr("unknown sky ''"));
  EXPECT_THAT(message_of("1,2,3"), HasSubstr("has 3 numbers, expected 5"));
  EXPECT_THAT(message_of("1,-2,3,-4,5,6"), HasSubstr("has 6 numbers, expected 5"));
  EXPECT_THAT(message_of("-1,-0.1,x,-3,0.3"), HasSubstr("parameter c is 'x'"));
  EXPECT_THAT(message_of("-1,-0.1,,-3,0.3"), HasSubstr("parameter c is ''"));
  EXPECT_THAT(message_of("-1,-0.1,nan,-3,0.3"), HasSubstr("parameter c is 'nan'"));
  EXPECT_THAT(message_of("-1,0.1,10,-3,0.3"), HasSubstr("b is 0.1, expected a negative number"));
  EXPECT_THAT(message_of("-2,-0.1,10,-3,0.3"), HasSubstr("zenith gradation"));
}

TEST(ParseSky, RefusesTheSignOfCThatTheSlidesPrint) {
  EXPECT_THAT(message_of("-1,-0.08,-24,-3,0.3"), testing::HasSubstr("try c > 0"));
  EXPECT_THAT(message_of("-1,-0.32,-10,-3,0.45"), testing::HasSubstr("try c > 0"));
}

TEST(ParseSky, RelativeTakesZenithOrSun) {
  EXPECT_EQ(parse_relative("sun"), Relative::Sun);
  EXPECT_EQ(parse_relative("zenith"), Relative::Zenith);
  EXPECT_THROW((void)parse_relative("moon"), UserError);
}

TEST(SkyTable, RefusesAnglesOutsideTheSphereNamingColumnAndPlace) {
  const auto message = [](const SkyTableInput& in) -> std::string {
    try {
      (void)sky_table_row(kFarCry3Sky, in, {"in.csv", 7, 2});
    } catch (const UserError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message({-1, 0, 0}), "in.csv:7:2: sun_zenith_deg is -1, expected 0 to 180 degrees");
  EXPECT_EQ(message({0, 181, 0}), "in.csv:7:2: view_zenith_deg is 181, expected 0 to 180 degrees");
  EXPECT_THAT(message({0, 0, std::numeric_limits<double>::infinity()}),
              testing::HasSubstr("azimuth_from_sun_deg is inf"));
  EXPECT_EQ(message({180, 180, 1e6}), "accepted");
}

}  // namespace
}  // namespace aluminate::sky
