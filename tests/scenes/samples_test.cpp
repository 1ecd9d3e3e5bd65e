// The sample scenes: what is committed is what the generator writes, and it loads without a warning.
#include "platform/host/image_file.hpp"
#include "platform/host/input_file.hpp"
#include "scenes/catalogue.hpp"
#include "scenes/generator/sample_models.hpp"
#include "scenes/light_rig.hpp"
#include "scenes/loader.hpp"
#include "scenes/scene_info.hpp"
#include "scenes/view.hpp"
#include "tests/scenes/gltf_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace aluminate::scenes::test {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;

const fs::path kSource = ALUMINATE_SOURCE_DIR;

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

TEST(Samples, CommittedFilesAreWhatTheGeneratorWrites) {
  const TempFolder folder;
  generator::write_samples(folder.path());
  const fs::path committed = kSource / "scenes" / "samples";
  EXPECT_EQ(names_in(committed), names_in(folder.path())) << "run aluminate_scenes_make scenes/samples";
  std::uintmax_t total = 0;
  for (const std::string& name : names_in(folder.path())) {
    const std::string old_file = (committed / name).string(), new_file = (folder.path() / name).string();
    total += fs::file_size(new_file);
    if (name.ends_with(".png")) {
      // Texels, not bytes: another zlib may pack them differently.
      const host::Image8 a = host::read_image_rgba8(old_file), b = host::read_image_rgba8(new_file);
      EXPECT_TRUE(a.width == b.width && a.height == b.height && a.texels == b.texels) << name;
    } else {
      EXPECT_EQ(host::read_bytes(old_file), host::read_bytes(new_file)) << name;
    }
  }
  EXPECT_LT(total, 1'500'000u) << "the repository carries these files";
}

TEST(Samples, GeneratingTwiceGivesTheSameBytes) {
  const TempFolder a, b;
  generator::write_samples(a.path());
  generator::write_samples(b.path());
  for (const std::string& name : names_in(a.path()))
    EXPECT_EQ(host::read_bytes((a.path() / name).string()), host::read_bytes((b.path() / name).string()))
        << name;
}

TEST(Samples, EveryCatalogueEntryLoadsCleanWithACameraAndLights) {
  std::set<std::string_view> names;
  for (const SampleScene& sample : sample_scenes()) {
    names.insert(sample.name);
    const Scene scene = load_scene(kSource / sample.file);
    EXPECT_THAT(scene.warnings, IsEmpty()) << sample.name;
    ASSERT_FALSE(scene.cameras.empty()) << sample.name;
    const NormalisedSpace space = normalised_space(scene);
    const View view = make_view(scene, space, {}, 16.0 / 9);
    EXPECT_THAT(make_lights(scene, space, view, {}).warnings, IsEmpty()) << sample.name;
    for (const EncodedImage& image : scene.images) {
      const host::Image8 decoded = host::decode_rgba8(image.bytes, image.name);
      EXPECT_TRUE(decoded.width >= 64 && decoded.width <= 256) << image.name;
    }
  }
  EXPECT_EQ(names.size(), 5u);
}

TEST(Samples, MaterialWallCoversGlossAndReflectance) {
  const Scene scene = load_scene(kSource / "scenes/samples/material_wall.gltf");
  const SceneInfo info = scene_info(scene);
  EXPECT_GT(info.triangles, 20000u);
  EXPECT_LT(info.triangles, 40000u);
  double low = 1, high = 0;
  int metals = 0, dielectrics = 0;
  for (const Material& m : scene.materials) {
    low = std::min(low, m.roughness);
    high = std::max(high, m.roughness);
    (m.metallic == 1 ? metals : dielectrics) += 1;
  }
  // m = 2^13 and m = 1: roughness^4 = 2 / (m + 2).
  EXPECT_NEAR(2 / (low * low * low * low) - 2, 8192, 1e-8);
  EXPECT_NEAR(2 / (high * high * high * high) - 2, 1, 1e-12);
  EXPECT_EQ(metals, 16);
  EXPECT_GE(dielectrics, 16);
  EXPECT_EQ(scene.lights.size(), 4u);
}

TEST(Samples, BeachHutHasEveryAlphaModeAndBothCameras) {
  const Scene scene = load_scene(kSource / "scenes/samples/beach_hut.gltf");
  std::set<AlphaMode> modes;
  for (const Mesh& mesh : scene.meshes)
    modes.insert(scene.materials[static_cast<std::size_t>(mesh.material)].alpha_mode);
  EXPECT_EQ(modes.size(), 3u);
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(scene.cameras[0].name, "outside");
  EXPECT_EQ(scene.cameras[1].name, "inside");
  EXPECT_EQ(scene.lights.size(), 4u);
}

TEST(Samples, OverdrawStressJumpsBackAndForthInDepth) {
  const Scene scene = load_scene(kSource / "scenes/samples/overdraw_stress.gltf");
  int nearer = 0, farther = 0;
  for (std::size_t i = 1; i < scene.meshes.size(); ++i) {
    const double step = scene.meshes[i].positions[0].z - scene.meshes[i - 1].positions[0].z;
    (step > 0 ? nearer : farther) += 1;
  }
  EXPECT_GT(nearer, 8);
  EXPECT_GT(farther, 8);
}

}  // namespace
}  // namespace aluminate::scenes::test
