// The whole way, from files to files: accuracy, 16 bits, outputs that others read, batches, damaged input.
#include "calibration/calibrate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "calibration/calibration_files.hpp"
#include "calibration/srgb_codes.hpp"
#include "platform/host/error.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/output_file.hpp"
#include "platform/host/parallel.hpp"
#include "tests/calibration/synthetic_photo.hpp"

namespace aluminate::calibration {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Folder {
 public:
  Folder()
      : path_(fs::path(testing::TempDir()) /
              ("calibrate_test_" + std::to_string(::getpid()) + "_" + std::to_string(count_++))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string path() const { return path_.string(); }

 private:
  static inline int count_ = 0;
  fs::path path_;
};

test::Scene realistic_scene() {
  test::Scene scene;
  scene.camera = test::realistic_camera();
  return scene;
}

TEST(SrgbCodes, EverySixteenBitCodeSurvivesDecodingAndEncoding) {
  const SrgbCodes& codes = SrgbCodes::instance();
  for (int code = 0; code <= 65535; ++code)
    ASSERT_EQ(codes.code16(static_cast<float>(srgb_to_linear(code / 65535.0))), code);
  for (int code = 0; code <= 255; ++code)
    ASSERT_EQ(codes.code8(static_cast<float>(srgb_to_linear(code / 255.0))), code);
  for (double linear = 0.0; linear <= 1.0; linear += 1.7e-5)
    ASSERT_NEAR(codes.encode(static_cast<float>(linear)), linear_to_srgb(linear), 5e-7)
        << linear;  // 2^-24 four times and the chord
  EXPECT_EQ(codes.code16(-0.5f), 0);
  EXPECT_EQ(codes.code16(7.0f), 65535);
  EXPECT_EQ(codes.code16(std::nanf("")), 0);
}

TEST(SixteenBitFiles, HoldTheirExactCodesOnAnyNumberOfThreads) {
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 63}, {5, 64}, {33, 65}, {61, 200}}) {
    std::mt19937 random(2);
    std::vector<std::uint16_t> codes(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::uint16_t& code : codes) code = static_cast<std::uint16_t>(random());
    host::set_thread_count(1);
    const std::vector<std::uint8_t> png = host::encode_png16(width, height, codes, true),
                                    tiff = host::encode_tiff16(width, height, codes);
    host::set_thread_count(3);
    EXPECT_EQ(host::encode_png16(width, height, codes, true), png);
    host::set_thread_count(0);
    for (const auto& file : {png, tiff}) {
      const host::ImageFloat image = host::decode_float(file, "test");
      EXPECT_EQ(image.stored, host::StoredAs::Unorm16);
      ASSERT_EQ(image.width, width);
      ASSERT_EQ(image.texels.size(), codes.size());
      for (std::size_t i = 0; i < codes.size(); ++i)
        ASSERT_EQ(std::lround(image.texels[i] * 65535.0f), codes[i]);
    }
  }
}

TEST(CorrectPhoto, IdentityKeepsSixteenBits) {
  host::ImageFloat image;
  image.width = 256;
  image.height = 256;
  image.channels = {"R", "G", "B"};
  image.stored = host::StoredAs::Unorm16;
  for (int i = 0; i < 65536; ++i)
    for (const int code : {i, 65535 - i, (i * 7919) & 65535})
      image.texels.push_back(static_cast<float>(code) / 65535.0f);
  const std::vector<float> codes = image.texels;
  // The chain goes through xyY and back: what it loses must not reach a code.
  AffinePolyAffine chain;
  for (Polynomial& p : chain.polynomials) p.high = 10.0;
  for (const Transform& identity :
       {Transform(LinearFit{}), Transform(ToneLinear{}),
        Transform(RootPolynomial{1, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}), Transform(chain)}) {
    Photo photo = photo_of(image, Encoding::Srgb, "test");
    correct_photo(photo, identity);
    int worst = 0;
    for (std::size_t i = 0; i < codes.size(); ++i)
      worst = std::max(worst, std::abs(static_cast<int>(SrgbCodes::instance().code16(photo.rgb_lin[i])) -
                                       static_cast<int>(std::lround(codes[i] * 65535.0f))));
    // Chromaticities beyond the box of the first stage are noise and are clamped; the others are exact.
    EXPECT_LE(worst, std::holds_alternative<AffinePolyAffine>(identity) ? 1 : 0) << transform_name(identity);
  }
}

