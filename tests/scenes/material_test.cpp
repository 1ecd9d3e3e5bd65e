// Materials, textures, samplers, cameras and lights as the loader hands them on.
#include "platform/host/error.hpp"
#include "scenes/loader.hpp"
#include "scenes/scene_info.hpp"
#include "tests/scenes/gltf_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace aluminate::scenes::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

Scene load(const GltfFile& file) {
  const TempFolder folder;
  return load_scene(file.write_glb(folder));
}

/// A triangle with two uv sets, one image and texture 0, and material 0 as given.
GltfFile with_material(const json& material) {
  GltfFile file = GltfFile::triangle();
  file.attributes()["TEXCOORD_0"] = file.add_vec2({0, 0, 1, 0, 0, 1});
  file.attributes()["TEXCOORD_1"] = file.add_vec2({0, 0, 2, 0, 0, 2});
  file.append("textures", {{"source", 0}});
  file.append("images",
              {{"bufferView", file.add_view(png_header())}, {"mimeType", "image/png"}, {"name", "paint"}});
  file.append("materials", material);
  file.primitive()["material"] = 0;
  return file;
}

TEST(Materials, DefaultsAreThoseOfTheFormat) {
  const Scene scene = load(with_material(json::object()));
  const Material& m = scene.materials.at(0);
  EXPECT_EQ(m.name, "material 0");
  EXPECT_EQ(m.base_color, glm::dvec4(1));
  EXPECT_EQ(m.metallic, 1);
  EXPECT_EQ(m.roughness, 1);
  EXPECT_EQ(m.alpha_mode, AlphaMode::Opaque);
  EXPECT_EQ(m.alpha_cutoff, 0.5);
  EXPECT_FALSE(m.double_sided || m.unlit);
  EXPECT_FALSE(m.base_color_map.present());
  EXPECT_THAT(scene.meshes.at(0).uv0, IsEmpty()) << "no texture reads it";
}

TEST(Materials, MetallicRoughnessIsReadWhole) {
  const Scene scene = load(with_material({{"name", "paint"},
                                          {"pbrMetallicRoughness",
                                           {{"baseColorFactor", {0.5, 0.25, 0.125, 0.75}},
                                            {"metallicFactor", 0.5},
                                            {"roughnessFactor", 0.25},
                                            {"baseColorTexture", {{"index", 0}}},
                                            {"metallicRoughnessTexture", {{"index", 0}, {"texCoord", 1}}}}},
                                          {"normalTexture", {{"index", 0}, {"scale", 0.5}}},
                                          {"occlusionTexture", {{"index", 0}, {"strength", 0.75}}},
                                          {"emissiveTexture", {{"index", 0}}},
                                          {"emissiveFactor", {0.5, 1, 0}},
                                          {"alphaMode", "MASK"},
                                          {"alphaCutoff", 0.25},
                                          {"doubleSided", true}}));
  const Material& m = scene.materials.at(0);
  EXPECT_EQ(m.name, "paint");
  EXPECT_EQ(m.workflow, Workflow::MetallicRoughness);
  EXPECT_EQ(m.base_color, glm::dvec4(0.5, 0.25, 0.125, 0.75));
  EXPECT_EQ(m.metallic, 0.5);
  EXPECT_EQ(m.roughness, 0.25);
  EXPECT_EQ(m.normal_scale, 0.5);
  EXPECT_EQ(m.occlusion_strength, 0.75);
  EXPECT_EQ(m.emissive, glm::dvec3(0.5, 1, 0));
  EXPECT_EQ(m.alpha_mode, AlphaMode::Mask);
  EXPECT_EQ(m.alpha_cutoff, 0.25);
  EXPECT_TRUE(m.double_sided);
  EXPECT_EQ(m.metallic_roughness_map.uv_set, 1);
  for (const TextureSlot* slot :
       {&m.base_color_map, &m.metallic_roughness_map, &m.normal_map, &m.occlusion_map, &m.emissive_map})
    EXPECT_EQ(slot->image, 0);
  EXPECT_THAT(scene.meshes.at(0).uv0, SizeIs(3));
  EXPECT_EQ(scene.meshes.at(0).uv1[1], glm::vec2(2, 0));
  EXPECT_EQ(scene.images.at(0).bytes, png_header());
  EXPECT_THAT(scene.images.at(0).name, HasSubstr("scene.glb image 0 'paint'"));
  EXPECT_THAT(scene.warnings, IsEmpty());
}

