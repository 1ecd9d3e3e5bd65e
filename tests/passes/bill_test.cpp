#include <gtest/gtest.h>

#include <numeric>

#include "platform/console/platform_file.hpp"
#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"
#include "scenes/catalogue.hpp"
#include "scenes/loader.hpp"
#include "shading/passes/frame.hpp"
#include "shading/passes/inspect.hpp"
#include "shading/passes/renderer.hpp"
#include "tests/passes/sample_scene.hpp"

namespace aluminate::passes {
namespace {

FrameOptions small(int width, int height) {
  FrameOptions options;
  options.width = width;
  options.height = height;
  return options;
}

std::uint64_t sum(const std::vector<std::uint32_t>& plane) {
  return std::accumulate(plane.begin(), plane.end(), std::uint64_t{0});
}

// The bill adds up: over pixels = over passes, for every counter.
void expect_sums(const Frame& frame, const std::string& what) {
  PassTotals total;
  for (const PassTotals& pass : frame.passes) {
    total.pixels += pass.pixels;
    total.helper_lanes += pass.helper_lanes;
    total.quads += pass.quads;
    total.alu_words += pass.alu_words;
    total.alu_slots += pass.alu_slots;
    total.fetches += pass.fetches;
    total.fetch_cyc += pass.fetch_cyc;
  }
  EXPECT_GT(total.pixels, 0u) << what << ": nothing was drawn";
  EXPECT_EQ(sum(frame.cost.overdraw), total.pixels) << what;
  EXPECT_EQ(sum(frame.cost.helpers), total.helper_lanes) << what;
  EXPECT_EQ(total.quads * 4, total.pixels + total.helper_lanes) << what;
  EXPECT_EQ(sum(frame.cost.alu_words), total.alu_words) << what;
  EXPECT_EQ(sum(frame.cost.alu_slots), total.alu_slots) << what;
  EXPECT_EQ(sum(frame.cost.fetches), total.fetches) << what;
  EXPECT_EQ(sum(frame.cost.fetch_cyc), total.fetch_cyc) << what;
}

TEST(Bill, PixelsSumToPassesOnEverySceneAndPlatform) {
  int frames = 0, refused = 0;
  for (const scenes::SampleScene& sample : scenes::sample_scenes())
    for (const console::PlatformEntry& platform : console::builtin_platforms())
      for (const char* settings :
           {"", "pipeline=deferred", "msaa=4,tonemap=filmic", "pipeline=deferred,lights=lamps:6,tonemap=filmic"}) {
        FrameOptions options = small(57, 43);  // odd: helper lanes beyond the picture are charged too
        options.platform = platform.id;
        if (*settings != '\0') set_options(options, settings);
        const std::string name(sample.name), what = name + " on " + options.platform + " with '" + settings + "'";
        try {
          expect_sums(render_frame(test::sample_scene(name), options), what);
          ++frames;
        } catch (const UserError& error) {  // six registers a thread do not hold a lit surface
          EXPECT_EQ(options.platform, "mali-400") << what << ": " << error.what();
          EXPECT_NE(std::string(error.what()).find("registers"), std::string::npos) << error.what();
          ++refused;
        }
      }
  EXPECT_GE(frames, 5 * 6 * 4);
  EXPECT_GE(refused, 1);
}

TEST(Bill, ShadersThatBranchOnDataAreBilledAsExecuted) {
  const std::string path = testing::TempDir() + "branchy.hlsl";
  FILE* file = fopen(path.c_str(), "w");
  ASSERT_NE(file, nullptr);
  fputs(
      "float4 main(float3 p : TEXCOORD0, float3 n : TEXCOORD1) : COLOR0 {\n"
      "  float3 c = n * 0.5 + 0.5;\n"
      "  [branch] if (p.x > 0) { float k = p.y; for (int i = 0; i < 3; ++i) k = exp2(sin(k)); c *= k; }\n"
      "  return float4(c, 1);\n}\n",
      file);
  fclose(file);
  FrameOptions options = small(96, 54);
  options.shader = path;
  const Frame frame = render_frame(test::sample_scene("material_wall"), options);
  expect_sums(frame, "branchy shader");
  // Lanes pay differently on the two sides of the branch, and a pixel's inspection agrees with its layers.
  std::uint32_t least = ~0u, most = 0;
  for (std::size_t i = 0; i < frame.pixel_count(); ++i) {
    const std::uint32_t lanes = frame.cost.overdraw[i] + frame.cost.helpers[i];
    if (lanes == 0) continue;
    least = std::min(least, frame.cost.alu_words[i] / lanes);
    most = std::max(most, frame.cost.alu_words[i] / lanes);
  }
  EXPECT_LT(least, most);
  for (int x = 2; x < 96; x += 9) {
    const PixelReport pixel = inspect_pixel(test::sample_scene("material_wall"), options, x, 27);
    EXPECT_EQ(pixel.alu_words, frame.cost.alu_words[27 * 96 + static_cast<std::size_t>(x)]) << x;
  }
}

void expect_nothing_changes(FrameOptions options, const std::string& what) {
  SCOPED_TRACE(what);
  const scenes::Scene& scene = test::sample_scene("beach_hut");
  const int threads = host::thread_count();
  host::set_thread_count(1);
  const Frame one = render_frame(scene, options);
  for (const int count : {3, 16, 64}) {
    host::set_thread_count(count);
    if (count == 16) set_option(options, "no-skip", "all");
    const Frame many = render_frame(scene, options);
    EXPECT_EQ(many.rgba8, one.rgba8) << count;
    EXPECT_EQ(many.linear, one.linear) << count;
    EXPECT_EQ(many.depth_d24, one.depth_d24) << count;
    EXPECT_EQ(many.cost.alu_words, one.cost.alu_words) << count;
    EXPECT_EQ(many.cost.overdraw, one.cost.overdraw) << count;
    EXPECT_EQ(many.cost.helpers, one.cost.helpers) << count;
    EXPECT_EQ(many.cost.path, one.cost.path) << count;
  }
  host::set_thread_count(threads);
}

// Nothing of a frame survives into the next one: neither counts nor what its recycled memory held.
TEST(Bill, EveryFrameOfARendererIsTheSame) {
  for (const char* settings : {"", "msaa=4,tonemap=filmic", "pipeline=deferred,shadows=on"}) {
    SCOPED_TRACE(settings);
    FrameOptions options = small(131, 70);
    set_options(options, settings);
    const scenes::Scene& scene = test::sample_scene("beach_hut");
    const Frame once = render_frame(scene, options);
    Renderer renderer(scene, options);
    Frame frame = renderer.draw();
    for (int again = 0; again < 2; ++again) {
      std::fill(frame.linear.begin(), frame.linear.end(), 7.0f);
      std::fill(frame.rgba8.begin(), frame.rgba8.end(), std::uint8_t{7});
      std::fill(frame.cost.alu_words.begin(), frame.cost.alu_words.end(), 7u);
      frame = renderer.draw(std::move(frame));
      EXPECT_EQ(frame.rgba8, once.rgba8);
      EXPECT_EQ(frame.linear, once.linear);
      EXPECT_EQ(frame.covered, once.covered);
      EXPECT_EQ(frame.depth_d24, once.depth_d24);
      EXPECT_EQ(frame.cost.alu_words, once.cost.alu_words);
      EXPECT_EQ(frame.cost.path, once.cost.path);
      EXPECT_EQ(frame.saturations, once.saturations);
      EXPECT_EQ(frame.skipped, once.skipped);
      ASSERT_EQ(frame.passes.size(), once.passes.size());
      for (std::size_t p = 0; p < frame.passes.size(); ++p) {
        EXPECT_EQ(frame.passes[p].alu_words, once.passes[p].alu_words);
        EXPECT_EQ(frame.passes[p].vertex_words, once.passes[p].vertex_words);
      }
    }
  }
}

TEST(Bill, ThreadsAndSkipsChangeNothing) {
  FrameOptions options = small(131, 70);
  expect_nothing_changes(options, "forward");
  options.msaa = 4;
  expect_nothing_changes(options, "forward, four samples");
  options.msaa = 1;
  options.pipeline = Pipeline::Deferred;
  for (const char* number : {"fx31", "q16.16"}) {
    options.number = number;
    expect_nothing_changes(options, std::string("deferred ") + number);
  }
}

void expect_inspection_agrees(const char* name, const FrameOptions& options, int step) {
  const scenes::Scene& scene = test::sample_scene(name);
  const Frame frame = render_frame(scene, options);
  std::uint32_t rejected = 0;
  for (int y = 3; y < 54; y += 10 * step)
    for (int x = 5; x < 96; x += 13 * step) {
      const PixelReport pixel = inspect_pixel(scene, options, x, y);
      const std::size_t at = static_cast<std::size_t>(y) * 96 + static_cast<std::size_t>(x);
      EXPECT_EQ(pixel.alu_words, frame.cost.alu_words[at]) << x << "," << y;
      EXPECT_EQ(pixel.fetches, frame.cost.fetches[at]) << x << "," << y;
      EXPECT_EQ(pixel.depth_d24, frame.depth_d24[at]) << x << "," << y;
      std::uint32_t shaded = 0, early = 0, helpers = 0;
      for (const PixelVisit& visit : pixel.visits) {
        helpers += visit.outcome == "helper lane";
        early += visit.outcome == "z-failed early";
        if (visit.outcome != "helper lane" && visit.outcome != "z-failed early") ++shaded;
        if (visit.outcome == "z-failed early") {
          EXPECT_EQ(visit.alu_words + visit.alu_slots + visit.fetches + visit.fetch_cyc, 0u);
        }
      }
      EXPECT_EQ(shaded, frame.cost.overdraw[at]) << x << "," << y;
      EXPECT_EQ(helpers, frame.cost.helpers[at]) << x << "," << y;
      rejected += early;
      if (!frame.covered[at]) continue;
      for (std::size_t c = 0; c < 3; ++c)  // the frame is stored in binary32, blended sums too
        EXPECT_NEAR(pixel.linear[c], frame.linear[4 * at + c], 1e-6 * (1 + pixel.linear[c])) << x << "," << y;
    }
  EXPECT_GT(rejected, 0u) << "no fragment was turned away: the scene says nothing about those";
}

TEST(Bill, InspectionOfAPixelAgreesWithTheLayers) {
  FrameOptions options = small(96, 54);
  expect_inspection_agrees("overdraw_stress", options, 2);
  options.pipeline = Pipeline::Deferred;
  expect_inspection_agrees("overdraw_stress", options, 2);
  options.platform = "rsx";
  expect_inspection_agrees("beach_hut", options, 2);
}

TEST(Bill, PublicModelsAddUp) {
  const std::string helmet = test::public_model("flight_helmet.glb");
  if (helmet.empty()) GTEST_SKIP() << "public models are not here";
  expect_sums(render_frame(scenes::load_scene(helmet), small(320, 180)), "flight_helmet");
}

}  // namespace
}  // namespace aluminate::passes
