// Normals and tangents from positions, uv and triangles; pure functions in binary64.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace aluminate::scenes::gltf {

/// Per vertex, the sum of cross(b - a, c - a) over its triangles (twice the area times the face normal); not
/// normalised. Triangles with a non-finite corner are left out.
std::vector<glm::dvec3> summed_face_normals(std::span<const glm::dvec3> positions,
                                            std::span<const std::uint32_t> indices);

/// Per vertex, the sums of the triangles' position gradients along u and along v [Lengyel01]; triangles whose
/// uv area is below 1e-20 and non-finite ones are left out.
struct UvGradients {
  std::vector<glm::dvec3> along_u, along_v;
};
UvGradients summed_uv_gradients(std::span<const glm::dvec3> positions, std::span<const glm::dvec2> uv,
                                std::span<const std::uint32_t> indices);

/// Unit vector, or zero when v is zero or not finite. No overflow or underflow for any finite v.
glm::dvec3 unit_or_zero(const glm::dvec3& v);

/// Any unit vector orthogonal to the unit vector n; continuous except at one direction [Duff17].
glm::dvec3 any_tangent(const glm::dvec3& n);

/// How directions follow a linear map: normals by the cofactors (the inverse transpose up to a positive
/// factor, defined for singular maps too), tangents by the map itself. Both are scaled to the map's largest
/// entry, so only directions count.
struct DirectionMap {
  glm::dmat3 tangents{1}, normals{1};
  bool mirrors = false;   // negative determinant
  bool singular = false;  // zero determinant
};
DirectionMap direction_map(const glm::dmat3& linear);

}  // namespace aluminate::scenes::gltf
