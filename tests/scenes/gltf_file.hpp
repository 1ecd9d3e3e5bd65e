// A glTF file built in memory by a test, property by property, and written to a folder of the test's own.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace aluminate::scenes::test {

using nlohmann::json;
using Bytes = std::vector<std::uint8_t>;

constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125,
              kFloat = 5126;

/// A fresh folder, removed at the end of the test. In memory where the system has such a place: the hostile
/// tests write thousands of files, which a busy disk makes them wait for.
class TempFolder {
 public:
  TempFolder() {
    static int next = 0;
    const std::filesystem::path in_memory = "/dev/shm";
    const bool is_usable = ::access(in_memory.c_str(), W_OK | X_OK) == 0;
    path_ = (is_usable ? in_memory : std::filesystem::path(testing::TempDir())) /
            ("aluminate_scenes_" + std::to_string(::getpid()) + "_" + std::to_string(next++));
    std::filesystem::create_directories(path_);
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  std::filesystem::path write(const std::string& name, const Bytes& bytes) const {
    const auto file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::filesystem::remove(file);  // some file systems flush a file that is truncated and written again
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return file;
  }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    return write(name, Bytes(text.begin(), text.end()));
  }

 private:
  std::filesystem::path path_;
};

struct GltfFile {
  json root = {{"asset", {{"version", "2.0"}}}};
  Bytes bin;

  template <typename T>
  int add_view(const std::vector<T>& values, int stride = 0) {
    while (bin.size() % 4 != 0) bin.push_back(0);
    const std::size_t offset = bin.size();
    bin.resize(offset + values.size() * sizeof(T));
    if (!values.empty()) std::memcpy(bin.data() + offset, values.data(), values.size() * sizeof(T));
    json view = {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", values.size() * sizeof(T)}};
    if (stride != 0) view["byteStride"] = stride;
    return append("bufferViews", view);
  }

  template <typename T>
  int add_accessor(const std::vector<T>& values, const char* type, int component_type, std::size_t count,
                   bool normalized = false, int stride = 0) {
    json accessor = {{"bufferView", add_view(values, stride)},
                     {"componentType", component_type},
                     {"count", count},
                     {"type", type}};
    if (normalized) accessor["normalized"] = true;
    return append("accessors", accessor);
  }
  int add_vec3(const std::vector<float>& values) {
    return add_accessor(values, "VEC3", kFloat, values.size() / 3);
  }
  int add_vec2(const std::vector<float>& values) {
    return add_accessor(values, "VEC2", kFloat, values.size() / 2);
  }
  int add_vec4(const std::vector<float>& values) {
    return add_accessor(values, "VEC4", kFloat, values.size() / 4);
  }
  int add_indices(const std::vector<std::uint16_t>& values) {
    return add_accessor(values, "SCALAR", kUnsignedShort, values.size());
  }

  int append(const char* array, const json& value) {
    root[array].push_back(value);
    return static_cast<int>(root[array].size()) - 1;
  }

  int add_mesh(const json& primitive) { return append("meshes", {{"primitives", json::array({primitive})}}); }
  int add_node(const json& node) { return append("nodes", node); }

  /// The smallest scene: one triangle (0,0,0) (1,0,0) (0,1,0) in mesh 0 at node 0; accessor 0 holds its
  /// positions.
  static GltfFile triangle() {
    GltfFile file;
    const int positions = file.add_vec3({0, 0, 0, 1, 0, 0, 0, 1, 0});
    file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", positions}}}})}});
    return file;
  }

  json& primitive() { return root["meshes"][0]["primitives"][0]; }
  json& attributes() { return primitive()["attributes"]; }

  Bytes glb() const {
    json document = root;
    if (!bin.empty() && !document.contains("buffers"))
      document["buffers"] = json::array({{{"byteLength", bin.size()}}});
    std::string text = document.dump();
    while (text.size() % 4 != 0) text += ' ';
    Bytes padded = bin;
    while (padded.size() % 4 != 0) padded.push_back(0);
    Bytes out;
    const auto u32 = [&out](std::size_t value) {
      for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    };
    u32(0x46546C67);
    u32(2);
    u32(20 + text.size() + (padded.empty() ? 0 : 8 + padded.size()));
    u32(text.size());
    u32(0x4E4F534A);
    out.insert(out.end(), text.begin(), text.end());
    if (!padded.empty()) {
      u32(padded.size());
      u32(0x004E4942);
      out.insert(out.end(), padded.begin(), padded.end());
    }
    return out;
  }

  /// name.gltf beside name.bin.
  std::filesystem::path write_gltf(const TempFolder& folder, const std::string& name = "scene") const {
    json document = root;
    if (!bin.empty() && !document.contains("buffers")) {
      document["buffers"] = json::array({{{"byteLength", bin.size()}, {"uri", name + ".bin"}}});
      folder.write(name + ".bin", bin);
    }
    return folder.write(name + ".gltf", document.dump(1));
  }
  std::filesystem::path write_glb(const TempFolder& folder, const std::string& name = "scene") const {
    return folder.write(name + ".glb", glb());
  }
};

inline std::string base64(const Bytes& bytes) {
  static const char* const kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = static_cast<std::uint32_t>(bytes[i]) << 16;
    if (i + 1 < bytes.size()) word |= static_cast<std::uint32_t>(bytes[i + 1]) << 8;
    if (i + 2 < bytes.size()) word |= bytes[i + 2];
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : kDigits[word >> (18 - 6 * k) & 63];
  }
  return out;
}

/// The first bytes of a PNG of 2 x 3 px: enough for the loader, which decodes nothing.
inline Bytes png_header() {
  return {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 0, 0, 13, 'I', 'H', 'D',
          'R',  0,   0,   0,   2,    0,    0,    0,    3, 8, 6, 0,  0,   0};
}

}  // namespace aluminate::scenes::test
