// What the loader makes of vertices, indices and nodes.
#include "platform/host/error.hpp"
#include "scenes/loader.hpp"
#include "tests/scenes/gltf_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

glm::dvec3 face_normal(const Mesh& mesh, std::size_t triangle = 0) {
  const auto& i = mesh.indices;
  const glm::dvec3 a = mesh.positions[i[3 * triangle]], b = mesh.positions[i[3 * triangle + 1]],
                   c = mesh.positions[i[3 * triangle + 2]];
  return glm::cross(b - a, c - a);
}

TEST(Geometry, TriangleKeepsPositionsOrderAndBounds) {
  const Scene scene = load(GltfFile::triangle());
  ASSERT_THAT(scene.meshes, SizeIs(1));
  const Mesh& mesh = scene.meshes[0];
  EXPECT_THAT(mesh.positions, ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)));
  EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2));
  EXPECT_EQ(mesh.name, "node 0/mesh 0/0");
  EXPECT_EQ(scene.bounds_min, glm::dvec3(0));
  EXPECT_EQ(scene.bounds_max, glm::dvec3(1, 1, 0));
  EXPECT_THAT(scene.warnings, IsEmpty());
  EXPECT_THAT(mesh.uv0, IsEmpty());
  EXPECT_THAT(mesh.colors, IsEmpty());
}

TEST(Geometry, DefaultMaterialIsAppendedOnceAndOnlyWhenNeeded) {
  GltfFile file = GltfFile::triangle();
  file.append("materials", {{"name", "paint"}});
  file.root["meshes"][0]["primitives"].push_back(file.primitive());
  file.root["meshes"][0]["primitives"][1]["material"] = 0;
  file.root["meshes"][0]["primitives"].push_back(file.primitive());
  const Scene scene = load(file);
  ASSERT_THAT(scene.materials, SizeIs(2));
  EXPECT_EQ(scene.materials[1].name, "default");
  EXPECT_EQ(scene.meshes[0].material, 1);
  EXPECT_EQ(scene.meshes[1].material, 0);
  EXPECT_EQ(scene.meshes[2].material, 1);
}

TEST(Geometry, IndicesOfEveryTypeAreRead) {
  for (const int type : {kUnsignedByte, kUnsignedShort, kUnsignedInt}) {
    GltfFile file = GltfFile::triangle();
    int accessor = 0;
    if (type == kUnsignedByte) accessor = file.add_accessor<std::uint8_t>({0, 2, 1}, "SCALAR", type, 3);
    if (type == kUnsignedShort) accessor = file.add_accessor<std::uint16_t>({0, 2, 1}, "SCALAR", type, 3);
    if (type == kUnsignedInt) accessor = file.add_accessor<std::uint32_t>({0, 2, 1}, "SCALAR", type, 3);
    file.primitive()["indices"] = accessor;
    EXPECT_THAT(load(file).meshes.at(0).indices, ElementsAre(0, 2, 1)) << type;
  }
}

TEST(Geometry, StripAlternatesSoThatEveryTriangleFacesTheSameWay) {
  GltfFile file;
  const int p = file.add_vec3({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0});
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", p}}}, {"mode", 5}})}});
  const Scene scene = load(file);
  const Mesh& mesh = scene.meshes.at(0);
  EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2, 1, 3, 2, 2, 3, 4));
  for (std::size_t t = 0; t < 3; ++t) EXPECT_GT(face_normal(mesh, t).z, 0) << t;
}

