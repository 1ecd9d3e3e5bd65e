#include "scenes/gltf/layout.hpp"

#include "platform/host/error.hpp"

#include <cstdint>
#include <nlohmann/json.hpp>

namespace aluminate::scenes::gltf {
namespace {

using nlohmann::json;
using u64 = std::uint64_t;

// Every integer here is below 2^53 (check_schema), a stride below 2^8, an element at most 64 bytes: count *
// stride stays below 2^61 and a sum of two such offsets below 2^62.
constexpr u64 kLargestStride = 252;  // [glTF2 5.11 bufferView.byteStride]
static_assert((u64{1} << 53) * kLargestStride + 2 * (u64{1} << 53) < (u64{1} << 62));

u64 component_bytes(u64 component_type) {
  switch (component_type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    default:
      return 4;
  }
}

u64 component_count(const std::string& type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4" || type == "MAT2") return 4;
  return type == "MAT3" ? 9 : 16;
}

class Layout {
 public:
  Layout(const json& root, const std::string& file) : root_(root), file_(file) {}

  void run() const {
    each("bufferViews", [&](const json& view, const std::string& path) { check_view(view, path); });
    each("accessors", [&](const json& accessor, const std::string& path) { check_accessor(accessor, path); });
    each("images", [&](const json& image, const std::string& path) {
      if (image.contains("uri") == image.contains("bufferView"))
        fail(path, "expected exactly one of uri and bufferView");
    });
    each("meshes", [&](const json& mesh, const std::string& path) {
      const json& primitives = mesh.at("primitives");
      for (std::size_t i = 0; i < primitives.size(); ++i)
        if (primitives[i].contains("indices"))
          check_indices(primitives[i].at("indices"), path + "/primitives/" + std::to_string(i));
    });
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& what) const {
    throw UserError(SourcePlace{file_}, path + ": " + what);
  }

  template <typename Action>
  void each(const char* array, const Action& action) const {
    const auto found = root_.find(array);
    if (found == root_.end()) return;
    for (std::size_t i = 0; i < found->size(); ++i) action((*found)[i], fmt::format("/{}/{}", array, i));
  }

  void check_view(const json& view, const std::string& path) const {
    const u64 buffer = view.at("buffer").get<u64>();
    const u64 offset = view.value("byteOffset", u64{0}), length = view.at("byteLength").get<u64>();
    const u64 available = root_.at("buffers").at(buffer).at("byteLength").get<u64>();
    if (offset + length > available)
      fail(path, fmt::format("bytes {} to {} reach beyond /buffers/{}, which has {} bytes", offset,
                             offset + length, buffer, available));
    const u64 stride = view.value("byteStride", u64{0});
    if (stride > kLargestStride || stride % 4 != 0)
      fail(path + "/byteStride",
           fmt::format("expected a multiple of 4 from 4 to {}, found {}", kLargestStride, stride));
  }

  /// `count` elements of `bytes` at `offset` in a view, `stride` apart.
  void check_span(u64 view_index, u64 offset, u64 count, u64 stride, u64 bytes,
                  const std::string& path) const {
    const u64 available = root_.at("bufferViews").at(view_index).at("byteLength").get<u64>();
    const u64 end = offset + stride * (count - 1) + bytes;  // count >= 1
    if (end > available)
      fail(path, fmt::format("{} elements end at byte {}, beyond /bufferViews/{}, which has {} bytes", count,
                             end, view_index, available));
  }

  void check_accessor(const json& accessor, const std::string& path) const {
    const u64 component = component_bytes(accessor.at("componentType").get<u64>());
    const u64 bytes = component * component_count(accessor.at("type").get<std::string>());
    const u64 count = accessor.at("count").get<u64>(), offset = accessor.value("byteOffset", u64{0});
    if (offset % component != 0)
      fail(path + "/byteOffset", fmt::format("expected a multiple of {}, found {}", component, offset));
    if (accessor.contains("bufferView")) {
      const u64 view = accessor.at("bufferView").get<u64>();
      const u64 given = root_.at("bufferViews").at(view).value("byteStride", u64{0});
      if (given != 0 && given < bytes)
        fail(path, fmt::format("elements of {} bytes do not fit the byteStride {} of /bufferViews/{}", bytes,
                               given, view));
      check_span(view, offset, count, given != 0 ? given : bytes, bytes, path);
    }
    if (!accessor.contains("sparse")) return;
    const json& sparse = accessor.at("sparse");
    const u64 replaced = sparse.at("count").get<u64>();
    if (replaced > count)
      fail(path + "/sparse/count",
           fmt::format("expected at most the accessor's count {}, found {}", count, replaced));
    const json &indices = sparse.at("indices"), &values = sparse.at("values");
    const u64 index_bytes = component_bytes(indices.at("componentType").get<u64>());
    check_span(indices.at("bufferView").get<u64>(), indices.value("byteOffset", u64{0}), replaced,
               index_bytes, index_bytes, path + "/sparse/indices");
    check_span(values.at("bufferView").get<u64>(), values.value("byteOffset", u64{0}), replaced, bytes, bytes,
               path + "/sparse/values");
  }

  void check_indices(const json& index, const std::string& primitive_path) const {
    const json& accessor = root_.at("accessors").at(index.get<u64>());
    const u64 type = accessor.at("componentType").get<u64>();
    if (accessor.at("type") != "SCALAR" || (type != 5121 && type != 5123 && type != 5125))
      fail(primitive_path + "/indices",
           fmt::format("expected unsigned scalars, found {} of component type {}",
                       accessor.at("type").get<std::string>(), type));
    if (!accessor.contains("bufferView"))
      fail(primitive_path + "/indices", fmt::format("/accessors/{} has no bufferView", index.get<u64>()));
  }

  const json& root_;
  const std::string& file_;
};

}  // namespace

void check_layout(const nlohmann::json& root, const std::string& file) { Layout(root, file).run(); }

}  // namespace aluminate::scenes::gltf