TEST(CorrectPhoto, CountsWhatIsNoMaterial) {
  Photo photo;
  photo.width = 6;
  photo.height = 1;
  photo.clip_low = 0.0;
  photo.rgb_lin = {0.5f, 0.5f, 0.5f, 0.01f, 0.01f, 0.01f, 0.95f, 0.95f, 0.95f,
                   1.0f, 0.5f, 0.5f, 0.0f,  0.2f,  0.2f,  0.3f,  -0.1f, 0.3f};
  const CorrectionCounts counts = correct_photo(photo, LinearFit{});
  EXPECT_EQ(counts.pixels, 6);
  EXPECT_EQ(counts.too_dark, 2);  // 0.01, and the one with negative green
  EXPECT_EQ(counts.too_bright, 1);
  EXPECT_EQ(counts.negative, 1);
  EXPECT_EQ(counts.above_one, 0);
  EXPECT_EQ(counts.clipped_input, 3);
  EXPECT_EQ(photo.rgb_lin[16], 0.0f);
}

TEST(CorrectPhoto, ThreadsDoNotChangeAnything) {
  const test::Scene scene = realistic_scene();
  const Photo photo = photo_of(test::photograph(scene), Encoding::Srgb, "test");
  const PatchColours patches = colours_of(sample_patches(photo, scene.corners));
  const Fit fit = fit_transform(FitKind::AffinePolyAffine, 3, patches, chart_reference(scene.edition));
  host::UninitializedVector<float> first;
  for (const int threads : {1, 2, 5}) {
    host::set_thread_count(threads);
    Photo corrected = photo;
    correct_photo(corrected, fit.transform);
    if (first.empty()) first = corrected.rgb_lin;
    EXPECT_EQ(corrected.rgb_lin, first) << threads;
  }
  host::set_thread_count(0);
}

TEST(Photo, OrientationIsAppliedAsExifSays) {
  // Stored 3 x 2: 1 2 3 / 4 5 6. What is shown for each orientation.
  const std::vector<std::vector<int>> shown{{1, 2, 3, 4, 5, 6}, {3, 2, 1, 6, 5, 4}, {6, 5, 4, 3, 2, 1},
                                            {4, 5, 6, 1, 2, 3}, {1, 4, 2, 5, 3, 6}, {4, 1, 5, 2, 6, 3},
                                            {6, 3, 5, 2, 4, 1}, {3, 6, 2, 5, 1, 4}};
  for (int orientation = 1; orientation <= 8; ++orientation) {
    Photo photo;
    photo.width = 3;
    photo.height = 2;
    for (int i = 1; i <= 6; ++i)
      for (int c = 0; c < 3; ++c) photo.rgb_lin.push_back(static_cast<float>(i));
    apply_orientation(photo, orientation);
    EXPECT_EQ(photo.width, orientation >= 5 ? 2 : 3);
    std::vector<int> values;
    for (std::size_t i = 0; i < 18; i += 3) values.push_back(static_cast<int>(photo.rgb_lin[i]));
    EXPECT_EQ(values, shown[static_cast<std::size_t>(orientation - 1)]) << orientation;
  }
}

TEST(Calibrate, RealisticPhotographMeetsTheBarAndItsAlbedoIsRight) {
  const Folder folder;
  const test::Scene scene = realistic_scene();
  test::write_photograph(scene, folder / "photo.png");
  const Calibration done = calibrate(folder / "photo.png", {},
                                     {folder / "out.png", folder / "out.json", folder / "out.cube",
                                      folder / "out.html", folder / "out.gltf", ""},
                                     "test");
  EXPECT_LE(done.fit.fit.after.mean_de76, 2.5);
  EXPECT_EQ(done.chart.finder, "grid");

  // The corrected file, read again, holds the chart's colours.
  const Photo corrected = photo_of(host::read_image(folder / "out.png"), Encoding::Srgb, "out");
  const PatchSamples patches = sample_patches(corrected, scene.corners);
  const ChartReference& reference = chart_reference(scene.edition);
  double sum = 0.0;
  for (std::size_t i = 0; i < kPatchCount; ++i)
    sum += delta_e_76(rgb_to_lab(patches[i].mean), reference.lab_d65[i]) / 24.0;
  EXPECT_LE(sum, 2.5);
  EXPECT_NEAR(rgb_to_xyz(patches[kWhitePatch].mean)[1], 0.88, 0.03);
  EXPECT_NEAR(rgb_to_xyz(patches[kBlackPatch].mean)[1], 0.031, 0.01);

  const std::string html = host::read_text(folder / "out.html");
  for (const char* part :
       {"<svg", "data:image/png;base64,", "class=\"window", "marker-end", "dark skin", "</html>"})
    EXPECT_THAT(html, HasSubstr(part));
  EXPECT_EQ(html.find("http"), std::string::npos) << "the page must not load anything";
  const nlohmann::json gltf = nlohmann::json::parse(host::read_text(folder / "out.gltf"));
  EXPECT_EQ(gltf["images"][0]["uri"], "out.png");
}

