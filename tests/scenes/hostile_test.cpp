// Broken and malicious files: each ends in a Scene or in one UserError that names the place, never in
// anything else.
#include "platform/host/error.hpp"
#include "scenes/loader.hpp"
#include "tests/scenes/gltf_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace aluminate::scenes::test {
namespace {

using testing::HasSubstr;

/// A file that uses every feature the loader reads, so that damage has something to hit.
GltfFile rich() {
  GltfFile file;
  const int p = file.add_vec3({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
  const int n = file.add_vec3({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int uv = file.add_vec2({0, 0, 1, 0, 0, 1, 1, 1});
  const int t = file.add_vec4({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1});
  const int c = file.add_accessor<std::uint8_t>(Bytes(16, 128), "VEC4", kUnsignedByte, 4, true);
  const int i = file.add_indices({0, 1, 2, 2, 1, 3});
  file.root["accessors"][p]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", file.add_view<std::uint16_t>({3})}, {"componentType", kUnsignedShort}}},
      {"values", {{"bufferView", file.add_view<float>({1, 1, 0.5f})}}}};
  file.append("images", {{"bufferView", file.add_view(png_header())}, {"mimeType", "image/png"}});
  file.append("samplers", {{"minFilter", 9987}, {"wrapS", 33071}});
  file.append("textures", {{"source", 0}, {"sampler", 0}});
  file.append(
      "materials",
      {{"name", "m"},
       {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"metallicFactor", 0.5}}},
       {"normalTexture",
        {{"index", 0}, {"extensions", {{"KHR_texture_transform", {{"rotation", 0.5}, {"scale", {2, 2}}}}}}}},
       {"extensions",
        {{"KHR_materials_pbrSpecularGlossiness",
          {{"diffuseTexture", {{"index", 0}}}, {"glossinessFactor", 0.5}}}}}});
  file.add_mesh(
      {{"attributes", {{"POSITION", p}, {"NORMAL", n}, {"TANGENT", t}, {"TEXCOORD_0", uv}, {"COLOR_0", c}}},
       {"indices", i},
       {"material", 0},
       {"mode", 4}});
  file.append("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}});
  file.root["extensionsUsed"] = {"KHR_lights_punctual", "KHR_texture_transform"};
  file.root["extensions"]["KHR_lights_punctual"]["lights"] =
      json::array({{{"type", "spot"}, {"color", {1, 1, 1}}, {"spot", {{"outerConeAngle", 0.5}}}}});
  file.add_node({{"children", {1, 2}}, {"rotation", {0, 0, 0, 1}}});
  file.add_node({{"mesh", 0}, {"scale", {-1, 1, 1}}});
  file.add_node({{"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  file.root["scenes"] = json::array({{{"nodes", {0}}}});
  file.root["scene"] = 0;
  return file;
}

enum class Outcome { Scene, Error };

/// Anything but a Scene or a UserError fails the test (or crashes it, which the sanitizer builds are for).
Outcome outcome_of(const std::filesystem::path& path, std::string* message = nullptr) {
  try {
    // Small ceilings: a file that slips past a check is caught here by size, not by the machine's memory.
    const Scene scene =
        load_scene(path, {.vertices = 100000, .indices = 100000, .draws = 1000, .json_values = 100000});
    for (const Mesh& mesh : scene.meshes) {
      EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
      EXPECT_EQ(mesh.tangents.size(), mesh.positions.size());
      for (const std::uint32_t index : mesh.indices) EXPECT_LT(index, mesh.positions.size());
      EXPECT_LT(static_cast<std::size_t>(mesh.material), scene.materials.size());
    }
    return Outcome::Scene;
  } catch (const UserError& error) {
    if (message != nullptr) *message = error.what();
    EXPECT_THAT(error.place().file, HasSubstr(path.parent_path().string())) << error.what();
    for (const char c : std::string(error.what()))
      EXPECT_GE(static_cast<unsigned char>(c), 0x20u) << error.what();
    EXPECT_LT(std::string(error.what()).size(), 1000u);
    return Outcome::Error;
  } catch (const std::exception& other) {
    ADD_FAILURE() << "neither a scene nor a user error: " << other.what();
    return Outcome::Error;
  }
}

TEST(Hostile, TheUndamagedFileIsAScene) {
  const TempFolder folder;
  EXPECT_EQ(outcome_of(rich().write_glb(folder)), Outcome::Scene);
}

struct Damage {
  const char* name;
  std::function<void(GltfFile&)> apply;
  const char* message;  // part of the error
};

const std::vector<Damage>& damages() {
  static const std::vector<Damage> kDamages = {
      {"no asset", [](GltfFile& f) { f.root.erase("asset"); }, "/asset: is missing"},
      {"version 1", [](GltfFile& f) { f.root["asset"]["version"] = "1.0"; },
       "/asset/version: expected glTF 2.x"},
      {"version is a number", [](GltfFile& f) { f.root["asset"]["version"] = 2; },
       "/asset/version: expected a string, found 2"},
      {"top is an array",
       [](GltfFile& f) {
         f = GltfFile{json::array({1}), {}};
       },
       "expected a JSON object"},
      {"huge count", [](GltfFile& f) { f.root["accessors"][1]["count"] = 4000000000u; },
       "/accessors/1: 4000000000 elements end at byte"},
      {"count 2^63", [](GltfFile& f) { f.root["accessors"][1]["count"] = 9223372036854775808u; },
       "/accessors/1/count: expected an integer"},
      {"count 0", [](GltfFile& f) { f.root["accessors"][1]["count"] = 0; }, "/accessors/1/count"},
      {"count negative", [](GltfFile& f) { f.root["accessors"][1]["count"] = -4; },
       "/accessors/1/count: expected an integer from 1"},
      {"count fractional", [](GltfFile& f) { f.root["accessors"][1]["count"] = 1.5; }, "/accessors/1/count"},
      {"count is text", [](GltfFile& f) { f.root["accessors"][1]["count"] = "4"; }, "/accessors/1/count"},
      {"count missing", [](GltfFile& f) { f.root["accessors"][1].erase("count"); },
       "/accessors/1/count: is missing"},
      {"unknown component type", [](GltfFile& f) { f.root["accessors"][1]["componentType"] = 5130; },
       "/accessors/1/componentType: expected one of"},
      {"double components", [](GltfFile& f) { f.root["accessors"][1]["componentType"] = 5130; }, "5130"},
      {"unknown element type", [](GltfFile& f) { f.root["accessors"][1]["type"] = "VEC5"; },
       "/accessors/1/type: expected one of SCALAR"},
      {"accessor offset beyond view", [](GltfFile& f) { f.root["accessors"][1]["byteOffset"] = 1000; },
       "/accessors/1: 4 elements end at"},
      {"accessor offset near 2^53",
       [](GltfFile& f) { f.root["accessors"][1]["byteOffset"] = 9007199254740988u; }, "/accessors/1"},
      {"accessor offset negative", [](GltfFile& f) { f.root["accessors"][1]["byteOffset"] = -12; },
       "/accessors/1/byteOffset"},
      {"accessor offset unaligned", [](GltfFile& f) { f.root["accessors"][1]["byteOffset"] = 1; },
       "/accessors/1/byteOffset: expected a multiple of 4"},
      {"view index out of range", [](GltfFile& f) { f.root["accessors"][1]["bufferView"] = 99; },
       "/accessors/1/bufferView: expected an index"},
      {"view index negative", [](GltfFile& f) { f.root["accessors"][1]["bufferView"] = -1; },
       "/accessors/1/bufferView"},
      {"view beyond buffer", [](GltfFile& f) { f.root["bufferViews"][0]["byteLength"] = 100000; },
       "/bufferViews/0: bytes 0 to 100000 reach beyond"},
      {"view offset beyond buffer", [](GltfFile& f) { f.root["bufferViews"][0]["byteOffset"] = 100000; },
       "/bufferViews/0"},
      {"view offset negative", [](GltfFile& f) { f.root["bufferViews"][0]["byteOffset"] = -4; },
       "/bufferViews/0/byteOffset"},
      {"view length 0", [](GltfFile& f) { f.root["bufferViews"][0]["byteLength"] = 0; },
       "/bufferViews/0/byteLength"},
      {"huge stride", [](GltfFile& f) { f.root["bufferViews"][0]["byteStride"] = 2000000000; },
       "/bufferViews/0/byteStride: expected a multiple of 4"},
      {"odd stride", [](GltfFile& f) { f.root["bufferViews"][0]["byteStride"] = 13; },
       "/bufferViews/0/byteStride"},
      {"stride below element", [](GltfFile& f) { f.root["bufferViews"][0]["byteStride"] = 4; },
       "do not fit the byteStride 4"},
      {"view of no buffer", [](GltfFile& f) { f.root["bufferViews"][0]["buffer"] = 1; },
       "/bufferViews/0/buffer: expected an index into /buffers"},
      {"buffer longer than chunk",
       [](GltfFile& f) {
         f.root["buffers"] = json::array({{{"byteLength", 1000000}}});
       },
       "/buffers/0: expected 1000000 bytes, the BIN chunk has"},
      {"buffer length 0",
       [](GltfFile& f) {
         f.root["buffers"] = json::array({{{"byteLength", 0}}});
       },
       "/buffers/0/byteLength"},
      {"second buffer without bytes",
       [](GltfFile& f) {
         f.root["buffers"] = json::array({{{"byteLength", f.bin.size()}}, {{"byteLength", 4}}});
       },
       "/buffers/1: has no uri"},
      {"buffer data uri cut off",
       [](GltfFile& f) {
         f.root["buffers"] = json::array(
             {{{"byteLength", f.bin.size()}, {"uri", "data:application/octet-stream;base64,AAAA"}}});
       },
       "/buffers/0/uri: expected"},
      {"buffer data uri of a strange type",
       [](GltfFile& f) {
         f.root["buffers"] = json::array({{{"byteLength", f.bin.size()}, {"uri", "data:text/html,hello"}}});
       },
       "/buffers/0/uri"},
      {"no buffers", [](GltfFile& f) { f.root["buffers"] = json::array(); },
       "/bufferViews/0/buffer: expected an index into /buffers, which has no elements"},
      {"sparse index out of range",
       [](GltfFile& f) {
         f.root["accessors"][0]["sparse"]["indices"]["bufferView"] = f.add_view<std::uint16_t>({4});
       },
       "sparse index 0 names element 4, the accessor has 4"},
      {"sparse count above count", [](GltfFile& f) { f.root["accessors"][0]["sparse"]["count"] = 5; },
       "/accessors/0/sparse/count"},
      {"sparse count huge", [](GltfFile& f) { f.root["accessors"][0]["sparse"]["count"] = 4000000000u; },
       "/accessors/0/sparse/count"},
      {"sparse without values", [](GltfFile& f) { f.root["accessors"][0]["sparse"].erase("values"); },
       "/accessors/0/sparse/values: is missing"},
      {"sparse signed indices",
       [](GltfFile& f) { f.root["accessors"][0]["sparse"]["indices"]["componentType"] = kShort; },
       "/accessors/0/sparse/indices/componentType"},
      {"sparse values beyond view",
       [](GltfFile& f) { f.root["accessors"][0]["sparse"]["values"]["byteOffset"] = 4; },
       "/accessors/0/sparse/values"},
      {"index beyond vertices",
       [](GltfFile& f) {
         f.primitive()["indices"] = f.add_indices({0, 1, 4});
       },
       "/meshes/0/primitives/0/indices: index 2 names vertex 4, the primitive has 4"},
      {"restart index",
       [](GltfFile& f) {
         f.primitive()["indices"] = f.add_indices({0, 1, 65535});
       },
       "names vertex 65535"},
      {"float indices", [](GltfFile& f) { f.primitive()["indices"] = 0; },
       "/meshes/0/primitives/0/indices: expected unsigned scalars"},
      {"indices without bytes",
       [](GltfFile& f) {
         f.primitive()["indices"] =
             f.append("accessors", {{"componentType", kUnsignedInt}, {"count", 3}, {"type", "SCALAR"}});
       },
       "has no bufferView"},
      {"attribute of another count",
       [](GltfFile& f) {
         f.attributes()["NORMAL"] = f.add_vec3({0, 0, 1});
       },
       "attributes/NORMAL: has 1 elements, POSITION has 4"},
      {"attribute of another type", [](GltfFile& f) { f.attributes()["NORMAL"] = 2; },
       "attributes/NORMAL: expected VEC3"},
      {"attribute of integers",
       [](GltfFile& f) {
         f.attributes()["NORMAL"] = f.add_accessor<std::uint16_t>(std::vector<std::uint16_t>(16), "VEC3",
                                                                  kUnsignedShort, 4, false, 8);
       },
       "attributes/NORMAL: expected floats or normalized signed"},
      {"attribute index out of range", [](GltfFile& f) { f.attributes()["NORMAL"] = 77; },
       "/meshes/0/primitives/0/attributes/NORMAL"},
      {"attributes missing", [](GltfFile& f) { f.primitive().erase("attributes"); },
       "/meshes/0/primitives/0/attributes: is missing"},
      {"primitives missing", [](GltfFile& f) { f.root["meshes"][0].erase("primitives"); },
       "/meshes/0/primitives: is missing"},
      {"mode 7", [](GltfFile& f) { f.primitive()["mode"] = 7; }, "/meshes/0/primitives/0/mode"},
      {"material out of range", [](GltfFile& f) { f.primitive()["material"] = 1; },
       "/meshes/0/primitives/0/material"},
      {"texture out of range", [](GltfFile& f) { f.root["materials"][0]["normalTexture"]["index"] = 1; },
       "/materials/0/normalTexture/index"},
      {"texture without index", [](GltfFile& f) { f.root["materials"][0]["normalTexture"].erase("index"); },
       "/materials/0/normalTexture/index: is missing"},
      {"extension texture out of range",
       [](GltfFile& f) {
         f.root["materials"][0]["extensions"]["KHR_materials_pbrSpecularGlossiness"]["diffuseTexture"]
               ["index"] = 9;
       },
       "KHR_materials_pbrSpecularGlossiness/diffuseTexture/index"},
      {"image out of range", [](GltfFile& f) { f.root["textures"][0]["source"] = 1; }, "/textures/0/source"},
      {"sampler out of range", [](GltfFile& f) { f.root["textures"][0]["sampler"] = 1; },
       "/textures/0/sampler"},
      {"image view out of range", [](GltfFile& f) { f.root["images"][0]["bufferView"] = 1000; },
       "/images/0/bufferView"},
      {"image of nothing", [](GltfFile& f) { f.root["images"][0].erase("bufferView"); },
       "/images/0: expected exactly one of"},
      {"image of two sources", [](GltfFile& f) { f.root["images"][0]["uri"] = "a.png"; },
       "/images/0: expected exactly one of"},
      {"image header cut off",
       [](GltfFile& f) {
         Bytes cut = png_header();
         cut.resize(16);
         f.root["images"][0]["bufferView"] = f.add_view(cut);
       },
       "/images/0: its header is cut off"},
      {"strange filter", [](GltfFile& f) { f.root["samplers"][0]["minFilter"] = 1; },
       "/samplers/0/minFilter"},
      {"factor of three",
       [](GltfFile& f) {
         f.root["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1};
       },
       "expected an array of 4 numbers, found an array of 3"},
      {"factor of text",
       [](GltfFile& f) {
         f.root["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, "x", 1};
       },
       "baseColorFactor/2: expected a number"},
      {"factor null",
       [](GltfFile& f) { f.root["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = nullptr; },
       "metallicFactor: expected a number, found null"},
      {"node mesh out of range", [](GltfFile& f) { f.root["nodes"][1]["mesh"] = 5; }, "/nodes/1/mesh"},
      {"node child out of range",
       [](GltfFile& f) {
         f.root["nodes"][0]["children"] = {1, 9};
       },
       "/nodes/0/children/1"},
      {"node cycle", [](GltfFile& f) { f.root["nodes"][1]["children"] = {0}; }, "/nodes/0: is reached twice"},
      {"node is its own child", [](GltfFile& f) { f.root["nodes"][0]["children"] = {0}; },
       "/nodes/0: is reached twice"},
      {"node with two parents", [](GltfFile& f) { f.root["nodes"][1]["children"] = {2}; },
       "/nodes/2: is reached twice"},
      {"nothing but a cycle",
       [](GltfFile& f) {
         f.root.erase("scenes");
         f.root.erase("scene");
         f.root["nodes"] = json::array({{{"children", {1}}}, {{"children", {0}}}});
       },
       "is reached twice"},
      {"matrix of 15", [](GltfFile& f) { f.root["nodes"][1]["matrix"] = std::vector<double>(15, 1.0); },
       "/nodes/1/matrix: expected an array of 16"},
      {"scene out of range", [](GltfFile& f) { f.root["scene"] = 3; },
       "/scene: expected an index into /scenes"},
      {"scene root out of range", [](GltfFile& f) { f.root["scenes"][0]["nodes"] = {4}; },
       "/scenes/0/nodes/0"},
      {"camera out of range", [](GltfFile& f) { f.root["nodes"][2]["camera"] = 3; }, "/nodes/2/camera"},
      {"camera without lens", [](GltfFile& f) { f.root["cameras"][0].erase("perspective"); },
       "camera description not found"},
      {"light out of range",
       [](GltfFile& f) { f.root["nodes"][2]["extensions"]["KHR_lights_punctual"]["light"] = 1; },
       "/nodes/2/extensions/KHR_lights_punctual/light"},
      {"light of no type",
       [](GltfFile& f) { f.root["extensions"]["KHR_lights_punctual"]["lights"][0].erase("type"); },
       "lights/0/type: is missing"},
      {"nodes is an object",
       [](GltfFile& f) {
         f.root["nodes"] = {{"a", 1}};
       },
       "/nodes: expected an array"},
      {"mesh is a number", [](GltfFile& f) { f.root["meshes"] = {5}; },
       "/meshes/0: expected an object, found 5"},
      {"deep nodes",
       [](GltfFile& f) {
         f.root["nodes"] = json::array();
         for (int i = 0; i < 3000; ++i) f.add_node({{"children", {i + 1}}});
         f.add_node(json::object());
       },
       "nested more than 512 deep"},
      {"json nested deep",
       [](GltfFile& f) {
         json deep = 1;
         for (int i = 0; i < 200; ++i) deep = json::array({deep});
         f.root["extras"] = deep;
       },
       "nested more than 128 levels deep"},
      {"json of very many values", [](GltfFile& f) { f.root["extras"] = std::vector<int>(200000, 7); },
       "more than 100000 values"},
      {"many instances",
       [](GltfFile& f) {
         f.root["scenes"][0]["nodes"] = json::array();
         for (int i = 3; i < 2000; ++i) {
           f.add_node({{"mesh", 0}});
           f.root["scenes"][0]["nodes"].push_back(i);
         }
       },
       "more than 1000 primitives"},
  };
  return kDamages;
}

TEST(Hostile, EveryDamageIsOneErrorAtItsPlace) {
  const TempFolder folder;
  ASSERT_GE(damages().size(), 40u);
  for (const Damage& damage : damages()) {
    GltfFile file = rich();
    damage.apply(file);
    std::string message;
    EXPECT_EQ(outcome_of(file.write_glb(folder), &message), Outcome::Error) << damage.name;
    EXPECT_THAT(message, HasSubstr(damage.message)) << damage.name;
  }
}

TEST(Hostile, ContainerHeadersAreChecked) {
  const TempFolder folder;
  const Bytes good = rich().glb();
  const auto with_u32 = [&](std::size_t at, std::uint32_t value) {
    Bytes bytes = good;
    for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
    std::string message;
    EXPECT_EQ(outcome_of(folder.write("a.glb", bytes), &message), Outcome::Error);
    return message;
  };
  EXPECT_THAT(with_u32(4, 1), HasSubstr("expected glb version 2, found 1"));
  EXPECT_THAT(with_u32(8, 0xffffffff), HasSubstr("promises 4294967295 bytes"));
  EXPECT_THAT(with_u32(12, 0xfffffff0), HasSubstr("JSON chunk ends at byte"));
  EXPECT_THAT(with_u32(12, 0), HasSubstr("not valid JSON"));
  EXPECT_THAT(with_u32(16, 0x12345678), HasSubstr("first chunk"));
  const std::uint32_t json_bytes =
      good[12] | static_cast<std::uint32_t>(good[13]) << 8 | static_cast<std::uint32_t>(good[14]) << 16;
  EXPECT_THAT(with_u32(20 + json_bytes, 0xfffffff0), HasSubstr("BIN chunk ends at byte"));
  EXPECT_THAT(with_u32(24 + json_bytes, 0x12345678), HasSubstr("the BIN chunk has 0"));
}

TEST(Hostile, CutOffAnywhereIsAnError) {
  const TempFolder folder;
  const Bytes good = rich().glb();
  for (std::size_t part = 0; part < 50; ++part) {
    Bytes cut = good;
    cut.resize(good.size() * part / 50);
    EXPECT_EQ(outcome_of(folder.write("cut.glb", cut)), Outcome::Error) << part;
  }
  // The same for the text form, where a cut can only break the syntax.
  const std::string text = rich().root.dump();
  for (std::size_t part = 0; part < 50; ++part)
    EXPECT_EQ(outcome_of(folder.write("cut.gltf", text.substr(0, text.size() * part / 50))), Outcome::Error)
        << part;
}

TEST(Hostile, FlippedBytesEndInASceneOrAnError) {
  const TempFolder folder;
  const Bytes good = rich().glb();
  std::mt19937 random(1337);
  int scenes = 0, errors = 0;
  for (int round = 0; round < 4000; ++round) {
    Bytes bytes = good;
    const int flips = 1 + static_cast<int>(random() % 4);
    for (int i = 0; i < flips; ++i)
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
    (outcome_of(folder.write("flip.glb", bytes)) == Outcome::Scene ? scenes : errors) += 1;
    if (HasFailure()) FAIL() << "round " << round;
  }
  EXPECT_GT(scenes, 200) << "the damage never spares anything: the test shows little";
  EXPECT_GT(errors, 200);
}

TEST(Hostile, MutatedNumbersEndInASceneOrAnError) {
  const TempFolder folder;
  const std::string good = rich().root.dump();
  std::mt19937 random(99);
  const std::vector<std::string> values = {
      "0",     "1",          "-1",         "4",          "255",
      "65536", "2147483647", "2147483648", "4294967295", "9007199254740992",
      "1e308", "1e400",      "-0.0",       "0.5",        "true",
      "null",  "\"\"",       "[]",         "{}",         "[[[]]]",
      "1e-320"};
  int scenes = 0;
  for (int round = 0; round < 3000; ++round) {
    // Replace one number of the JSON by one of the values.
    std::vector<std::pair<std::size_t, std::size_t>> numbers;
    for (std::size_t i = 1; i < good.size(); ++i) {
      if (std::string(":,[").find(good[i - 1]) == std::string::npos ||
          std::isdigit(static_cast<unsigned char>(good[i])) == 0)
        continue;
      std::size_t end = i;
      while (std::isdigit(static_cast<unsigned char>(good[end])) != 0 || good[end] == '.') ++end;
      numbers.emplace_back(i, end);
    }
    ASSERT_GT(numbers.size(), 50u);
    const auto [begin, end] = numbers[random() % numbers.size()];
    GltfFile file = rich();
    const std::string text = good.substr(0, begin) + values[random() % values.size()] + good.substr(end);
    json mutated = json::parse(text, nullptr, false);
    if (mutated.is_discarded()) {
      EXPECT_EQ(outcome_of(folder.write("number.gltf", text)), Outcome::Error);
      continue;
    }
    file.root = mutated;
    scenes += outcome_of(file.write_glb(folder)) == Outcome::Scene ? 1 : 0;
    if (HasFailure()) FAIL() << "round " << round << ": " << text;
  }
  EXPECT_GT(scenes, 100);
}

TEST(Hostile, NamesThatAreNotUtf8AreASyntaxError) {
  const TempFolder folder;
  std::string text = rich().root.dump();
  text.insert(text.find("\"m\"") + 1, "\xff\xfe");
  std::string message;
  EXPECT_EQ(outcome_of(folder.write("name.gltf", text), &message), Outcome::Error);
  EXPECT_THAT(message, HasSubstr("not valid JSON at byte"));
}

TEST(Hostile, ControlCharactersInNamesDoNotReachMessages) {
  const TempFolder folder;
  GltfFile file = rich();
  file.root["nodes"][1]["name"] = "evil\x1b[31m\nname" + std::string(500, 'x');
  file.root["nodes"][1]["scale"] = {0, 1, 1};
  file.attributes()["_\x1b[2J"] = 1000;
  std::string message;
  EXPECT_EQ(outcome_of(file.write_glb(folder), &message), Outcome::Error);
  file.attributes().erase("_\x1b[2J");
  const Scene scene = load_scene(file.write_glb(folder));
  for (const std::string& warning : scene.warnings) {
    EXPECT_LT(warning.size(), 300u);
    for (const char c : warning) EXPECT_GE(static_cast<unsigned char>(c), 0x20u);
  }
  ASSERT_FALSE(scene.warnings.empty());
}

TEST(Hostile, WarningsDoNotGrowWithoutEnd) {
  const TempFolder folder;
  GltfFile file = rich();
  for (int i = 0; i < 900; ++i) {
    file.root["nodes"][0]["children"].push_back(file.add_node({{"mesh", 0}, {"scale", {0, 1, 1}}}));
  }
  const Scene scene = load_scene(file.write_glb(folder));
  EXPECT_LE(scene.warnings.size(), 201u);
  EXPECT_THAT(scene.warnings.back(), HasSubstr("more warnings"));
}

}  // namespace
}  // namespace aluminate::scenes::test
