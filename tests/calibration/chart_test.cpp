// Geometry, sampling and detection on photographs whose answer is known, and on the public ones when they are
// there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "calibration/find_chart.hpp"
#include "calibration/raw_file.hpp"
#include "platform/host/error.hpp"
#include "platform/host/input_file.hpp"
#include "tests/calibration/synthetic_photo.hpp"

namespace aluminate::calibration {
namespace {

using testing::HasSubstr;

const ChartReference& reference() { return chart_reference(ChartEdition::After2014); }

test::Scene realistic(const Corners& corners) {
  test::Scene scene;
  scene.corners = corners;
  scene.camera = test::realistic_camera();
  scene.camera.noise = 0.01;
  return scene;
}

Photo taken(const test::Scene& scene) { return photo_of(test::photograph(scene), Encoding::Srgb, "test"); }

std::string refusal(const Photo& photo) {
  try {
    find_chart(photo, reference(), "photo.png");
  } catch (const UserError& error) {
    return error.what();
  }
  return "found";
}

TEST(Homography, GoesThroughItsCornersAndBack) {
  const Corners corners{{{100, 80}, {420, 130}, {390, 300}, {70, 260}}};
  const Homography to_photo(corners), to_chart = to_photo.inverse();
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT(length(to_photo(kChartCorners[i]) - corners[i]), 1e-9);
    EXPECT_LT(length(to_chart(corners[i]) - kChartCorners[i]), 1e-11);
  }
}

TEST(Corners, TextIsReadAndWrongTextRefused) {
  EXPECT_EQ(parse_corners("1,2;3.5,4; 5,6 ;7,8"), (Corners{{{1, 2}, {3.5, 4}, {5, 6}, {7, 8}}}));
  for (const char* text : {"", "1,2", "1,2;3,4;5,6;7", "1,2;3,4;5,6;7,8;9,10", "a,b;c,d;e,f;g,h",
                           "1,2;3,4;5,6;7,nan", "1,2;3,4;5,6;7,8x"})
    EXPECT_THROW(parse_corners(text), UserError) << text;
}

TEST(Corners, ImpossibleQuadrilateralsAreRefused) {
  const auto message = [](const Corners& corners) -> std::string {
    try {
      check_corners(corners, 640, 480);
    } catch (const UserError& error) {
      return error.what();
    }
    return "fine";
  };
  EXPECT_EQ(message({{{100, 100}, {400, 100}, {400, 280}, {100, 280}}}), "fine");
  EXPECT_THAT(message({{{100, 280}, {400, 280}, {400, 100}, {100, 100}}}), HasSubstr("mirrored"));
  EXPECT_THAT(message({{{100, 100}, {400, 280}, {400, 100}, {100, 280}}}), HasSubstr("convex"));
  EXPECT_THAT(message({{{100, 100}, {200, 100}, {300, 100}, {100, 280}}}), HasSubstr("one line"));
  EXPECT_THAT(message({{{100, 100}, {700, 100}, {700, 280}, {100, 280}}}), HasSubstr("outside"));
  EXPECT_THAT(message({{{100, 100}, {110, 100}, {110, 106}, {100, 106}}}), HasSubstr("too small"));
}

TEST(Sampling, MeansAreThePatchesAndDeviationsTheNoise) {
  test::Scene scene;
  scene.camera.code_max = 65535;
  const PatchSamples clean = sample_patches(taken(scene), scene.corners);
  for (std::size_t i = 0; i < kPatchCount; ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double expected =
          std::max(reference().rgb_lin[i][c], 0.0);  // the file cannot hold cyan's negative red
      EXPECT_NEAR(clean[i].mean[c], expected, 1e-4 * expected + 2e-6)
          << i;  // half a 16-bit step, decoded: at most 2e-5 of the value
    }
  scene.camera.noise = 0.02;
  const PatchSamples noisy = sample_patches(taken(scene), scene.corners);
  const double expected_sd =
      0.02 * (srgb_to_linear(0.51) - srgb_to_linear(0.49)) / 0.02;  // neutral 5 is near code 0.5
  EXPECT_NEAR(noisy[21].deviation[1], expected_sd, 0.25 * expected_sd);
  for (const PatchSample& sample : noisy) EXPECT_GT(sample.pixels, 300);
}

TEST(Sampling, DirtAndReflectionsDoNotMoveTheMean) {
  test::Scene scene;
  scene.camera.code_max = 65535;
  const PatchSamples clean = sample_patches(taken(scene), scene.corners);
  scene.change = [](const Point& chart, const Colour& colour) {
    const double dx = chart.x - 2.05, dy = chart.y - 1.05;  // a spot on moderate red
    return dx * dx + dy * dy < 0.004 ? Colour{0.95, 0.95, 0.95} : colour;
  };
  const PatchSamples dirty = sample_patches(taken(scene), scene.corners);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(dirty[8].mean[c], clean[8].mean[c], 1e-3);
  EXPECT_GT(dirty[8].outliers, 0);
}

TEST(Sampling, ClippedAndUnevenPatchesAreReportedAndLeftOut) {
  test::Scene scene;
  scene.camera.code_max = 255;
  scene.camera.balance = {1.3, 1.3, 1.3};  // white leaves the range
  scene.change = [](const Point& chart, const Colour& colour) {
    const double light = chart.y > 1.5 || chart.x > 0.5 ? 1.0
                         : chart.x < 0.0                ? 0.5
                                                        : 1.0;  // a shadow over half of two patches
    return Colour{light * colour[0], light * colour[1], light * colour[2]};
  };
  const PatchSamples samples = sample_patches(taken(scene), scene.corners);
  EXPECT_TRUE(samples[kWhitePatch].is_clipped());
  EXPECT_FALSE(samples[kWhitePatch].usable());
  EXPECT_TRUE(samples[0].is_uneven());
  EXPECT_FALSE(samples[0].usable());
  EXPECT_FALSE(samples[6].usable());
  EXPECT_TRUE(samples[21].usable());
  EXPECT_FALSE(samples[21].is_uneven());
}

double worst_centre_error(const Corners& found, const Corners& truth) {
  const auto a = patch_centres(found), b = patch_centres(truth);
  double worst = 0.0;
  for (std::size_t i = 0; i < kPatchCount; ++i) worst = std::max(worst, length(a[i] - b[i]));
  return worst / chart_width_px(truth);
}

TEST(FindChart, EveryPositionAndTurnIsFoundToOnePercent) {
  const Corners upright{{{160, 130}, {480, 130}, {480, 322}, {160, 322}}};
  std::vector<Corners> positions{upright};
  const Point centre{320, 226};
  for (const double degrees : {17.0, 90.0, 143.0, 180.0, 270.0}) {
    Corners turned{};
    const double c = std::cos(degrees * 0.017453292519943295), s = std::sin(degrees * 0.017453292519943295);
    for (std::size_t i = 0; i < 4; ++i) {
      const Point arm = 0.9 * (upright[i] - centre);
      turned[i] = centre + Point{c * arm.x - s * arm.y, s * arm.x + c * arm.y};
    }
    positions.push_back(turned);
  }
  positions.push_back({{{150, 120}, {470, 160}, {440, 330}, {180, 350}}});  // perspective
  positions.push_back({{{300, 200}, {360, 203}, {358, 239}, {298, 236}}});  // patches of 10 px
  positions.push_back({{{60, 60}, {580, 60}, {580, 372}, {60, 372}}});      // nearly the whole frame
  for (const Corners& corners : positions) {
    const Photo photo = taken(realistic(corners));
    const FoundChart found = find_chart(photo, reference(), "test");
    EXPECT_LT(worst_centre_error(found.corners, corners), 0.01) << corners[0].x << ',' << corners[0].y;
    EXPECT_GT(found.agreement, 0.9);
    EXPECT_EQ(found.finder, "grid");
  }
}

TEST(FindChart, OpenCvsProposalsAreAlignedAlike) {
  const test::Scene scene = realistic({{{160, 130}, {480, 130}, {480, 322}, {160, 322}}});
  const FoundChart found = find_chart(taken(scene), reference(), "test", ChartFinder::OpenCv);
  EXPECT_EQ(found.finder, "opencv mcc");
  EXPECT_LT(worst_centre_error(found.corners, scene.corners), 0.01);
}

TEST(FindChart, NoChartIsRefused) {
  test::Scene scene = realistic({{{160, 130}, {480, 130}, {480, 322}, {160, 322}}});
  scene.has_chart = false;
  EXPECT_THAT(refusal(taken(scene)), HasSubstr("no ColorChecker was found"));
}

TEST(FindChart, AGridOfOtherColoursIsRefused) {
  test::Scene scene = realistic({{{160, 130}, {480, 130}, {480, 322}, {160, 322}}});
  scene.change = [](const Point& chart, const Colour& colour) {
    if (colour[0] < 0.026 && colour[1] < 0.026 && colour[0] > 0.0) return colour;
    const unsigned k =
        static_cast<unsigned>(std::lround(chart.x)) * 7u + static_cast<unsigned>(std::lround(chart.y)) * 13u;
    return Colour{0.1 + 0.09 * (k * 5u % 9u), 0.1 + 0.09 * (k * 7u % 9u), 0.1 + 0.09 * (k * 11u % 9u)};
  };
  EXPECT_THAT(refusal(taken(scene)), HasSubstr("no complete ColorChecker"));
}

TEST(FindChart, HalfAChartIsRefusedAsCutOff) {
  // Three columns of six outside on the right; two rows of four outside below.
  for (const Corners& corners : {Corners{{{350, 130}, {850, 130}, {850, 430}, {350, 430}}},
                                 Corners{{{70, 300}, {570, 300}, {570, 600}, {70, 600}}}}) {
    EXPECT_THAT(refusal(taken(realistic(corners))), HasSubstr("cut off"));
  }
}

TEST(FindChart, BlurBeyondUseIsRefusedAndLessIsNot) {
  test::Scene scene = realistic({{{160, 130}, {480, 130}, {480, 322}, {160, 322}}});  // patches 64 px apart
  scene.camera.noise = 0.0;
  scene.blur_px = 3.0;
  EXPECT_EQ(refusal(taken(scene)), "found");
  scene.blur_px = 22.0;
  EXPECT_THAT(refusal(taken(scene)), HasSubstr("blurred"));
}

TEST(GivenCorners, AreKeptAndJudged) {
  const test::Scene scene = realistic({{{150, 120}, {470, 160}, {440, 330}, {180, 350}}});
  const Photo photo = taken(scene);
  EXPECT_EQ(check_chart(photo, scene.corners, reference(), "p").corners, scene.corners);
  const auto message = [&](const Corners& corners) -> std::string {
    try {
      check_chart(photo, corners, reference(), "p");
    } catch (const UserError& error) {
      return error.what();
    }
    return "fine";
  };
  const Corners& c = scene.corners;
  EXPECT_THAT(message({c[2], c[3], c[0], c[1]}), HasSubstr("the first is black, expected dark skin"));
  EXPECT_THAT(message({c[1], c[2], c[3], c[0]}), HasSubstr("the first is bluish green"));
  EXPECT_THAT(message({{{20, 20}, {120, 20}, {120, 80}, {20, 80}}}), HasSubstr("not a ColorChecker's"));
  EXPECT_THAT(message({{{5, 5}, {470, 160}, {440, 330}, {180, 350}}}), HasSubstr("cut off"));
}

// The public photographs: corner centres were placed by eye, within 1.5 % of the chart's width.
TEST(PublicPhotos, CornersOrderAndCentresAreTheAnnotatedOnes) {
  const std::string folder = std::string(ALUMINATE_SHARED_DIR) + "/colorchecker/";
  if (!std::filesystem::exists(folder + "annotations.json"))
    GTEST_SKIP() << "no public photographs at " << folder;
  const nlohmann::json annotations = nlohmann::json::parse(host::read_text(folder + "annotations.json"));
  int seen = 0;
  for (const auto& entry : annotations["images"]) {
    const std::string file = entry["file"];
    const std::string path = folder + file;
    if (!std::filesystem::exists(path) || file.find("labels") != std::string::npos) continue;
    const bool is_mosaic = file.ends_with(".tif");
    const Photo photo = is_mosaic ? demosaic(mosaic_of_grey(host::read_image(path), "GBRG", path), "mosaic")
                                  : photo_of(host::read_image(path), Encoding::Srgb, path);
    const FoundChart found = find_chart(photo, reference(), file);
    const auto centres = patch_centres(found.corners);
    for (std::size_t i = 0; i < kPatchCount; ++i) {
      const Point annotated{entry["patch_centres"][i][0], entry["patch_centres"][i][1]};
      EXPECT_LT(length(centres[i] - annotated), 0.02 * chart_width_px(found.corners))
          << file << " patch " << i + 1;
    }
    ++seen;
  }
  EXPECT_GE(seen, 4);
}

TEST(PublicPhotos, LabelsOfTheMosaicAreMet) {
  const std::string folder = std::string(ALUMINATE_SHARED_DIR) + "/colorchecker/";
  const std::string labels = folder + "bllanos_d2_colorChecker30cm_550nm_labels.png",
                    mosaic = folder + "bllanos_d2_colorChecker30cm_raw01.tif";
  if (!std::filesystem::exists(labels) || !std::filesystem::exists(mosaic))
    GTEST_SKIP() << "no public photographs at " << folder;
  const host::Image8 label = host::read_image_rgba8(labels);
  const Photo photo = demosaic(mosaic_of_grey(host::read_image(mosaic), "GBRG", mosaic), "mosaic");
  const auto centres = patch_centres(find_chart(photo, reference(), mosaic).corners);
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    const std::size_t x = static_cast<std::size_t>(std::lround(centres[i].x)),
                      y = static_cast<std::size_t>(std::lround(centres[i].y));
    EXPECT_EQ(label.texels[4 * (y * static_cast<std::size_t>(label.width) + x)], i + 1);
  }
}

}  // namespace
}  // namespace aluminate::calibration