TEST(Materials, SpecularGlossinessReplacesTheMetallicFallback) {
  const Scene scene =
      load(with_material({{"pbrMetallicRoughness",
                           {{"baseColorFactor", {1, 0, 0, 1}}, {"metallicRoughnessTexture", {{"index", 0}}}}},
                          {"extensions",
                           {{"KHR_materials_pbrSpecularGlossiness",
                             {{"diffuseFactor", {0.1, 0.2, 0.3, 0.4}},
                              {"specularFactor", {0.5, 0.6, 0.7}},
                              {"glossinessFactor", 0.8},
                              {"diffuseTexture", {{"index", 0}}},
                              {"specularGlossinessTexture", {{"index", 0}, {"texCoord", 1}}}}}}}}));
  const Material& m = scene.materials.at(0);
  EXPECT_EQ(m.workflow, Workflow::SpecularGlossiness);
  EXPECT_EQ(m.base_color, glm::dvec4(0.1, 0.2, 0.3, 0.4));
  EXPECT_EQ(m.specular, glm::dvec3(0.5, 0.6, 0.7));
  EXPECT_EQ(m.glossiness, 0.8);
  EXPECT_TRUE(m.base_color_map.present() && m.specular_glossiness_map.present());
  EXPECT_EQ(m.specular_glossiness_map.uv_set, 1);
  EXPECT_FALSE(m.metallic_roughness_map.present());
}

TEST(Materials, UnlitAndEmissiveStrength) {
  const Scene scene =
      load(with_material({{"emissiveFactor", {1, 0.5, 0}},
                          {"extensions",
                           {{"KHR_materials_unlit", json::object()},
                            {"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}}}}}));
  EXPECT_TRUE(scene.materials.at(0).unlit);
  EXPECT_EQ(scene.materials.at(0).emissive, glm::dvec3(4, 2, 0));
}

TEST(Materials, OutOfRangeFactorsAreClampedWithAWarning) {
  const Scene scene = load(
      with_material({{"pbrMetallicRoughness", {{"metallicFactor", 2}, {"roughnessFactor", -1}}},
                     {"emissiveFactor", {1e300, 0, 0}},
                     {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 1e300}}}}}}));
  EXPECT_EQ(scene.materials.at(0).metallic, 1);
  EXPECT_EQ(scene.materials.at(0).roughness, 0);
  EXPECT_EQ(scene.materials.at(0).emissive.x, 65536);
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("metallicFactor"), HasSubstr("roughnessFactor"),
                                          HasSubstr("emissiveFactor")));
}

TEST(Textures, SamplersMapEveryFilterAndWrap) {
  struct Case {
    int min_filter;
    Filter minify;
    bool mipmapped;
    Filter mip;
  };
  for (const Case& c :
       {Case{9728, Filter::Nearest, false, Filter::Linear}, Case{9729, Filter::Linear, false, Filter::Linear},
        Case{9984, Filter::Nearest, true, Filter::Nearest}, Case{9985, Filter::Linear, true, Filter::Nearest},
        Case{9986, Filter::Nearest, true, Filter::Linear},
        Case{9987, Filter::Linear, true, Filter::Linear}}) {
    GltfFile file = with_material({{"normalTexture", {{"index", 0}}}});
    file.append("samplers",
                {{"minFilter", c.min_filter}, {"magFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33648}});
    file.root["textures"][0]["sampler"] = 0;
    const Sampler sampler = load(file).materials.at(0).normal_map.sampler;
    EXPECT_EQ(sampler, (Sampler{Wrap::Clamp, Wrap::Mirror, Filter::Nearest, c.minify, c.mipmapped, c.mip}))
        << c.min_filter;
  }
  EXPECT_EQ(load(with_material({{"normalTexture", {{"index", 0}}}})).materials.at(0).normal_map.sampler,
            Sampler{});
}

TEST(Textures, TransformScalesThenTurnsThenMoves) {
  GltfFile file = with_material({{"normalTexture",
                                  {{"index", 0},
                                   {"extensions",
                                    {{"KHR_texture_transform",
                                      {{"offset", {0.25, 0.5}},
                                       {"rotation", 1.5707963267948966},
                                       {"scale", {2, 3}},
                                       {"texCoord", 1}}}}}}}});
  const TextureSlot slot = load(file).materials.at(0).normal_map;
  EXPECT_EQ(slot.uv_set, 1);
  // A quarter turn counter-clockwise as seen with v downwards: (u, v) -> (v, -u). Scale first: (2u, 3v).
  const glm::dvec2 moved = slot.uv_transform * glm::dvec3(0.5, 0.125, 1);
  EXPECT_NEAR(moved.x, 0.25 + 3 * 0.125, 1e-15);
  EXPECT_NEAR(moved.y, 0.5 - 2 * 0.5, 1e-15);
}

TEST(Textures, AThirdUvSetDropsTheTextureWithAWarning) {
  const Scene scene = load(with_material({{"normalTexture", {{"index", 0}, {"texCoord", 2}}}}));
  EXPECT_FALSE(scene.materials.at(0).normal_map.present());
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("uv set 2")));
}

TEST(Textures, ImageTypesThatAreNotReadAreDroppedByName) {
  struct Case {
    Bytes bytes;
    const char* name;
  };
  for (const Case& c : {Case{{'R', 'I', 'F', 'F', 0, 0, 0, 0, 'W', 'E', 'B', 'P'}, "WebP"},
                        Case{{0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB, '\r', '\n', 0x1a, '\n'}, "KTX2"},
                        Case{{'s', 'B', 0x13, 0}, "Basis"}}) {
    GltfFile file = with_material({{"normalTexture", {{"index", 0}}}});
    file.root["images"][0]["bufferView"] = file.add_view(c.bytes);
    const Scene scene = load(file);
    EXPECT_FALSE(scene.materials.at(0).normal_map.present());
    EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr(c.name)));
  }
}