TEST(Geometry, FanTurnsAroundItsFirstVertex) {
  GltfFile file;
  const int p = file.add_vec3({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", p}}}, {"mode", 6}})}});
  const Scene scene = load(file);
  const Mesh& mesh = scene.meshes.at(0);
  EXPECT_THAT(mesh.indices, ElementsAre(1, 2, 0, 2, 3, 0));
  for (std::size_t t = 0; t < 2; ++t) EXPECT_GT(face_normal(mesh, t).z, 0) << t;
}

TEST(Geometry, PointsAndLinesAreSkippedWithOneWarningEach) {
  GltfFile file = GltfFile::triangle();
  const json primitive = file.primitive();
  for (const int mode : {0, 1, 2, 3}) {
    file.root["meshes"][0]["primitives"].push_back(primitive);
    file.root["meshes"][0]["primitives"].back()["mode"] = mode;
  }
  file.add_node({{"mesh", 0}});  // a second instance repeats no warning
  const Scene scene = load(file);
  EXPECT_THAT(scene.meshes, SizeIs(2));
  EXPECT_THAT(scene.warnings,
              ElementsAre(HasSubstr("primitives/1: points"), HasSubstr("primitives/2: lines"),
                          HasSubstr("primitives/3: lines"), HasSubstr("primitives/4: lines")));
}

TEST(Geometry, LeftOverCornersAreDroppedWithAWarning) {
  GltfFile file = GltfFile::triangle();
  file.primitive()["indices"] = file.add_indices({0, 1, 2, 0, 1});
  const Scene scene = load(file);
  EXPECT_THAT(scene.meshes.at(0).indices, ElementsAre(0, 1, 2));
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("the last 2 were dropped")));
}

TEST(Geometry, InterleavedVerticesFollowTheStride) {
  GltfFile file;
  // position, normal: 24 bytes apart
  const int view = file.add_view<float>({0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1}, 24);
  const int p = file.append(
      "accessors", {{"bufferView", view}, {"componentType", kFloat}, {"count", 3}, {"type", "VEC3"}});
  const int n = file.append(
      "accessors",
      {{"bufferView", view}, {"byteOffset", 12}, {"componentType", kFloat}, {"count", 3}, {"type", "VEC3"}});
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", p}, {"NORMAL", n}}}})}});
  const Scene scene = load(file);
  EXPECT_THAT(scene.meshes.at(0).positions,
              ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)));
  EXPECT_THAT(scene.meshes.at(0).normals, testing::Each(glm::vec3(0, 0, 1)));
}

TEST(Geometry, QuantisedPositionsKeepTheirIntegersOrNormalise) {
  GltfFile file = GltfFile::triangle();
  file.attributes()["POSITION"] = file.add_accessor<std::int16_t>(
      {-32767, -32768, 0, 0, 32767, 0, 0, 0, 16384, 0, 0, 0}, "VEC3", kShort, 3, true, 8);
  Scene scene = load(file);
  EXPECT_EQ(scene.meshes.at(0).positions[0], glm::dvec3(-1, -1, 0));  // -32768 clamps to -1
  EXPECT_EQ(scene.meshes.at(0).positions[1].x, 1.0);
  EXPECT_EQ(scene.meshes.at(0).positions[2].x, static_cast<double>(16384.0f / 32767.0f));

  file.attributes()["POSITION"] = file.add_accessor<std::uint8_t>({0, 0, 7, 0, 255, 0, 7, 0, 0, 255, 7, 0},
                                                                  "VEC3", kUnsignedByte, 3, false, 4);
  scene = load(file);
  EXPECT_THAT(scene.meshes.at(0).positions,
              ElementsAre(glm::dvec3(0, 0, 7), glm::dvec3(255, 0, 7), glm::dvec3(0, 255, 7)));
}

