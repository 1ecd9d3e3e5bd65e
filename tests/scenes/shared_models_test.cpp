// The public models, when they are beside the tree: triangle counts as their source list states them.
#include "scenes/loader.hpp"
#include "scenes/scene_info.hpp"

#include <gtest/gtest.h>

#include <filesystem>

namespace aluminate::scenes {
namespace {

struct SharedModel {
  const char* file;
  std::uint64_t triangles;
  std::size_t warnings;
};

class SharedModels : public testing::TestWithParam<SharedModel> {};

TEST_P(SharedModels, LoadWithTheirStatedTriangleCount) {
  const auto path = std::filesystem::path(ALUMINATE_SHARED_DIR) / "scenes" / GetParam().file;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  const Scene scene = load_scene(path);
  const SceneInfo info = scene_info(scene);
  EXPECT_EQ(info.triangles, GetParam().triangles);
  EXPECT_EQ(scene.warnings.size(), GetParam().warnings) << scene_info_text(info);
  for (const Mesh& mesh : scene.meshes) {
    ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
    ASSERT_EQ(mesh.tangents.size(), mesh.positions.size());
    for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
      const glm::vec3 n = mesh.normals[i], t(mesh.tangents[i]);
      // Unit to the rounding of three floats; orthogonal to the rounding of the dot product of two of them.
      ASSERT_NEAR(glm::dot(n, n), 1.0f, 4e-7f);
      ASSERT_NEAR(glm::dot(t, t), 1.0f, 4e-7f);
      ASSERT_NEAR(glm::dot(n, t), 0.0f, 4e-7f);
      ASSERT_EQ(mesh.tangents[i].w * mesh.tangents[i].w, 1.0f);
    }
    for (const std::uint32_t index : mesh.indices) ASSERT_LT(index, mesh.positions.size());
  }
}

INSTANTIATE_TEST_SUITE_P(
    Public, SharedModels,
    testing::Values(SharedModel{"flight_helmet.glb", 94722, 0}, SharedModel{"pbr_spheres.glb", 100320, 0},
                    SharedModel{"hotel_room.glb", 99029, 1}, SharedModel{"carbon_sphere.glb", 215579, 0},
                    SharedModel{"exploding_barrel.glb", 8150, 0}, SharedModel{"atrium.glb", 342272, 1}),
    [](const auto& spec) {
      const std::string file = spec.param.file;
      return file.substr(0, file.find('.'));
    });

}  // namespace
}  // namespace aluminate::scenes
