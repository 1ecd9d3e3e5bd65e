// glTF in, right picture out: orthographic scenes where one unit is one pixel, so that every stored byte can
// be foretold.
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "platform/console/platform_file.hpp"
#include "platform/host/image_file.hpp"
#include "scenes/loader.hpp"
#include "shading/passes/frame.hpp"
#include "shading/passes/inspect.hpp"
#include "shading/report/frame_cost.hpp"
#include "shading/vm/srgb.hpp"
#include "tests/scenes/gltf_file.hpp"

namespace aluminate::passes {
namespace {

using scenes::test::Bytes;
using scenes::test::GltfFile;
using scenes::test::json;
using scenes::test::TempFolder;

using Color = std::array<int, 3>;
constexpr Color kBackground{13, 15, 20};  // 0.05, 0.06, 0.08 of 255, rounded

/// A picture of width x height pixels seen straight on: x to the right and y down in pixels, z towards the
/// viewer.
class FlatScene {
 public:
  FlatScene(int width, int height) : width_(width), height_(height) {
    file_.append("cameras", {{"type", "orthographic"},
                             {"orthographic",
                              {{"xmag", width / 2.0}, {"ymag", height / 2.0}, {"znear", 1}, {"zfar", 101}}}});
    file_.add_node({{"camera", 0}, {"translation", {width / 2.0, height / 2.0, 100.0}}});
    file_.root["extensionsUsed"] = json::array({"KHR_materials_unlit"});
  }

  int unlit(double r, double g, double b, double a = 1, const json& more = json::object()) {
    json material = {{"pbrMetallicRoughness", {{"baseColorFactor", {r, g, b, a}}}},
                     {"extensions", {{"KHR_materials_unlit", json::object()}}}};
    material.update(more);
    return file_.append("materials", material);
  }