TEST(Geometry, NormalisedIntegersReachExactlyOne) {
  GltfFile file = GltfFile::triangle();
  file.append("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  file.append("textures", {{"source", 0}});
  file.append("images", {{"bufferView", file.add_view(png_header())}, {"mimeType", "image/png"}});
  file.primitive()["material"] = 0;
  file.attributes()["NORMAL"] =
      file.add_accessor<std::int8_t>({0, 0, 127, 0, 0, 0, 127, 0, 0, 0, -128, 0}, "VEC3", kByte, 3, true, 4);
  file.attributes()["TEXCOORD_0"] =
      file.add_accessor<std::uint16_t>({0, 65535, 32768, 0, 65535, 0}, "VEC2", kUnsignedShort, 3, true);
  file.attributes()["COLOR_0"] = file.add_accessor<std::uint8_t>(
      {255, 0, 51, 0, 255, 255, 255, 0, 0, 0, 255, 0}, "VEC3", kUnsignedByte, 3, true, 4);
  const Scene scene = load(file);
  const Mesh& mesh = scene.meshes.at(0);
  EXPECT_THAT(mesh.normals, ElementsAre(glm::vec3(0, 0, 1), glm::vec3(0, 0, 1), glm::vec3(0, 0, -1)));
  EXPECT_THAT(mesh.uv0, ElementsAre(glm::vec2(0, 1), glm::vec2(32768.0f / 65535.0f, 0), glm::vec2(1, 0)));
  EXPECT_THAT(mesh.colors,
              ElementsAre(glm::vec4(1, 0, 0.2f, 1), glm::vec4(1, 1, 1, 1), glm::vec4(0, 0, 1, 1)));
  EXPECT_THAT(scene.warnings, IsEmpty());
}

TEST(Geometry, ColorsOfFourComponentsKeepAlpha) {
  GltfFile file = GltfFile::triangle();
  file.attributes()["COLOR_0"] = file.add_vec4({1, 0, 0, 0.5f, 0, 1, 0, 0.25f, 0, 0, 1, 1});
  EXPECT_THAT(load(file).meshes.at(0).colors,
              ElementsAre(glm::vec4(1, 0, 0, 0.5f), glm::vec4(0, 1, 0, 0.25f), glm::vec4(0, 0, 1, 1)));
  file.attributes()["COLOR_0"] = file.add_accessor<std::uint16_t>(
      {65535, 0, 0, 0, 0, 0, 0, 65535, 0, 0, 0, 13107}, "VEC4", kUnsignedShort, 3, true);
  EXPECT_THAT(load(file).meshes.at(0).colors,
              ElementsAre(glm::vec4(1, 0, 0, 0), glm::vec4(0, 0, 0, 1), glm::vec4(0, 0, 0, 0.2f)));
}

TEST(Geometry, SparseValuesReplaceAndUndefinedBaseIsZero) {
  GltfFile file = GltfFile::triangle();
  const int indices = file.add_view<std::uint8_t>({1, 2});
  const int values = file.add_view<float>({5, 6, 7, 8, 9, 10});
  file.root["accessors"][0]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", indices}, {"componentType", kUnsignedByte}}},
      {"values", {{"bufferView", values}}}};
  EXPECT_THAT(load(file).meshes.at(0).positions,
              ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(5, 6, 7), glm::dvec3(8, 9, 10)));
  file.root["accessors"][0].erase("bufferView");
  file.root["accessors"][0]["count"] = 4;
  EXPECT_THAT(load(file).meshes.at(0).positions,
              ElementsAre(glm::dvec3(0), glm::dvec3(5, 6, 7), glm::dvec3(8, 9, 10), glm::dvec3(0)));
}

TEST(Geometry, SparseIndicesAreSupported) {
  GltfFile file = GltfFile::triangle();
  file.primitive()["indices"] = file.add_indices({0, 0, 0});
  file.root["accessors"][1]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", file.add_view<std::uint16_t>({1, 2})}, {"componentType", kUnsignedShort}}},
      {"values", {{"bufferView", file.add_view<std::uint16_t>({1, 2})}}}};
  EXPECT_THAT(load(file).meshes.at(0).indices, ElementsAre(0, 1, 2));
}

TEST(Geometry, MissingNormalsAreAreaWeightedSums) {
  // Two triangles share an edge along z: one in the plane y = 0 (area 1/2), one in x = 0 (area 3/2).
  GltfFile file;
  const int p = file.add_vec3({0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 3, 0});
  const int i = file.add_indices({0, 1, 2, 0, 3, 1});
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", p}}}, {"indices", i}})}});
  const Scene scene = load(file);
  const Mesh& mesh = scene.meshes.at(0);
  // cross((0,0,1),(1,0,0)) = (0,1,0); cross((0,3,0),(0,0,1)) = (3,0,0); the shared vertices get their sum,
  // unit.
  const float s = static_cast<float>(1 / std::sqrt(10.0)), l = static_cast<float>(3 / std::sqrt(10.0));
  for (const std::size_t shared : {0u, 1u}) {
    EXPECT_FLOAT_EQ(mesh.normals[shared].x, l);
    EXPECT_FLOAT_EQ(mesh.normals[shared].y, s);
  }
  EXPECT_EQ(mesh.normals[2], glm::vec3(0, 1, 0));
  EXPECT_EQ(mesh.normals[3], glm::vec3(1, 0, 0));
}

