// Shadow maps and filtered gloss in the frame: what they darken, what they leave alone, what they cost.
#include <gtest/gtest.h>

#include "scenes/scene.hpp"
#include "shading/filter/gloss_bake.hpp"
#include "shading/passes/prepared.hpp"
#include "tests/passes/sample_scene.hpp"

namespace aluminate::passes {
namespace {

FrameOptions options_for(const std::string& assignments) {
  FrameOptions options;
  options.width = 160;
  options.height = 90;
  set_options(options, assignments);
  return options;
}

// A floor, and a square above its middle under a light straight from above.
scenes::Scene square_over_floor(scenes::LightKind kind) {
  scenes::Scene scene;
  scene.file = "square over floor";
  scenes::Material material;
  material.metallic = 0;
  material.double_sided = true;
  scene.materials.push_back(material);
  for (const auto& [half, height] : {std::pair{4.0, 0.0}, {1.0, 2.0}}) {
    scenes::Mesh mesh;
    mesh.name = height > 0 ? "square" : "floor";
    for (const auto& [sx, sz] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      mesh.positions.emplace_back(half * sx, height, half * sz);
      mesh.normals.emplace_back(0, 1, 0);
      mesh.tangents.emplace_back(1, 0, 0, 1);
    }
    mesh.indices = {0, 2, 1, 0, 3, 2};
    scene.meshes.push_back(std::move(mesh));
  }
  scenes::Light light{
      .name = "lamp", .kind = kind, .intensity = kind == scenes::LightKind::Spot ? 60.0 : 3.0};
  light.position = {0, 6, 0};
  light.direction = {0, -1, 0};
  light.outer_cone = 0.9;
  light.range = 20;
  scene.lights.push_back(light);
  scene.bounds_min = {-4, 0, -4};
  scene.bounds_max = {4, 2, 4};
  return scene;
}

TEST(Shadows, TheSquareDarkensTheFloorBelowItAndNothingElse) {
  for (const auto kind : {scenes::LightKind::Directional, scenes::LightKind::Spot})
    for (const char* pipeline : {"forward", "deferred"}) {
      const scenes::Scene scene = square_over_floor(kind);
      // From the side below the square: the floor is seen, the square only from beneath.
      const std::string view =
          "camera=0,1.5,7:0,0,0:60,ambient=none,lights=scene,pipeline=" + std::string(pipeline);
      const Frame open = render_frame(scene, options_for(view));
      const Frame dark = render_frame(scene, options_for(view + ",shadows=on"));
      std::uint64_t darkened = 0, same = 0, partly = 0;
      for (std::size_t i = 0; i < open.pixel_count(); ++i) {
        if (!open.covered[i] || open.linear[4 * i] == 0) continue;
        if (dark.linear[4 * i] == 0)
          ++darkened;
        else if (dark.linear[4 * i] == open.linear[4 * i])
          ++same;
        else
          ++partly;
      }
      EXPECT_GT(darkened, 100u) << pipeline;
      EXPECT_GT(same, 1000u) << pipeline;
      EXPECT_EQ(partly, 0u) << pipeline;
      EXPECT_EQ(dark.passes.front().name, "shadow");
      EXPECT_EQ(dark.passes.front().triangles, 4u);
    }
}

TEST(Shadows, CastersThatCannotMatterAreSkippedAndChangeNothing) {
  scenes::Scene scene = square_over_floor(scenes::LightKind::Directional);
  scenes::Mesh far = scene.meshes[1];
  for (glm::dvec3& p : far.positions) p += glm::dvec3(3, 0, 3);
  scene.meshes.push_back(far);
  for (const char* pipeline : {"forward", "deferred"}) {
    // Looks at the far left corner of the floor.
    const std::string view =
        "camera=-3,1.5,-1:-3.5,0,-3.5:50,shadows=on,lights=scene,pipeline=" + std::string(pipeline);
    const Frame skipped = render_frame(scene, options_for(view));
    const Frame all = render_frame(scene, options_for(view + ",no-skip=all"));
    EXPECT_GE(skipped.skipped.at("shadow_casters"), 1u);
    EXPECT_EQ(all.skipped.at("shadow_casters"), 0u);
    EXPECT_EQ(skipped.linear, all.linear);
    ASSERT_EQ(skipped.passes.size(), all.passes.size());
    for (std::size_t i = 0; i < all.passes.size(); ++i) {
      EXPECT_EQ(skipped.passes[i].rop_depth_only, all.passes[i].rop_depth_only);
      EXPECT_EQ(skipped.passes[i].vertices, all.passes[i].vertices);
      EXPECT_EQ(skipped.passes[i].alu_words, all.passes[i].alu_words);
    }
  }
}

TEST(Shadows, OffIsTheDefaultAndTouchesNothing) {
  const scenes::Scene& scene = test::sample_scene("beach_hut");
  EXPECT_EQ(render_frame(scene, options_for("shadows=off")).linear,
            render_frame(scene, options_for("")).linear);
  EXPECT_NE(render_frame(scene, options_for("shadows=on")).linear,
            render_frame(scene, options_for("")).linear);
}

TEST(Toksvig, EveryModeDullsBumpsAndLeavesFlatSurfacesAlone) {
  const scenes::Scene& scene = test::sample_scene("grazing_floor");
  const Frame off = render_frame(scene, options_for("toksvig=off"));
  const auto brightest = [](const Frame& f) {
    double sum = 0;
    for (std::size_t i = 0; i < f.pixel_count(); ++i)
      if (f.covered[i]) sum += f.linear[4 * i + 1] * static_cast<double>(f.linear[4 * i + 1]);
    return sum;
  };
  for (const char* mode : {"texture", "dxt5", "material"}) {
    const Frame on = render_frame(scene, options_for("toksvig=" + std::string(mode)));
    EXPECT_NE(on.linear, off.linear) << mode;
    EXPECT_LT(brightest(on), 1.05 * brightest(off)) << mode;
  }
  // No normal map: no filter.
  EXPECT_EQ(render_frame(test::sample_scene("overdraw_stress"), options_for("toksvig=texture")).linear,
            render_frame(test::sample_scene("overdraw_stress"), options_for("toksvig=off")).linear);
}

TEST(Toksvig, TheTextureHoldsTheFactorOfEveryMip) {
  const scenes::Scene& scene = test::sample_scene("grazing_floor");
  const ToksvigSet set(scene, ToksvigMode::Texture);
  const ToksvigSet one(scene, ToksvigMode::Material);
  int with_map = 0;
  for (const scenes::Material& material : scene.materials) {
    const vm::Texture* texture = set.texture(material);
    EXPECT_EQ(texture != nullptr, material.normal_map.present() && !material.unlit);
    if (!texture) continue;
    ++with_map;
    EXPECT_EQ(texture->levels().back().width, 1);
    EXPECT_EQ(texture->linear16(0, 0, 0), 65535);  // one texel is no spread
    EXPECT_LT(texture->linear16(texture->levels().size() - 1, 0, 0), 65535);
    EXPECT_GT(one.factor(material), 0.0);
    EXPECT_LT(one.factor(material), 1.0);
  }
  EXPECT_GT(with_map, 0);
}

}  // namespace
}  // namespace aluminate::passes