  /// An unlit material that shows the image, nearest texel.
  int unlit_image(const host::Image8& image) {
    const Bytes png = host::encode_png(image);
    file_.append("images", {{"bufferView", file_.add_view(png)}, {"mimeType", "image/png"}});
    file_.append("samplers", {{"magFilter", 9728}, {"minFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33071}});
    file_.append("textures", {{"source", 0}, {"sampler", 0}});
    return file_.append("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                                      {"extensions", {{"KHR_materials_unlit", json::object()}}}});
  }

  void rectangle(double x0, double y0, double x1, double y1, double z, int material,
                 bool facing_away = false) {
    const auto f = [](double v) { return static_cast<float>(v); };
    const float top = f(height_ - y0), bottom = f(height_ - y1);
    const int positions =
        file_.add_vec3({f(x0), top, f(z), f(x1), top, f(z), f(x0), bottom, f(z), f(x1), bottom, f(z)});
    const int uvs = file_.add_vec2({0, 0, 1, 0, 0, 1, 1, 1});
    const int indices = file_.add_indices(facing_away ? std::vector<std::uint16_t>{0, 1, 2, 1, 3, 2}
                                                      : std::vector<std::uint16_t>{0, 2, 1, 1, 2, 3});
    file_.add_node({{"mesh", file_.add_mesh({{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uvs}}},
                                             {"indices", indices},
                                             {"material", material}})}});
  }

  FrameOptions options() const {
    FrameOptions options;
    options.width = width_;
    options.height = height_;
    return options;
  }
  scenes::Scene scene() const {
    const TempFolder folder;
    return scenes::load_scene(file_.write_glb(folder));
  }
  Frame render(int msaa = 1) const {
    FrameOptions chosen = options();
    chosen.msaa = msaa;
    return render_frame(scene(), chosen);
  }

 private:
  int width_, height_;
  GltfFile file_;
};

Color pixel(const Frame& frame, int x, int y) {
  const std::uint8_t* p = &frame.rgba8[static_cast<std::size_t>(y * frame.width + x) * 4];
  return {p[0], p[1], p[2]};
}

/// The stored byte of a linear value.
int code(double linear) { return vm::srgb_encode8(static_cast<float>(linear)); }
double background(int channel) {
  return vm::srgb_decode16(static_cast<std::uint8_t>(kBackground[static_cast<std::size_t>(channel)])) /
         65535.0;
}

TEST(GltfPicture, RectanglesAreExactToThePixel) {
  struct Place {
    int x0, y0, x1, y1;
  };
  // In corners of the picture and across tiles; the last one nearest.
  const Place places[] = {{0, 0, 10, 7},    {118, 80, 131, 97}, {60, 50, 70, 90},
                          {20, 20, 21, 21}, {63, 63, 65, 65},   {0, 96, 131, 97}};
  FlatScene flat(131, 97);
  std::vector<Color> colors;
  for (std::size_t i = 0; i < std::size(places); ++i) {
    const double r = static_cast<double>(i + 1) / 8, g = 1 - r, b = i % 2 ? 1 : 0.25;
    flat.rectangle(places[i].x0, places[i].y0, places[i].x1, places[i].y1, static_cast<double>(i),
                   flat.unlit(r, g, b));
    colors.push_back({code(r), code(g), code(b)});
  }
  for (const int msaa : {1, 4}) {  // edges between pixels: four samples see what one sees
    const Frame frame = flat.render(msaa);
    for (int y = 0; y < 97; ++y)
      for (int x = 0; x < 131; ++x) {
        Color expected = kBackground;
        for (std::size_t i = 0; i < std::size(places); ++i)
          if (x >= places[i].x0 && x < places[i].x1 && y >= places[i].y0 && y < places[i].y1)
            expected = colors[i];
        ASSERT_EQ(pixel(frame, x, y), expected) << x << "," << y << " at " << msaa << "x";
      }
  }
}

TEST(GltfPicture, EdgesThroughPixelCentresOwnTheLeftAndTop) {
  FlatScene flat(32, 32);
  flat.rectangle(5.5, 7.5, 15.5, 20.5, 0, flat.unlit(1, 1, 1));
  const Frame frame = flat.render();
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x)
      ASSERT_EQ(pixel(frame, x, y) == kBackground, !(x >= 5 && x < 15 && y >= 7 && y < 20)) << x << "," << y;
}

TEST(GltfPicture, SingleSidedSurfacesAreSeenFromTheFrontOnly) {
  FlatScene flat(40, 20);
  const int single = flat.unlit(1, 0, 0), both = flat.unlit(0, 1, 0, 1, {{"doubleSided", true}});
  flat.rectangle(0, 0, 10, 20, 0, single);
  flat.rectangle(10, 0, 20, 20, 0, single, true);
  flat.rectangle(20, 0, 30, 20, 0, both);
  flat.rectangle(30, 0, 40, 20, 0, both, true);
  const Frame frame = flat.render();
  const Color expected[] = {{255, 0, 0}, kBackground, {0, 255, 0}, {0, 255, 0}};
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 40; ++x) ASSERT_EQ(pixel(frame, x, y), expected[x / 10]) << x << "," << y;
  EXPECT_EQ(frame.skipped.at("facing"), 2u);
}

TEST(GltfPicture, UnlitColoursComeThroughForEveryCode) {
  FlatScene flat(64, 4);
  for (int i = 0; i < 64; ++i) {
    const double linear = vm::srgb_decode16(static_cast<std::uint8_t>(4 * i + 3)) / 65535.0;
    flat.rectangle(i, 0, i + 1, 4, 0, flat.unlit(linear, linear, linear));
  }
  const scenes::Scene scene = flat.scene();
  for (const char* lights : {"none", "rig:4"}) {
    FrameOptions options = flat.options();
    options.lights = lights;
    options.ambient_value = 0.5;
    const Frame frame = render_frame(scene, options);
    for (int i = 0; i < 64; ++i)
      EXPECT_EQ(pixel(frame, i, 2), (Color{4 * i + 3, 4 * i + 3, 4 * i + 3})) << lights;
  }
}

TEST(GltfPicture, BlendedSurfacesAreLaidFromFarToNear) {
  // Given near to far in the file; an opaque one hides the fourth.
  FlatScene flat(64, 64);
  const json blend = {{"alphaMode", "BLEND"}};
  const int red = flat.unlit(1, 0, 0, 0.5, blend), green = flat.unlit(0, 1, 0, 0.5, blend),
            blue = flat.unlit(0, 0, 1, 0.5, blend);
  flat.rectangle(20, 0, 64, 64, 30, red);
  flat.rectangle(10, 0, 64, 64, 20, green);
  flat.rectangle(0, 0, 64, 64, 10, blue);
  flat.rectangle(0, 0, 64, 64, 1, red);
  flat.rectangle(0, 0, 64, 32, 5, flat.unlit(1, 1, 1));
  for (const int msaa : {1, 4}) {
    const Frame frame = flat.render(msaa);
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x) {
        Color expected;
        for (int c = 0; c < 3; ++c) {
          const auto over = [](double below, double color) {
            return static_cast<double>(static_cast<float>(color * 0.5 + below * 0.5));
          };
          double v = y < 32 ? 1 : over(static_cast<float>(background(c)), c == 0);
          v = over(v, c == 2);
          if (x >= 10) v = over(v, c == 1);
          if (x >= 20) v = over(v, c == 0);
          expected[static_cast<std::size_t>(c)] = code(v);
        }
        ASSERT_EQ(pixel(frame, x, y), expected) << x << "," << y << " at " << msaa << "x";
      }
  }
}

TEST(GltfPicture, NearestTexelsAreReproducedByteForByte) {
  for (const auto& [width, height] : {std::pair{64, 64}, {61, 37}, {128, 3}, {1, 90}}) {
    host::Image8 image{width, height, 3, {}};
    std::mt19937 random(7);
    for (int i = 0; i < width * height * 3; ++i)
      image.texels.push_back(static_cast<std::uint8_t>(random() >> 24));
    FlatScene flat(width + 9, height + 5);
    flat.rectangle(4, 3, 4 + width, 3 + height, 0, flat.unlit_image(image));
    for (const int msaa : {1, 4}) {
      const Frame frame = flat.render(msaa);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const std::uint8_t* texel = &image.texels[static_cast<std::size_t>(y * width + x) * 3];
          ASSERT_EQ(pixel(frame, x + 4, y + 3), (Color{texel[0], texel[1], texel[2]}))
              << width << "x" << height << " texel " << x << "," << y << " at " << msaa << "x";
        }
    }
  }
}

