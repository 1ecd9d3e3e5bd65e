// Typed reading of accessors whose ranges check_layout has verified: any component type, normalised or not,
// any stride, sparse or not, to floats or indices. Never reads a byte outside the accessor's buffer views.
#pragma once

#include "scenes/gltf/document.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace aluminate::scenes::gltf {

enum class Storage : std::uint8_t {
  Float,         // float only
  FloatOrUnorm,  // float, or normalised unsigned byte / short (COLOR_n, and TEXCOORD_n of plain glTF)
  FloatOrSnorm,  // float, or normalised signed byte / short (NORMAL, TANGENT under KHR_mesh_quantization)
  Quantised,     // float, or any byte / short, normalised or not (POSITION, TEXCOORD_n under
                 // KHR_mesh_quantization)
};

/// Number of elements; no bytes are read.
std::uint64_t accessor_count(const Document& document, int accessor);

/// Components of a VECn accessor: 1..4.
int accessor_components(const Document& document, int accessor);

/// count * components floats, element by element. `place` names the use in errors, such as
/// "/meshes/0/primitives/1/attributes/NORMAL". Throws UserError when the type is not VEC<components> or not
/// of `storage`. Normalised integers follow [glTF2 3.11]: unsigned c / (2^n - 1), signed max(c / (2^(n-1) -
/// 1), -1).
std::vector<float> read_floats(const Document& document, int accessor, int components, Storage storage,
                               const std::string& place);

/// Unsigned scalars, each below `end`; the first one that is not is a UserError. The primitive-restart value
/// (all ones) is refused too [glTF2 3.7.2.1].
std::vector<std::uint32_t> read_indices(const Document& document, int accessor, std::uint64_t end,
                                        const std::string& place);

}  // namespace aluminate::scenes::gltf