TEST(Calibrate, JsonRepeatsTheCorrectionByHand) {
  const Folder folder;
  test::write_photograph(realistic_scene(), folder / "photo.png");
  CalibrationOptions options;
  for (const auto& [kind, degree] : {std::pair{FitKind::Linear, 1},
                                     {FitKind::ToneLinear, 1},
                                     {FitKind::RootPoly, 2},
                                     {FitKind::AffinePolyAffine, 3}}) {
    options.fit = kind;
    options.degree = degree;
    const Calibration done =
        calibrate(folder / "photo.png", options, {"", folder / "out.json", "", "", "", ""}, "test");
    const nlohmann::json json = nlohmann::json::parse(host::read_text(folder / "out.json"));
    EXPECT_EQ(json["schema"], "aluminate.calibrate/1");
    ASSERT_EQ(json["patches"].size(), 24u);
    const auto affine = [](const nlohmann::json& m, const Colour& v) {
      Colour out{};
      for (std::size_t i = 0; i < 3; ++i)
        out[i] = m[i][0].get<double>() * v[0] + m[i][1].get<double>() * v[1] + m[i][2].get<double>() * v[2] +
                 m[i][3].get<double>();
      return out;
    };
    const nlohmann::json& t = json["transform"];
    for (const nlohmann::json& patch : json["patches"]) {
      Colour v{patch["photo_lin"][0], patch["photo_lin"][1], patch["photo_lin"][2]};
      if (kind == FitKind::Linear) v = affine(t["matrix"], v);
      if (kind == FitKind::ToneLinear) {
        for (double& x : v) x = std::pow(x, t["exponent"].get<double>());
        v = affine(t["matrix"], v);
      }
      if (kind == FitKind::RootPoly) {
        const std::vector<double> terms = root_terms(2, v);
        v = {};
        for (std::size_t i = 0; i < terms.size(); ++i)
          for (std::size_t c = 0; c < 3; ++c)
            v[c] += terms[i] * t["coefficients"][std::string(root_term_names()[i])][c].get<double>();
      }
      if (kind == FitKind::AffinePolyAffine) {
        v = affine(t["first"], xyz_to_xyy(rgb_to_xyz(v)));
        for (std::size_t c = 0; c < 3; ++c) {
          double sum = 0.0, power = 1.0;
          for (const nlohmann::json& a : t["polynomials"][c]["coefficients"])
            sum += a.get<double>() * power, power *= v[c];
          v[c] = sum;
        }
        v = xyz_to_rgb(xyy_to_xyz(affine(t["last"], v)));
      }
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(v[c], patch["corrected_lin"][c].get<double>(), 1e-12) << t["name"];
    }
    for (std::size_t i = 1; i < json["stage_rms_xyy"].size(); ++i)
      EXPECT_LE(json["stage_rms_xyy"][i], json["stage_rms_xyy"][i - 1]);
    EXPECT_EQ(done.width, 640);
  }
}

TEST(Cube, HoldsTheTransformAtItsPointsRedFastest) {
  LinearFit fit;
  fit.matrix.m = {{{0.5, 0.2, 0.1, 0.01}, {0.1, 0.6, 0.1, 0.02}, {0.0, 0.2, 0.7, 0.03}}};
  std::istringstream text(cube_text(fit, 5, "a \"title\""));
  std::vector<Colour> points;
  int size = 0;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("LUT_3D_SIZE")) size = std::stoi(line.substr(11));
    if (line.starts_with("TITLE")) {
      EXPECT_EQ(line, "TITLE \"a 'title'\"");
    }
    Colour c{};
    if (std::sscanf(line.c_str(), "%lf %lf %lf", &c[0], &c[1], &c[2]) == 3) points.push_back(c);
  }
  ASSERT_EQ(size, 5);
  ASSERT_EQ(points.size(), 125u);
  for (std::size_t i = 0; i < 125; ++i) {
    const Colour in{srgb_to_linear(static_cast<double>(i % 5) / 4),
                    srgb_to_linear(static_cast<double>(i / 5 % 5) / 4),
                    srgb_to_linear(static_cast<double>(i / 25) / 4)};
    const Colour out = correct(Transform(fit), in);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(points[i][c], std::min(linear_to_srgb(out[c]), 1.0), 6e-7) << i;
  }
  EXPECT_THROW(cube_text(fit, 1, ""), UserError);
}