TEST(FourSamples, MixInLinearLightByTheirNumber) {
  // Columns of a white rectangle that end at every sixteenth of a pixel: samples lie at 2, 6, 10 and 14.
  FlatScene flat(16, 17);
  const int white = flat.unlit(1, 1, 1);
  for (int i = 0; i <= 16; ++i) flat.rectangle(0, i, 3 + i / 16.0, i + 1, 0, white);
  const Frame frame = flat.render(4);
  for (int i = 0; i <= 16; ++i) {
    const int covered = (i > 2) + (i > 6) + (i > 10) + (i > 14);
    Color expected = kBackground;
    for (int c = 0; c < 3 && covered > 0; ++c)
      expected[static_cast<std::size_t>(c)] =
          code((covered + (4 - covered) * double{static_cast<float>(background(c))}) / 4);
    EXPECT_EQ(pixel(frame, 3, i), expected) << i;
    EXPECT_EQ(pixel(frame, 2, i), (Color{255, 255, 255}));
    EXPECT_EQ(pixel(frame, 4, i), kBackground);
  }
}

TEST(FourSamples, AreBilledAsTheConsoleKeepsThem) {
  FlatScene flat(1280, 720);
  flat.rectangle(100, 100, 500, 300, 0, flat.unlit(1, 1, 1));
  const console::GpuModel xenos = console::load_platform("xenos"), rsx = console::load_platform("rsx");
  const Frame one = flat.render(1), four = flat.render(4);
  const auto work_one = report::pass_work(one, xenos), work_four = report::pass_work(four, xenos);
  // 7.03 and 28.1 MB of colour and depth in 10 MB [XEN-X]: geometry is sent once, then three times.
  EXPECT_EQ(work_one.front().tiling_passes, 1);
  EXPECT_EQ(work_four.front().tiling_passes, 3);
  EXPECT_EQ(work_four.front().rop.front().samples, 4);
  // Shaded once a pixel and triangle: only the diagonal both triangles share is shaded twice.
  EXPECT_GT(four.passes.front().pixels, one.passes.front().pixels);
  EXPECT_LT(four.passes.front().pixels, one.passes.front().pixels + 1000);
  EXPECT_EQ(one.passes.front().pixels, 400u * 200u);
  EXPECT_GT(report::pass_work(four, rsx).front().total_bytes(),
            3 * report::pass_work(one, rsx).front().total_bytes());
}

