// Lens models and polarised pairs: round trips, hand-computed positions, refusals.
#include "calibration/lens.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calibration/polarised.hpp"
#include "platform/host/error.hpp"
#include "tests/calibration/synthetic_photo.hpp"

namespace aluminate::calibration {
namespace {

constexpr int kWidth = 6000, kHeight = 4000;

std::vector<LensModel> lenses() {
  std::vector<LensModel> all;
  for (const char* text : {"poly3:-0.03", "poly3:0.02", "poly5:-0.06,0.01", "ptlens:0.012,-0.04,0.01",
                           "ptlens:-0.005,0.02,-0.03", "acm:-0.12,0.05,-0.01,0.002,-0.001",
                           "acm:0.08,-0.02,0.004,0,0", "acm-fisheye:-0.03,0.002"})
    all.push_back(parse_lens(text, kWidth, kHeight, 4200.0));
  return all;
}

TEST(Lens, RoundTripIsBelowAHundredthOfAPixel) {
  for (const LensModel& lens : lenses())
    for (int y = 0; y < kHeight; y += 97)
      for (int x = 0; x < kWidth; x += 131) {
        const Point p{static_cast<double>(x), static_cast<double>(y)};
        EXPECT_LT(length(undistort(lens, distort(lens, p)) - p), 1e-4) << static_cast<int>(lens.kind);
        EXPECT_LT(length(distort(lens, undistort(lens, p)) - p), 1e-4) << static_cast<int>(lens.kind);
      }
}

TEST(Lens, PositionsFollowThePublishedFormulas) {
  const LensModel pt = parse_lens("ptlens:0.01,-0.03,0.02", kWidth, kHeight, 0);
  const double r = 1.5;  // half short sides: 3000 px to the right
  const Point seen = distort(pt, pt.centre + Point{3000, 0});
  EXPECT_NEAR(seen.x - pt.centre.x,
              2000.0 * r * (0.01 * r * r * r - 0.03 * r * r + 0.02 * r + 1.0 - 0.01 + 0.03 - 0.02), 1e-9);
  const LensModel acm = parse_lens("acm:-0.1,0.02,0.003,0.004,0.005", kWidth, kHeight, 4000.0);
  const double x = 0.5, y = 0.25, r2 = x * x + y * y,
               radial = 1 - 0.1 * r2 + 0.02 * r2 * r2 + 0.003 * r2 * r2 * r2;
  const Point q = distort(acm, acm.centre + Point{4000 * x, 4000 * y});
  EXPECT_NEAR((q.x - acm.centre.x) / 4000, x * radial + 2 * (0.004 * y + 0.005 * x) * x + 0.005 * r2, 1e-12);
  EXPECT_NEAR((q.y - acm.centre.y) / 4000, y * radial + 2 * (0.004 * y + 0.005 * x) * y + 0.004 * r2, 1e-12);
  const LensModel fish = parse_lens("acm-fisheye:0.1,0.02", kWidth, kHeight, 4000.0);
  const double theta = std::atan(0.6);
  EXPECT_NEAR((distort(fish, fish.centre + Point{2400, 0}).x - fish.centre.x) / 4000,
              theta + 0.1 * std::pow(theta, 3) + 0.02 * std::pow(theta, 5), 1e-12);
}

TEST(Lens, ModelsThatFoldOverAreRefusedNotGuessed) {
  const LensModel lens = parse_lens("poly3:-0.6", kWidth, kHeight, 0);
  EXPECT_THROW(undistort(lens, {kWidth + 4000.0, kHeight + 4000.0}), UserError);
}

TEST(Lens, WrongTextIsRefused) {
  for (const char* text : {"pt:1", "ptlens", "ptlens:1,2,3,4", "poly3:x", "poly3:nan", "acm:"})
    EXPECT_THROW(parse_lens(text, 100, 100, 100.0), UserError) << text;
  EXPECT_THROW(parse_lens("acm:0.1", 100, 100, 0.0), UserError) << "no focal length";
}

Photo constant_photo(int width, int height, float value) {
  Photo photo;
  photo.width = width;
  photo.height = height;
  photo.rgb_lin.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, value);
  return photo;
}

TEST(Lens, VignetteRoundTripIsBelowOneTenThousandth) {
  LensModel lens = parse_lens("none", 301, 201, 0);
  lens.vignette = {-0.35, 0.08, -0.02};
  Photo photo = constant_photo(301, 201, 0.5f);
  for (int y = 0; y < 201; ++y)
    for (int x = 0; x < 301; ++x)
      for (std::size_t c = 0; c < 3; ++c)
        photo.rgb_lin[3 * (static_cast<std::size_t>(y) * 301 + static_cast<std::size_t>(x)) + c] *=
            static_cast<float>(vignette_at(lens, {static_cast<double>(x), static_cast<double>(y)}));
  EXPECT_LT(photo.pixel(0, 0)[0], 0.4f);
  correct_lens(photo, lens);
  for (const float value : photo.rgb_lin) EXPECT_NEAR(value, 0.5f, 1e-6);  // two float roundings
}

// A photograph with a lens: every channel shows what the ideal scene has where the model says, and is put
// back.
TEST(Lens, DistortionAndLateralColourAreTakenBack) {
  LensModel lens = parse_lens("ptlens:0.02,-0.05,0.03", 240, 160, 0);
  lens.channel_scale[0] = {1.004, 0, 0};
  lens.channel_scale[2] = {0.997, 0, 0};
  const auto scene = [](const Point& p, std::size_t c) {
    return 0.5 + 0.3 * std::sin(0.11 * p.x + 0.4 * static_cast<double>(c)) * std::cos(0.09 * p.y);
  };
  Photo seen = constant_photo(240, 160, 0.0f);
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 240; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        // Where the ideal point is that this channel shows here: fixed-point iteration of the forward model.
        Point ideal{static_cast<double>(x), static_cast<double>(y)};
        for (int i = 0; i < 60; ++i)
          ideal = ideal + (Point{static_cast<double>(x), static_cast<double>(y)} - distort(lens, ideal, c));
        seen.rgb_lin[3 * (static_cast<std::size_t>(y) * 240 + static_cast<std::size_t>(x)) + c] =
            static_cast<float>(scene(ideal, c));
      }
  correct_lens(seen, lens);
  for (int y = 20; y < 140; ++y)
    for (int x = 25; x < 215; ++x)
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(seen.pixel(x, y)[c], scene({static_cast<double>(x), static_cast<double>(y)}, c),
                    4e-4);  // Catmull-Rom on a wave of 57 px: third derivative * 1/24
}