GltfFile normal_mapped(const std::vector<float>& uv) {
  GltfFile file = GltfFile::triangle();
  file.append("materials", {{"normalTexture", {{"index", 0}}}});
  file.append("textures", {{"source", 0}});
  file.append("images", {{"bufferView", file.add_view(png_header())}, {"mimeType", "image/png"}});
  file.primitive()["material"] = 0;
  file.attributes()["NORMAL"] = file.add_vec3({0, 0, 1, 0, 0, 1, 0, 0, 1});
  file.attributes()["TEXCOORD_0"] = file.add_vec2(uv);
  return file;
}

TEST(Geometry, GeneratedTangentsFollowUAndKnowMirroredUv) {
  Scene scene = load(normal_mapped({0, 0, 1, 0, 0, 1}));  // u along x, v along y
  EXPECT_THAT(scene.meshes.at(0).tangents, testing::Each(glm::vec4(1, 0, 0, 1)));
  scene = load(normal_mapped({0, 0, 0, 1, 1, 0}));  // u along y, v along x: cross(N, T) = -x
  EXPECT_THAT(scene.meshes.at(0).tangents, testing::Each(glm::vec4(0, 1, 0, -1)));
  scene = load(normal_mapped({0, 0, 0, 0, 0, 0}));  // no area in uv: any orthogonal unit vector
  for (const glm::vec4& t : scene.meshes.at(0).tangents)
    EXPECT_EQ(glm::dot(glm::vec3(t), glm::vec3(0, 0, 1)), 0.0f);
}

TEST(Geometry, GeneratedTangentsSeeTheTextureTransform) {
  GltfFile file = normal_mapped({0, 0, 1, 0, 0, 1});
  file.root["materials"][0]["normalTexture"]["extensions"]["KHR_texture_transform"]["scale"] = {-1, 1};
  EXPECT_THAT(load(file).meshes.at(0).tangents, testing::Each(glm::vec4(-1, 0, 0, -1)));
}

TEST(Geometry, GivenTangentsAreMadeOrthogonalAndKeepTheirSign) {
  GltfFile file = normal_mapped({0, 0, 1, 0, 0, 1});
  file.attributes()["TANGENT"] =
      file.add_vec4({1, 0, 1, -1, 0, 2, 0, 1, 0, 0, 1, 1});  // the last one is along the normal
  const Scene scene = load(file);
  const Mesh& mesh = scene.meshes.at(0);
  EXPECT_EQ(mesh.tangents[0], glm::vec4(1, 0, 0, -1));
  EXPECT_EQ(mesh.tangents[1], glm::vec4(0, 1, 0, 1));
  EXPECT_EQ(mesh.tangents[2].z, 0.0f);
}

TEST(Geometry, MirroredNodeKeepsTheOutsideOutside) {
  GltfFile file = normal_mapped({0, 0, 1, 0, 0, 1});
  file.attributes()["TANGENT"] = file.add_vec4({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1});
  file.root["nodes"][0]["scale"] = {-1, 1, 1};
  const Scene scene = load(file);
  const Mesh& mesh = scene.meshes.at(0);
  EXPECT_THAT(mesh.positions, ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 1, 0)));
  EXPECT_THAT(mesh.indices, ElementsAre(0, 2, 1));
  EXPECT_GT(face_normal(mesh).z, 0);
  EXPECT_THAT(mesh.normals, testing::Each(glm::vec3(0, 0, 1)));
  // T' = -x; the mirrored bitangent is still +y = cross(N, T') * -1.
  EXPECT_THAT(mesh.tangents, testing::Each(glm::vec4(-1, 0, 0, -1)));
  GltfFile generated = normal_mapped({0, 0, 1, 0, 0, 1});
  generated.root["nodes"][0]["scale"] = {-1, 1, 1};
  EXPECT_THAT(load(generated).meshes.at(0).tangents, testing::Each(glm::vec4(-1, 0, 0, -1)));
}

