#include "scenes/gltf/accessor.hpp"

#include "platform/host/error.hpp"

#include <algorithm>
#include <cstring>

#include "scenes/gltf/tinygltf.hpp"

namespace aluminate::scenes::gltf {
namespace {

/// Elements in memory: element i starts at data + i * stride.
struct Elements {
  const unsigned char* data = nullptr;
  std::size_t stride = 0;
};

const tinygltf::Accessor& accessor_at(const Document& document, int index) {
  const auto& all = document.model->accessors;
  ALU_CHECK(index >= 0 && static_cast<std::size_t>(index) < all.size(), "accessor {} of {}", index,
            all.size());
  return all[static_cast<std::size_t>(index)];
}

std::size_t component_bytes(int component_type) {
  return static_cast<std::size_t>(
      tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(component_type)));
}

Elements elements_of(const Document& document, int view_index, std::size_t offset, std::size_t element_bytes,
                     std::size_t count, bool may_interleave) {
  const auto& view = document.model->bufferViews.at(static_cast<std::size_t>(view_index));
  const auto& bytes = document.model->buffers.at(static_cast<std::size_t>(view.buffer)).data;
  Elements elements;
  elements.stride = may_interleave && view.byteStride != 0 ? view.byteStride : element_bytes;
  const std::size_t end = offset + elements.stride * (count - 1) + element_bytes;  // bounded by check_layout
  ALU_CHECK(end <= view.byteLength && view.byteOffset + view.byteLength <= bytes.size(),
            "{} elements end at {} of {}", count, end, view.byteLength);
  elements.data = bytes.data() + view.byteOffset + offset;
  return elements;
}

template <typename T>
T load(const unsigned char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

/// One component to a float. Division, not a reciprocal: 255/255 must be exactly 1.
float to_float(const unsigned char* at, int component_type, bool normalized) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
      const auto c = static_cast<float>(load<std::int8_t>(at));
      return normalized ? std::max(c / 127.0f, -1.0f) : c;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: {
      const auto c = static_cast<float>(load<std::uint8_t>(at));
      return normalized ? c / 255.0f : c;
    }
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
      const auto c = static_cast<float>(load<std::int16_t>(at));
      return normalized ? std::max(c / 32767.0f, -1.0f) : c;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: {
      const auto c = static_cast<float>(load<std::uint16_t>(at));
      return normalized ? c / 65535.0f : c;
    }
    default:
      return load<float>(at);
  }
}

std::uint32_t to_index(const unsigned char* at, int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return load<std::uint8_t>(at);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load<std::uint16_t>(at);
    default:
      return load<std::uint32_t>(at);
  }
}

bool storage_allows(Storage storage, int component_type, bool normalized) {
  if (component_type == TINYGLTF_COMPONENT_TYPE_FLOAT) return true;
  const bool is_signed =
      component_type == TINYGLTF_COMPONENT_TYPE_BYTE || component_type == TINYGLTF_COMPONENT_TYPE_SHORT;
  const bool is_unsigned = component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                           component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
  switch (storage) {
    case Storage::Float:
      return false;
    case Storage::FloatOrUnorm:
      return is_unsigned && normalized;
    case Storage::FloatOrSnorm:
      return is_signed && normalized;
    case Storage::Quantised:
      return is_signed || is_unsigned;
  }
  return false;
}

const char* storage_text(Storage storage) {
  switch (storage) {
    case Storage::Float:
      return "floats";
    case Storage::FloatOrUnorm:
      return "floats or normalized unsigned bytes or shorts";
    case Storage::FloatOrSnorm:
      return "floats or normalized signed bytes or shorts";
    case Storage::Quantised:
      return "floats, bytes or shorts";
  }
  return "";
}