TEST(Calibrate, ExrIsLinearAndUnclipped) {
  const Folder folder;
  const test::Scene scene = realistic_scene();
  test::write_photograph(scene, folder / "photo.png");
  calibrate(folder / "photo.png", {}, {folder / "out.exr", "", "", "", "", ""}, "test");
  calibrate(folder / "photo.png", {}, {folder / "out.tif", "", "", "", "", ""}, "test");
  const host::ImageFloat exr = host::read_image(folder / "out.exr"),
                         tif = host::read_image(folder / "out.tif");
  ASSERT_EQ(exr.texels.size(), tif.texels.size());
  EXPECT_EQ(tif.stored, host::StoredAs::Unorm16);
  for (std::size_t i = 0; i < exr.texels.size(); ++i)
    ASSERT_NEAR(linear_to_srgb(std::min(static_cast<double>(exr.texels[i]), 1.0)),
                static_cast<double>(tif.texels[i]), 0.51 / 65535.0);  // half a code and its rounding
}

TEST(Calibrate, PolarisedPairGivesAlbedoAndSpecular) {
  const Folder folder;
  test::Scene scene;
  scene.camera.code_max = 65535;
  const host::ImageFloat diffuse = test::photograph(scene);
  const auto write = [&](double specular, const std::string& path) {
    std::vector<std::uint16_t> codes;
    for (const float value : diffuse.texels)
      codes.push_back(static_cast<std::uint16_t>(std::lround(
          65535.0 *
          linear_to_srgb(std::min(1.0, 0.5 * srgb_to_linear(static_cast<double>(value)) + specular)))));
    host::write_file(path, host::encode_png16(scene.width, scene.height, codes, true));
  };
  write(0.0, folder / "cross.png");
  write(0.2, folder / "parallel.png");
  CalibrationOptions options;
  options.parallel = folder / "parallel.png";
  options.fit = FitKind::Linear;
  const Calibration done =
      calibrate(folder / "cross.png", options, {"", "", "", "", "", folder / "specular.exr"}, "test");
  EXPECT_LT(done.fit.fit.after.mean_de2000, 0.2);  // cyan's red was lost in the file
  const host::ImageFloat specular = host::read_image(folder / "specular.exr");
  double sum = 0.0;
  for (const float value : specular.texels) sum += static_cast<double>(value);
  EXPECT_NEAR(sum / static_cast<double>(specular.texels.size()), 0.2,
              0.002);  // the fit's own scale: within 1 %
  options.parallel.clear();
  EXPECT_THROW(
      calibrate(folder / "cross.png", options, {"", "", "", "", "", folder / "specular.exr"}, "test"),
      UserError);
}

TEST(Calibrate, DamagedAndWrongFilesAreErrorsThatNameThemAndLeaveNothing) {
  const Folder folder;
  test::write_photograph(realistic_scene(), folder / "photo.png");
  const std::vector<std::uint8_t> good = host::read_bytes(folder / "photo.png");
  host::write_file(folder / "cut.png", std::span(good).first(good.size() / 2));
  std::vector<std::uint8_t> bad = good;
  for (std::size_t i = good.size() / 2; i < good.size() / 2 + 64; ++i) bad[i] ^= 0x5a;
  host::write_file(folder / "bad.png", bad);
  host::write_file(folder / "text.jpg", std::string_view("not a picture"));
  host::write_file(folder / "broken.dng", std::string_view("II*\0garbage that is no TIFF at all", 34));
  host::write_file(folder / "broken.tif", std::string_view("II*\0\x08\0\0\0\xff\xff", 10));
  for (const char* name : {"cut.png", "bad.png", "text.jpg", "broken.dng", "broken.tif", "missing.png"}) {
    try {
      calibrate(folder / name, {}, {folder / "out.png", "", "", "", "", ""}, "test");
      ADD_FAILURE() << name;
    } catch (const UserError& error) {
      EXPECT_THAT(error.what(), HasSubstr(name));
    }
    EXPECT_FALSE(fs::exists(folder / "out.png")) << name;
  }
  EXPECT_THROW(calibrate(folder / "photo.png", {}, {folder / "out.jpg", "", "", "", "", ""}, "test"),
               UserError);
  EXPECT_THROW(
      calibrate(folder / "photo.png", {}, {folder / "no/such/folder/out.png", "", "", "", "", ""}, "test"),
      UserError);
}

