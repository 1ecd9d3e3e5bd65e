// A picture becomes a material's base colour, and nothing else of the file changes.
#include "scenes/base_color.hpp"

#include <gmock/gmock.h>

#include "platform/host/error.hpp"
#include "scenes/loader.hpp"
#include "tests/scenes/gltf_file.hpp"

namespace aluminate::scenes::test {
namespace {

using testing::HasSubstr;

// The first bytes of a PNG of 3 x 2; the rest is never looked at.
const Bytes kPicture{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0,  0, 0, 13, 'I', 'H', 'D', 'R',
                     0,    0,   0,   3,   0,    0,    0,    2,    16, 2, 0, 0,  0,   1,   2,   3};
const Bytes kOther{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 0, 0, 13, 'I', 'H', 'D',
                   'R',  0,   0,   0,   9,    0,    0,    0,    9, 8, 2, 0,  0,   0,   7};

GltfFile textured() {
  GltfFile file = GltfFile::triangle();
  file.attributes()["TEXCOORD_0"] = file.add_vec2({0, 0, 1, 0, 0, 1});
  file.primitive()["material"] = 0;
  return file;
}

std::string refusal(const std::filesystem::path& scene, const Bytes& image, const BaseColor& how) {
  try {
    with_base_color(scene, image, "wall.png", how);
  } catch (const UserError& error) {
    return std::string(error.what()) + " | " + error.hint();
  }
  return "fine";
}

const Bytes& picture_of(const Scene& scene, const TextureSlot& slot) {
  return scene.images.at(static_cast<std::size_t>(slot.image)).bytes;
}

TEST(BaseColor, ReplacesTheMapAndKeepsTheRest) {
  const TempFolder folder;
  GltfFile file = textured();
  file.root["samplers"] = {{{"wrapS", 33071}}};
  const int view = file.add_view(kOther);
  file.root["images"] = {{{"bufferView", view}, {"mimeType", "image/png"}}, {{"uri", "normal.png"}}};
  file.root["textures"] = {{{"source", 0}, {"sampler", 0}}, {{"source", 1}}};
  file.root["materials"] = {
      {{"name", "wall"},
       {"normalTexture", {{"index", 1}}},
       {"pbrMetallicRoughness",
        {{"baseColorTexture", {{"index", 0}}},
         {"baseColorFactor", {0.5, 0.25, 1, 0.75}},
         {"roughnessFactor", 0.3}}}},
      {{"name", "floor"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  folder.write("normal.png", kOther);
  const auto before_path = folder.write("scene.glb", file.glb());
  const Scene before = load_scene(before_path);
  const Scene after = load_scene(folder.write(
      "elsewhere/out.glb", with_base_color(before_path, kPicture, "wall.png", {"wall", std::nullopt})));

  const Material& wall = after.materials.at(0);
  EXPECT_EQ(picture_of(after, wall.base_color_map), kPicture);
  EXPECT_EQ(wall.base_color, glm::dvec4(1, 1, 1, 0.75));
  EXPECT_EQ(wall.metallic, 0.0);
  EXPECT_EQ(wall.roughness, 0.3);
  EXPECT_EQ(picture_of(after, wall.normal_map), kOther);
  EXPECT_EQ(wall.base_color_map.sampler, before.materials.at(0).base_color_map.sampler);
  EXPECT_EQ(after.meshes.at(0).positions, before.meshes.at(0).positions);
  EXPECT_EQ(after.meshes.at(0).uv0, before.meshes.at(0).uv0);
  EXPECT_EQ(after.warnings, before.warnings);
  EXPECT_EQ(
      load_scene(folder.write("rough.glb", with_base_color(before_path, kPicture, "wall.png", {"0", 0.9})))
          .materials.at(0)
          .roughness,
      0.9);
}

TEST(BaseColor, SpecularGlossinessTakesItAsDiffuse) {
  const TempFolder folder;
  GltfFile file = textured();
  file.root["extensionsUsed"] = {"KHR_materials_pbrSpecularGlossiness"};
  file.root["materials"] = {
      {{"extensions", {{"KHR_materials_pbrSpecularGlossiness", {{"specularFactor", {0.2, 0.3, 0.4}}}}}}}};
  const Scene after = load_scene(
      folder.write("out.glb", with_base_color(file.write_gltf(folder), kPicture, "wall.png", {"", 0.25})));
  EXPECT_EQ(after.materials.at(0).workflow, Workflow::SpecularGlossiness);
  EXPECT_EQ(after.materials.at(0).glossiness, 0.75);
  EXPECT_EQ(after.materials.at(0).specular, glm::dvec3(0.2, 0.3, 0.4));
  EXPECT_EQ(picture_of(after, after.materials.at(0).base_color_map), kPicture);
}

TEST(BaseColor, FileWithoutMaterialsGetsOne) {
  const TempFolder folder;
  GltfFile file = textured();
  file.primitive().erase("material");
  const Scene after = load_scene(folder.write(
      "out.glb", with_base_color(folder.write("scene.glb", file.glb()), kPicture, "wall.png", {})));
  EXPECT_TRUE(
      after.materials.at(static_cast<std::size_t>(after.meshes.at(0).material)).base_color_map.present());
}

TEST(BaseColor, MistakesAreRefusedWithTheReason) {
  const TempFolder folder;
  GltfFile file = textured();
  file.root["materials"] = {{{"name", "wall"}}, {{"name", "floor"}}, {{"name", "floor"}}};
  const auto scene = folder.write("scene.glb", file.glb());
  EXPECT_EQ(refusal(scene, kPicture, {"wall", std::nullopt}), "fine");
  EXPECT_THAT(refusal(scene, kPicture, {}), HasSubstr("--material: 0 wall, 1 floor, 2 floor"));
  EXPECT_THAT(refusal(scene, kPicture, {"Wall", std::nullopt}), HasSubstr("no material 'Wall'"));
  EXPECT_THAT(refusal(scene, kPicture, {"3", std::nullopt}), HasSubstr("no material '3'"));
  EXPECT_THAT(refusal(scene, kPicture, {"floor", std::nullopt}),
              HasSubstr("more than one material is named 'floor'"));
  EXPECT_THAT(refusal(scene, kPicture, {"1", std::nullopt}),
              HasSubstr("no mesh with material 1 has texture coordinates"));
  EXPECT_THAT(refusal(scene, kPicture, {"wall", 1.5}), HasSubstr("roughness 1.5"));
  EXPECT_THAT(refusal(scene, {'n', 'o'}, {"wall", std::nullopt}),
              HasSubstr("wall.png: expected a PNG or JPEG"));
  EXPECT_THAT(refusal(folder.write("broken.glb", std::string("glTF")), kPicture, {}),
              HasSubstr("broken.glb"));
  EXPECT_THAT(refusal(folder.path() / "missing.glb", kPicture, {}), HasSubstr("missing.glb"));
}

}  // namespace
}  // namespace aluminate::scenes::test