TEST(Textures, ExtensionImageWithoutFallbackIsDroppedAndWithFallbackIsNot) {
  GltfFile file = with_material({{"normalTexture", {{"index", 0}}}});
  file.root["extensionsUsed"] = {"EXT_texture_webp"};
  file.root["textures"][0]["extensions"]["EXT_texture_webp"] = {{"source", 0}};
  EXPECT_TRUE(load(file).materials.at(0).normal_map.present());
  file.root["textures"][0].erase("source");
  const Scene scene = load(file);
  EXPECT_FALSE(scene.materials.at(0).normal_map.present());
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("extension EXT_texture_webp is not supported"),
                                          HasSubstr("only a EXT_texture_webp")));
}

TEST(Textures, JunkInPlaceOfAUsedImageIsAnError) {
  GltfFile file = with_material({{"normalTexture", {{"index", 0}}}});
  file.root["images"][0]["bufferView"] = file.add_view(Bytes{'h', 'e', 'l', 'l', 'o'});
  try {
    load(file);
    FAIL();
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/images/0: is neither PNG nor JPEG"));
  }
  file.root["materials"][0].erase("normalTexture");
  EXPECT_NO_THROW(load(file)) << "nothing uses it";
}

TEST(Extensions, RequiredUnsupportedIsAnErrorThatNamesItAndOptionalAWarning) {
  GltfFile file = GltfFile::triangle();
  file.root["extensionsUsed"] = {"KHR_materials_unlit", "KHR_draco_mesh_compression"};
  EXPECT_THAT(load(file).warnings,
              ElementsAre("extension KHR_draco_mesh_compression is not supported and was ignored"));
  file.root["extensionsRequired"] = {"KHR_materials_unlit", "KHR_draco_mesh_compression"};
  try {
    load(file);
    FAIL();
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/extensionsRequired/1: the file needs KHR_draco_mesh_compression"));
  }
}

TEST(Extensions, AllSupportedOnesMayBeRequired) {
  GltfFile file = GltfFile::triangle();
  file.root["extensionsRequired"] = {
      "KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_pbrSpecularGlossiness",
      "KHR_materials_unlit", "KHR_mesh_quantization",           "KHR_texture_transform"};
  EXPECT_THAT(load(file).warnings, IsEmpty());
}

TEST(Extensions, MorphSkinsAndAnimationsAreIgnoredWithAWarning) {
  GltfFile file = GltfFile::triangle();
  file.primitive()["targets"] = json::array({{{"POSITION", 0}}});
  file.append("skins", {{"joints", {0}}});
  file.root["nodes"][0]["skin"] = 0;
  file.append("animations", {{"channels", json::array()}, {"samplers", json::array()}});
  EXPECT_THAT(load(file).warnings,
              ElementsAre(HasSubstr("animations"), HasSubstr("skin"), HasSubstr("morph")));
}

TEST(Cameras, PerspectiveAndOrthographicInNodeOrder) {
  GltfFile file = GltfFile::triangle();
  file.append("cameras", {{"type", "orthographic"},
                          {"orthographic", {{"xmag", 3}, {"ymag", 2}, {"znear", 0}, {"zfar", 50}}}});
  file.append("cameras",
              {{"type", "perspective"}, {"name", "lens"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}});
  file.add_node({{"camera", 1}, {"translation", {1, 2, 3}}});
  file.add_node({{"camera", 0}, {"name", "plan"}});
  const Scene scene = load(file);
  ASSERT_THAT(scene.cameras, SizeIs(2));
  EXPECT_EQ(scene.cameras[0].name, "lens");
  EXPECT_TRUE(scene.cameras[0].perspective);
  EXPECT_EQ(scene.cameras[0].fovy, 0.5);
  EXPECT_EQ(scene.cameras[0].near_plane, 0.1);
  EXPECT_EQ(scene.cameras[0].far_plane, 0);
  EXPECT_EQ(glm::dvec3(scene.cameras[0].camera_to_world[3]), glm::dvec3(1, 2, 3));
  EXPECT_EQ(scene.cameras[1].name, "plan");
  EXPECT_FALSE(scene.cameras[1].perspective);
  EXPECT_EQ(scene.cameras[1].xmag, 3);
  EXPECT_EQ(scene.cameras[1].ymag, 2);
  EXPECT_EQ(scene.cameras[1].far_plane, 50);
}