/// Calls replace(element, bytes of the new value) for every sparse entry.
template <typename Replace>
void for_each_sparse(const Document& document, const tinygltf::Accessor& accessor, std::size_t element_bytes,
                     const std::string& place, const Replace& replace) {
  if (!accessor.sparse.isSparse) return;
  const auto& sparse = accessor.sparse;
  const auto count = static_cast<std::size_t>(sparse.count);
  const Elements indices =
      elements_of(document, sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset),
                  component_bytes(sparse.indices.componentType), count, false);
  const Elements values =
      elements_of(document, sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset),
                  element_bytes, count, false);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t index = to_index(indices.data + i * indices.stride, sparse.indices.componentType);
    if (index >= accessor.count)
      document.fail(place, fmt::format("sparse index {} names element {}, the accessor has {}", i, index,
                                       accessor.count));
    replace(index, values.data + i * values.stride);
  }
}

}  // namespace

std::uint64_t accessor_count(const Document& document, int accessor) {
  return accessor_at(document, accessor).count;
}

int accessor_components(const Document& document, int accessor) {
  return tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor_at(document, accessor).type));
}

std::vector<float> read_floats(const Document& document, int accessor_index, int components, Storage storage,
                               const std::string& place) {
  const tinygltf::Accessor& accessor = accessor_at(document, accessor_index);
  const int type = components == 1 ? TINYGLTF_TYPE_SCALAR : components;  // TINYGLTF_TYPE_VEC2..4 are 2..4
  static_assert(TINYGLTF_TYPE_VEC2 == 2 && TINYGLTF_TYPE_VEC3 == 3 && TINYGLTF_TYPE_VEC4 == 4);
  if (accessor.type != type)
    document.fail(place, fmt::format("expected VEC{} elements, /accessors/{} has {} components", components,
                                     accessor_index, accessor_components(document, accessor_index)));
  if (!storage_allows(storage, accessor.componentType, accessor.normalized))
    document.fail(place, fmt::format("expected {}, /accessors/{} has component type {}{}",
                                     storage_text(storage), accessor_index, accessor.componentType,
                                     accessor.normalized ? ", normalized" : ""));
  const std::size_t width = static_cast<std::size_t>(components),
                    part = component_bytes(accessor.componentType);
  std::vector<float> out(accessor.count * width,
                         0.0f);  // without a buffer view the elements are zero [glTF2 3.6.2.3]
  if (accessor.bufferView >= 0) {
    const Elements elements =
        elements_of(document, accessor.bufferView, accessor.byteOffset, part * width, accessor.count, true);
    for (std::size_t i = 0; i < accessor.count; ++i)
      for (std::size_t c = 0; c < width; ++c)
        out[i * width + c] = to_float(elements.data + i * elements.stride + c * part, accessor.componentType,
                                      accessor.normalized);
  }
  for_each_sparse(
      document, accessor, part * width, place, [&](std::size_t element, const unsigned char* bytes) {
        for (std::size_t c = 0; c < width; ++c)
          out[element * width + c] = to_float(bytes + c * part, accessor.componentType, accessor.normalized);
      });
  return out;
}

std::vector<std::uint32_t> read_indices(const Document& document, int accessor_index, std::uint64_t end,
                                        const std::string& place) {
  const tinygltf::Accessor& accessor = accessor_at(document, accessor_index);
  const std::size_t bytes = component_bytes(accessor.componentType);
  const Elements elements =
      elements_of(document, accessor.bufferView, accessor.byteOffset, bytes, accessor.count, true);
  std::vector<std::uint32_t> out(accessor.count);
  for (std::size_t i = 0; i < accessor.count; ++i)
    out[i] = to_index(elements.data + i * elements.stride, accessor.componentType);
  for_each_sparse(document, accessor, bytes, place, [&](std::size_t element, const unsigned char* at) {
    out[element] = to_index(at, accessor.componentType);
  });
  for (std::size_t i = 0; i < out.size(); ++i)
    if (out[i] >= end)
      document.fail(place, fmt::format("index {} names vertex {}, the primitive has {}", i, out[i], end));
  return out;
}

}  // namespace aluminate::scenes::gltf