TEST(FourSamples, InspectionOfAPixelShowsTheResolvedColour) {
  FlatScene flat(48, 32);
  flat.rectangle(3.3, 2.2, 30.7, 20.1, 0, flat.unlit(0.5, 0.25, 1));
  flat.rectangle(20.4, 10.6, 45.2, 30.9, 1, flat.unlit(1, 0.5, 0.125, 0.5, {{"alphaMode", "BLEND"}}));
  const scenes::Scene scene = flat.scene();
  FrameOptions options = flat.options();
  options.msaa = 4;
  const Frame frame = render_frame(scene, options);
  int partly = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 48; ++x) {
      const std::size_t at = static_cast<std::size_t>(y * 48 + x);
      if (!frame.covered[at] || (x + 5 * y) % 11 != 0) continue;
      const PixelReport report = inspect_pixel(scene, options, x, y);
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(report.linear[c], frame.linear[at * 4 + c], 1e-6)
            << x << "," << y;  // the frame keeps binary32
      EXPECT_EQ(report.alu_words, frame.cost.alu_words[at]) << x << "," << y;
      EXPECT_EQ(report.depth_d24, frame.depth_d24[at]) << x << "," << y;
      partly += frame.linear[at * 4 + 2] != 1.0f;
    }
  EXPECT_GT(partly, 10);
}

TEST(MeshBounds, DrawsOutsideTheViewAreNotShadedAndStillBilled) {
  FlatScene flat(64, 64);
  flat.rectangle(0, 0, 40, 40, 0, flat.unlit(1, 0, 0));
  flat.rectangle(100, 0, 140, 40, 0, flat.unlit(0, 1, 0));                                 // right of it
  flat.rectangle(0, -90, 40, -70, 0, flat.unlit(0, 0, 1, 0.5, {{"alphaMode", "BLEND"}}));  // above it
  flat.rectangle(0, 0, 40, 40, 200, flat.unlit(0, 1, 1));                                  // behind the eye
  flat.rectangle(60, 0, 140, 40, 0, flat.unlit(1, 1, 0));  // across the border
  const scenes::Scene scene = flat.scene();
  FrameOptions options = flat.options();
  const Frame on = render_frame(scene, options);
  set_option(options, "no-skip", "mesh_bounds");
  const Frame off = render_frame(scene, options);
  EXPECT_EQ(on.skipped.at("mesh_bounds"), 6u);
  EXPECT_EQ(off.skipped.at("mesh_bounds"), 0u);
  EXPECT_EQ(on.rgba8, off.rgba8);
  EXPECT_EQ(on.passes.front().vertices, 20u);
  EXPECT_EQ(on.passes.front().vertices, off.passes.front().vertices);
  EXPECT_EQ(on.passes.front().vertex_words, off.passes.front().vertex_words);
  EXPECT_EQ(on.passes.front().triangles, off.passes.front().triangles);
  EXPECT_EQ(on.passes.front().bytes, off.passes.front().bytes);
  EXPECT_EQ(on.passes.front().alu_words, off.passes.front().alu_words);
}

}  // namespace
}  // namespace aluminate::passes