TEST(Geometry, NormalsUnderUnevenScaleStayPerpendicular) {
  GltfFile file;  // a 45 degree slope: normal (1,1,0)/sqrt2
  const int p = file.add_vec3({1, 0, 0, 0, 1, 0, 1, 0, -1});
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", p}}}})}, {"scale", {4, 1, 1}}});
  const Scene scene = load(file);
  const Mesh& mesh = scene.meshes.at(0);
  const glm::dvec3 face = glm::normalize(face_normal(mesh));
  EXPECT_NEAR(glm::dot(face, glm::dvec3(mesh.normals[0])), 1, 1e-7);  // float normals
  EXPECT_NEAR(mesh.normals[0].y / mesh.normals[0].x, 4, 1e-6);
}

TEST(Geometry, NodesComposeAndInstancesAreSeparateMeshes) {
  GltfFile file = GltfFile::triangle();
  file.root["nodes"][0]["name"] = "leaf";
  const double h = std::sqrt(0.5);
  // 90 degrees about z, then moved: local (1,0,0) -> (0,1,0) * 2 + (10,0,0)
  file.add_node(
      {{"children", {0, 2}}, {"translation", {10, 0, 0}}, {"rotation", {0, 0, h, h}}, {"scale", {2, 2, 2}}});
  file.add_node({{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 3, 1}}});
  const Scene scene = load(file);
  ASSERT_THAT(scene.meshes, SizeIs(2));
  EXPECT_EQ(scene.meshes[0].name, "leaf/mesh 0/0");
  EXPECT_NEAR(scene.meshes[0].positions[1].x, 10, 1e-15);
  EXPECT_NEAR(scene.meshes[0].positions[1].y, 2, 1e-15);
  EXPECT_EQ(scene.meshes[1].positions[0], glm::dvec3(10, 0, 6));
  EXPECT_THAT(scene.warnings, IsEmpty());
}

TEST(Geometry, OnlyTheDefaultSceneIsPlaced) {
  GltfFile file = GltfFile::triangle();
  file.add_node({{"mesh", 0}, {"translation", {5, 0, 0}}});
  file.root["scenes"] = json::array({{{"nodes", {0}}}, {{"nodes", {1}}}});
  EXPECT_EQ(load(file).bounds_min.x, 0);
  file.root["scene"] = 1;
  EXPECT_EQ(load(file).bounds_min.x, 5);
  EXPECT_THAT(load(file).meshes, SizeIs(1));
}

TEST(Geometry, SingularMatrixIsDrawnFlatWithAWarning) {
  GltfFile file = GltfFile::triangle();
  file.root["nodes"][0]["scale"] = {1, 1, 0};
  const Scene scene = load(file);
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("singular")));
  EXPECT_EQ(scene.meshes.at(0).normals[0], glm::vec3(0, 0, 1));  // flattened onto its own plane
}

TEST(Geometry, MatrixThatOverflowsIsMentionedAndLeavesNoBounds) {
  GltfFile file = GltfFile::triangle();
  file.add_node({{"children", {0}}, {"scale", {1e300, 1, 1}}});
  file.root["nodes"][0]["scale"] = {1e300, 1, 1};
  const Scene scene = load(file);
  EXPECT_THAT(scene.warnings,
              ElementsAre(HasSubstr("world matrix is not finite"), HasSubstr("positions are not finite")));
  EXPECT_EQ(scene.bounds_max, glm::dvec3(0));
}

TEST(Geometry, QuaternionsOfAnyLengthTurnWithoutScaling) {
  GltfFile file = GltfFile::triangle();
  file.root["nodes"][0]["rotation"] = {0, 0, 3, 3};  // a quarter turn about z, not of unit length
  Scene scene = load(file);
  EXPECT_NEAR(scene.meshes.at(0).positions[1].y, 1, 1e-15);
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("not of unit length")));
  file.root["nodes"][0]["rotation"] = {0, 0, 0, 0};
  scene = load(file);
  EXPECT_EQ(scene.meshes.at(0).positions[1], glm::dvec3(1, 0, 0));
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("has no direction")));
}