TEST(Batch, OneFailureNeverStopsTheRest) {
  const Folder folder;
  fs::create_directories(folder / "in");
  test::Scene scene = realistic_scene();
  test::write_photograph(scene, folder / "in/a.png");
  test::write_photograph(scene, folder / "in/c.png");
  scene.has_chart = false;
  test::write_photograph(scene, folder / "in/b.png");
  host::write_file(folder / "in/d.jpg", std::string_view("not a picture"));
  host::write_file(folder / "in/notes.txt", std::string_view("left alone"));
  const std::vector<BatchItem> items = calibrate_folder(folder / "in", folder / "out", ".png", {}, "test");
  ASSERT_EQ(items.size(), 4u);
  EXPECT_TRUE(items[0].done && items[2].done);
  EXPECT_FALSE(items[1].done || items[3].done);
  EXPECT_THAT(items[1].reason, HasSubstr("no ColorChecker"));
  EXPECT_TRUE(fs::exists(folder / "out/a.png") && fs::exists(folder / "out/c.png.json"));
  EXPECT_FALSE(fs::exists(folder / "out/b.png"));
  EXPECT_THAT(batch_text(items), HasSubstr("2 of 4 photographs calibrated, 2 refused"));
  EXPECT_THROW(calibrate_folder(folder / "nowhere", folder / "out", ".png", {}, "test"), UserError);
  EXPECT_THROW(calibrate_folder(folder / "in", folder / "in", ".png", {}, "test"), UserError)
      << "photographs would be overwritten";
  EXPECT_THROW(calibrate_folder(folder / "in", folder / "out", ".jpg", {}, "test"), UserError);
}

TEST(Batch, PhotographsOfOneStemDoNotOverwriteEachOther) {
  const Folder folder;
  fs::create_directories(folder / "in");
  for (const char* name : {"in/wall.jpg", "in/Wall.png", "in/floor.tif"})
    host::write_file(folder / name, std::string_view("not a picture"));
  std::vector<std::string> outputs;
  for (const BatchItem& item : calibrate_folder(folder / "in", folder / "out", ".png", {}, "test"))
    outputs.push_back(fs::path(item.output).filename().string());
  EXPECT_THAT(outputs, testing::ElementsAre("Wall.png.png", "floor.png", "wall.jpg.png"));
}

TEST(Calibrate, DoubtsAreToldAndReachEveryReport) {
  const Folder folder;
  test::Scene scene = realistic_scene();
  EXPECT_EQ((test::write_photograph(scene, folder / "good.png"),
             calibrate(folder / "good.png", {}, {}, "test").warnings),
            std::vector<std::string>{});
  scene.camera.balance = {1.6, 1.6, 1.6};  // several patches leave the range
  test::write_photograph(scene, folder / "photo.png");
  const Calibration done =
      calibrate(folder / "photo.png", {}, {"", folder / "out.json", "", folder / "out.html", "", ""}, "test");
  EXPECT_THAT(done.warnings, testing::Contains(HasSubstr("of 24 patches are not used")));
  for (const std::string& warning : done.warnings) {
    EXPECT_THAT(host::read_text(folder / "out.json"), HasSubstr(warning));
    EXPECT_THAT(host::read_text(folder / "out.html"), HasSubstr(warning));
  }
}

TEST(Calibrate, ReportIsAlsoAPicture) {
  const Folder folder;
  test::write_photograph(realistic_scene(), folder / "photo.png");
  calibrate(folder / "photo.png", {}, {"", "", "", folder / "out.png", "", ""}, "test");
  const host::Image8 page = host::read_image_rgba8(folder / "out.png");
  EXPECT_GT(page.width, 2 * 640);
  EXPECT_GT(page.height, 2 * 480);
  std::size_t green = 0, blue = 0;
  for (std::size_t i = 0; i < page.texels.size(); i += 4) {
    const std::uint8_t* p = page.texels.data() + i;
    green += p[0] == 0 && p[1] == 255 && p[2] == 0 ? 1 : 0;
    blue += p[0] == 0 && p[1] == 102 && p[2] == 204 ? 1 : 0;
  }
  EXPECT_GT(green, 24u * 4 * 20) << "24 windows of 26 px";
  EXPECT_GT(blue, 24u) << "what remains of each patch";
}

TEST(Calibrate, SummaryListsEveryPatchAndEveryFit) {
  const Folder folder;
  test::write_photograph(realistic_scene(), folder / "photo.png");
  const std::string text = summary_text(calibrate(folder / "photo.png", {}, {}, "test"));
  for (const std::string_view name : patch_names()) EXPECT_THAT(text, HasSubstr(std::string(name)));
  for (const char* part : {"tone-linear", "affine-poly-affine 5", "root-poly 3", "dE2000 mean", "white 0.8"})
    EXPECT_THAT(text, HasSubstr(part));
}

}  // namespace
}  // namespace aluminate::calibration