TEST(Cameras, UnusableOnesAreLeftOutWithAWarning) {
  GltfFile file = GltfFile::triangle();
  file.append("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 4}, {"znear", 0.1}}}});
  file.append("cameras",
              {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.5}, {"zfar", 0.25}}}});
  file.add_node({{"camera", 0}});
  file.add_node({{"camera", 1}});
  const Scene scene = load(file);
  ASSERT_THAT(scene.cameras, SizeIs(1));
  EXPECT_EQ(scene.cameras[0].far_plane, 0);
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("/cameras/0"), HasSubstr("zfar")));
}

GltfFile with_light(const json& light, const json& node = json::object()) {
  GltfFile file = GltfFile::triangle();
  file.root["extensions"]["KHR_lights_punctual"]["lights"] = json::array({light});
  json placed = node;
  placed["extensions"]["KHR_lights_punctual"]["light"] = 0;
  file.add_node(placed);
  return file;
}

TEST(Lights, PunctualLightsFollowTheirNode) {
  const double h = std::sqrt(0.5);
  const Scene scene = load(with_light({{"type", "spot"},
                                       {"name", "lamp"},
                                       {"color", {1, 0.5, 0.25}},
                                       {"intensity", 300},
                                       {"range", 20},
                                       {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}},
                                      {{"translation", {1, 2, 3}}, {"rotation", {-h, 0, 0, h}}}));
  ASSERT_THAT(scene.lights, SizeIs(1));
  const Light& light = scene.lights[0];
  EXPECT_EQ(light.name, "lamp");
  EXPECT_EQ(light.kind, LightKind::Spot);
  EXPECT_EQ(light.color, glm::dvec3(1, 0.5, 0.25));
  EXPECT_EQ(light.intensity, 300);
  EXPECT_EQ(light.range, 20);
  EXPECT_EQ(light.inner_cone, 0.25);
  EXPECT_EQ(light.outer_cone, 0.5);
  EXPECT_EQ(light.position, glm::dvec3(1, 2, 3));
  EXPECT_NEAR(light.direction.y, -1, 1e-15);  // -z turned by -90 degrees about x
}

TEST(Lights, DefaultsAndClamps) {
  Scene scene = load(with_light({{"type", "directional"}}));
  EXPECT_EQ(scene.lights.at(0).kind, LightKind::Directional);
  EXPECT_EQ(scene.lights[0].intensity, 1);
  EXPECT_EQ(scene.lights[0].color, glm::dvec3(1));
  EXPECT_EQ(scene.lights[0].direction, glm::dvec3(0, 0, -1));
  scene = load(with_light(
      {{"type", "spot"}, {"intensity", -5}, {"spot", {{"innerConeAngle", 2}, {"outerConeAngle", 1}}}}));
  EXPECT_EQ(scene.lights.at(0).intensity, 0);
  EXPECT_EQ(scene.lights[0].inner_cone, 1);
  EXPECT_THAT(scene.warnings, SizeIs(2));
}

TEST(SceneInfo, CountsNamesAndSizes) {
  GltfFile file =
      with_material({{"name", "paint"}, {"alphaMode", "BLEND"}, {"normalTexture", {{"index", 0}}}});
  file.append("cameras",
              {{"type", "perspective"}, {"name", "lens"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}});
  file.add_node({{"camera", 0}});
  const Scene scene = load(file);
  const SceneInfo info = scene_info(scene);
  EXPECT_EQ(info.triangles, 1u);
  EXPECT_EQ(info.vertices, 3u);
  EXPECT_THAT(info.triangles_per_material, ElementsAre(1u));
  EXPECT_THAT(info.materials, ElementsAre("paint: metallic-roughness, blend, maps: normal"));
  ASSERT_THAT(info.images, SizeIs(1));
  EXPECT_EQ(info.images[0].width_px, 2);
  EXPECT_EQ(info.images[0].height_px, 3);
  EXPECT_EQ(info.images[0].kind, "PNG");
  EXPECT_THAT(info.images[0].uses, ElementsAre("paint: normal"));
  EXPECT_THAT(scene_info_text(info), HasSubstr("lens: perspective, fovy 28.65 deg"));
  const json parsed = json::parse(scene_info_json(info));
  EXPECT_EQ(parsed.at("triangles"), 1);
  EXPECT_EQ(parsed.at("images").at(0).at("width_px"), 2);
  EXPECT_EQ(parsed.at("content_hash"), scene.content_hash);
}

}  // namespace
}  // namespace aluminate::scenes::test