TEST(Lens, DatabaseKnowsACommonLensAndRefusesAnUnknownOne) {
  LensModel lens;
  try {
    lens = lens_from_database(
        {"Canon", "Canon EOS 5D Mark II", "Canon EF 24-105mm f/4L IS USM", 24.0, 4.0, 10.0}, 5616, 3744);
  } catch (const UserError& error) {
    GTEST_SKIP() << "lensfun's data is not installed: " << error.what();
  }
  EXPECT_EQ(lens.kind, LensKind::PtLens);
  const Point corner{0, 0};
  EXPECT_GT(length(distort(lens, corner) - corner), 20.0) << "24 mm on this zoom distorts visibly";
  EXPECT_LT(length(undistort(lens, distort(lens, corner)) - corner), 0.01);
  EXPECT_THROW(lens_from_database({"Nobody", "No Such Camera 9000", "", 24, 4, 10}, 100, 100), UserError);
  EXPECT_THROW(lens_from_database({}, 100, 100), UserError);
}

TEST(Polarised, DiffuseAndSpecularAreRecovered) {
  std::mt19937 random(9);
  for (const double leakage : {0.0, 0.05}) {
    Photo cross = constant_photo(40, 30, 0.0f), parallel = cross;
    std::vector<double> diffuse, specular;
    for (std::size_t i = 0; i < cross.rgb_lin.size(); ++i) {
      diffuse.push_back(static_cast<double>(random()) / 4294967296.0);
      specular.push_back(0.5 * static_cast<double>(random()) / 4294967296.0);
      cross.rgb_lin[i] = static_cast<float>(0.5 * diffuse[i] + leakage * specular[i]);
      parallel.rgb_lin[i] = static_cast<float>(0.5 * diffuse[i] + (1.0 - leakage) * specular[i]);
    }
    const Separated separated = separate_polarised(cross, parallel, leakage);
    for (std::size_t i = 0; i < diffuse.size(); ++i) {
      EXPECT_NEAR(separated.diffuse.rgb_lin[i], diffuse[i], 1e-6);
      EXPECT_NEAR(separated.specular.rgb_lin[i], specular[i], 1e-6);
    }
  }
}

TEST(Polarised, PairsThatDoNotMatchAreRefused) {
  EXPECT_THROW(separate_polarised(constant_photo(4, 4, 0), constant_photo(4, 5, 0), 0.0), UserError);
  EXPECT_THROW(separate_polarised(constant_photo(4, 4, 0), constant_photo(4, 4, 0), 0.5), UserError);
}

}  // namespace
}  // namespace aluminate::calibration