TEST(Geometry, NonFinitePositionsAreKeptButDoNotCountForTheBounds) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInf = std::numeric_limits<float>::infinity();
  GltfFile file;
  const int p = file.add_vec3({0, 0, 0, 1, 0, 0, 0, 1, 0, kNan, 9, 9, kInf, 9, 9});
  const int i = file.add_indices({0, 1, 2, 0, 1, 3, 2, 1, 4});
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", p}}}, {"indices", i}})}});
  const Scene scene = load(file);
  const Mesh& mesh = scene.meshes.at(0);
  EXPECT_TRUE(std::isnan(mesh.positions[3].x));
  EXPECT_TRUE(std::isinf(mesh.positions[4].x));
  EXPECT_THAT(mesh.indices, SizeIs(9));
  EXPECT_EQ(scene.bounds_max, glm::dvec3(1, 1, 0));
  EXPECT_EQ(mesh.normals[0], glm::vec3(0, 0, 1)) << "a broken triangle must not spoil its neighbours";
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("2 positions are not finite")));
}

TEST(Geometry, BrokenAttributesAreRepairedWithAWarning) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  GltfFile file = normal_mapped({kNan, 0, 1, 0, 0, 1});
  file.attributes()["NORMAL"] = file.add_vec3({kNan, 0, 0, 0, 0, 0, 0, 0, 5});
  file.attributes()["TANGENT"] = file.add_vec4({kNan, 0, 0, 1, 1, 0, 0, kNan, 1, 0, 0, 1});
  file.attributes()["COLOR_0"] = file.add_vec3({kNan, 0, 0, -1, 0.5f, 0, 0, 0, 1e9f});
  const Scene scene = load(file);
  const Mesh& mesh = scene.meshes.at(0);
  EXPECT_THAT(mesh.normals, testing::Each(glm::vec3(0, 0, 1)));
  EXPECT_EQ(mesh.uv0[0], glm::vec2(0));
  EXPECT_THAT(mesh.colors,
              ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(1, 0.5f, 0, 1), glm::vec4(0, 0, 1, 1)));
  for (const glm::vec4& t : mesh.tangents) {
    EXPECT_EQ(glm::dot(glm::vec3(t), glm::vec3(t)), 1.0f);
    EXPECT_EQ(std::fabs(t.w), 1.0f);
  }
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("1 TEXCOORD_0"), HasSubstr("2 normals"),
                                          HasSubstr("2 tangents"), HasSubstr("3 COLOR_0")));
}

TEST(Geometry, MissingUvThatAMaterialNeedsIsZeroWithAWarning) {
  GltfFile file = normal_mapped({0, 0, 1, 0, 0, 1});
  file.attributes().erase("TEXCOORD_0");
  const Scene scene = load(file);
  EXPECT_THAT(scene.meshes.at(0).uv0, ElementsAre(glm::vec2(0), glm::vec2(0), glm::vec2(0)));
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("TEXCOORD_0")));
}

TEST(Geometry, LimitsAreCheckedBeforeAnythingIsAllocated) {
  GltfFile file = GltfFile::triangle();
  file.root["accessors"][0] = {
      {"componentType", kFloat}, {"count", 4000000000u}, {"type", "VEC3"}};  // zeros, no bytes behind them
  const TempFolder folder;
  const auto path = file.write_glb(folder);
  try {
    load_scene(path);
    FAIL() << "4e9 vertices were accepted";
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/meshes/0/primitives/0"));
    EXPECT_THAT(error.what(), HasSubstr("more than 33554432 vertices"));
  }
}

TEST(Geometry, InstancesCountAgainstTheLimits) {
  GltfFile file = GltfFile::triangle();
  for (int i = 0; i < 9; ++i) file.add_node({{"mesh", 0}});
  const TempFolder folder;
  const auto path = file.write_glb(folder);
  EXPECT_NO_THROW(load_scene(path, {.vertices = 30, .indices = 30, .draws = 10}));
  EXPECT_THROW(load_scene(path, {.vertices = 29}), UserError);
  EXPECT_THROW(load_scene(path, {.indices = 29}), UserError);
  EXPECT_THROW(load_scene(path, {.draws = 9}), UserError);
}

}  // namespace
}  // namespace aluminate::scenes::test
