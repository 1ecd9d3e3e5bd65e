// What shading must survive: gloss 0 and 1, grazing views, degenerate tangents, normals of no length, a light
// on the surface, the sun on the horizon, black and over-bright albedo, reflections of the darkest and the
// brightest. Every pixel finite, not negative, in range, in both pipelines and every kind of number format.
#include <gtest/gtest.h>

#include <cmath>

#include "platform/host/image_file.hpp"
#include "scenes/scene.hpp"
#include "shading/passes/cube_map.hpp"
#include "shading/passes/frame.hpp"
#include "tests/passes/cube_map_file.hpp"

namespace aluminate::passes {
namespace {

struct Patch {
  double gloss, albedo;
  glm::vec3 normal;
  glm::vec4 tangent;
  float vertex_color;
};

// A row of squares in the plane y = 0, seen along it, each with its own affliction.
scenes::Scene afflicted() {
  const glm::vec3 up(0, 1, 0), none(0), down(0, -1, 0), along(1, 0, 0);
  const glm::vec4 straight(1, 0, 0, 1), parallel(0, 1, 0, -1), zero(0, 0, 0, 1);
  const Patch patches[] = {
      {0, 0.5, up, straight, 1},     {1, 0.5, up, straight, 1},    {1, 0, up, straight, 1},
      {0, 1, up, straight, 8},       {1, 1, up, straight, 8},      {1, 0.5, none, straight, 1},
      {0, 0.5, none, zero, 1},       {1, 0.5, up, parallel, 1},    {1, 0.5, up, zero, 1},
      {0.5, 0.5, down, straight, 1}, {1, 0.5, along, straight, 1}, {1, 0.5, along, parallel, 8}};
  scenes::Scene scene;
  scene.file = "afflicted";
  host::Image8 bumps{2, 2, 4, {128, 128, 255, 255, 0, 128, 128, 255, 0, 0, 0, 255, 255, 255, 128, 255}};
  scene.images.push_back({"bumps", host::encode_png(bumps)});
  const float count = static_cast<float>(std::size(patches));
  float x = -count / 2;
  for (const Patch& patch : patches) {
    scenes::Material material;
    material.workflow = scenes::Workflow::SpecularGlossiness;
    material.base_color = glm::dvec4(glm::dvec3(patch.albedo), 1);
    material.specular = glm::dvec3(patch.albedo);
    material.glossiness = patch.gloss;
    material.normal_map.image = 0;
    scene.materials.push_back(material);
    scenes::Mesh mesh;
    mesh.name = "patch";
    mesh.material = static_cast<int>(scene.materials.size()) - 1;
    for (const auto& [dx, dz] : {std::pair{0.f, 0.f}, {1.f, 0.f}, {1.f, 1.f}, {0.f, 1.f}}) {
      mesh.positions.emplace_back(x + dx, 0, dz * 4 - 2);
      mesh.normals.push_back(patch.normal);
      mesh.tangents.push_back(patch.tangent);
      mesh.uv0.emplace_back(dx * 8, dz * 8);
      mesh.colors.emplace_back(patch.vertex_color, patch.vertex_color, patch.vertex_color, 1);
    }
    mesh.indices = {0, 2, 1, 0, 3, 2};
    scene.meshes.push_back(std::move(mesh));
    x += 1;
  }
  scene.bounds_min = {-count / 2, -1, -2};
  scene.bounds_max = {count / 2, 1, 2};
  // One light exactly on the surface, one just under it, one along it, one spot from above.
  scenes::Light on{.name = "on", .kind = scenes::LightKind::Point, .intensity = 30, .range = 4};
  on.position = {0.5, 0, 0};
  scenes::Light under = on;
  under.position = {2.5, -1e-3, 0.5};
  scenes::Light along_light{.name = "along", .kind = scenes::LightKind::Directional, .intensity = 3};
  along_light.direction = {-1, 0, 0};
  scenes::Light spot{.name = "spot", .kind = scenes::LightKind::Spot, .intensity = 30, .range = 6};
  spot.position = {-2, 2, 0};
  spot.direction = {0, -1, 0};
  scene.lights = {on, under, along_light, spot};
  return scene;
}

void expect_sound(const scenes::Scene& scene, const std::string& assignments, const std::string& reflections = "") {
  FrameOptions options;
  options.reflections = reflections;
  options.width = 96;
  options.height = 48;
  set_options(options, "lights=scene," + assignments);
  const Frame frame = render_frame(scene, options);
  std::uint64_t drawn = 0, bad = 0;
  for (std::size_t i = 0; i < frame.pixel_count(); ++i) {
    drawn += frame.covered[i];
    for (std::size_t c = 0; c < 3; ++c) {
      const float v = frame.linear[4 * i + c];
      bad += !(std::isfinite(v) && v >= 0.0f && v < 0x1p21f);
    }
  }
  EXPECT_EQ(bad, 0u) << assignments;
  EXPECT_GT(drawn, 50u) << assignments;  // a plane seen along itself is a few rows of pixels
}

TEST(Stability, EveryPixelIsFiniteAndInRange) {
  const scenes::Scene scene = afflicted();
  const std::string grazing = "camera=-9,0.4,0:0,0,0:50,", above = "camera=0,7,7:0,0,0:50,";
  for (const char* pipeline : {"pipeline=forward,", "pipeline=deferred,"})
    for (const char* number : {"number=fx31", "number=q8.24", "number=ref64"}) {
      expect_sound(scene, grazing + pipeline + number);
      expect_sound(scene, above + pipeline + number + ",sky=fc3,sun=0,0,ambient=sky");
    }
  for (const char* pipeline : {"pipeline=forward,", "pipeline=deferred,"}) {
    for (const char* number : {"number=fx24", "number=q16.16", "number=q12.20"})
      expect_sound(scene, grazing + pipeline + number);
    for (const char* visibility : {"none", "integrated", "cheap"})
      expect_sound(scene, above + pipeline + "visibility=" + visibility);
    for (const char* toksvig : {"texture", "dxt5", "material"})
      expect_sound(scene, above + pipeline + "shadows=on,toksvig=" + toksvig);
  }
}

TEST(Stability, ReflectionsOfTheDarkestAndTheBrightestSurroundings) {
  // Black, the brightest light a capture keeps, and nothing but sky, in stripes: every level of the chain has steep edges.
  CubeMap map;
  map.seen = {16, std::vector<glm::dvec4>(6 * 16 * 16, glm::dvec4(0))};
  map.surface.assign(6 * 16 * 16, glm::dvec3(0));
  for (std::size_t i = 0; i < map.surface.size(); ++i) {
    if (i % 3 == 1) map.surface[i] = glm::dvec3(kGreatestCaptured, 0, kGreatestCaptured);
    map.seen.texels[i] = i % 3 == 2 ? glm::dvec4(kGreatestCaptured, 1, 0, 1) : glm::dvec4(map.surface[i], 0);
  }
  const test::CubeMapFile file(map);
  const scenes::Scene scene = afflicted();
  for (const char* camera : {"camera=-9,0.4,0:0,0,0:50,", "camera=0,7,7:0,0,0:50,"})
    for (const char* pipeline : {"pipeline=forward,", "pipeline=deferred,"})
      for (const char* number : {"number=fx31", "number=fx24", "number=q16.16", "number=q12.20", "number=q8.24", "number=ref64"})
        expect_sound(scene, std::string(camera) + pipeline + number + ",sky=fc3,sun=0,0,ambient=sky,toksvig=texture", file.path());
}

}  // namespace
}  // namespace aluminate::passes
