#include "scenes/gltf/shading_frame.hpp"

#include <algorithm>
#include <cmath>

namespace aluminate::scenes::gltf {
namespace {

bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

std::vector<glm::dvec3> summed_face_normals(std::span<const glm::dvec3> positions,
                                            std::span<const std::uint32_t> indices) {
  std::vector<glm::dvec3> sums(positions.size(), glm::dvec3(0));
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    const glm::dvec3& a = positions[indices[i]];
    const glm::dvec3 face = glm::cross(positions[indices[i + 1]] - a, positions[indices[i + 2]] - a);
    if (!finite(face)) continue;
    for (std::size_t k = 0; k < 3; ++k) sums[indices[i + k]] += face;
  }
  return sums;
}

UvGradients summed_uv_gradients(std::span<const glm::dvec3> positions, std::span<const glm::dvec2> uv,
                                std::span<const std::uint32_t> indices) {
  UvGradients sums{std::vector<glm::dvec3>(positions.size(), glm::dvec3(0)),
                   std::vector<glm::dvec3>(positions.size(), glm::dvec3(0))};
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    const std::uint32_t a = indices[i], b = indices[i + 1], c = indices[i + 2];
    const glm::dvec3 e1 = positions[b] - positions[a], e2 = positions[c] - positions[a];
    const glm::dvec2 d1 = uv[b] - uv[a], d2 = uv[c] - uv[a];
    const double area = d1.x * d2.y - d1.y * d2.x;
    if (!(std::fabs(area) >= 1e-20)) continue;
    const glm::dvec3 u = (e1 * d2.y - e2 * d1.y) / area, v = (e2 * d1.x - e1 * d2.x) / area;
    if (!finite(u) || !finite(v)) continue;
    for (const std::uint32_t corner : {a, b, c}) {
      sums.along_u[corner] += u;
      sums.along_v[corner] += v;
    }
  }
  return sums;
}

glm::dvec3 unit_or_zero(const glm::dvec3& v) {
  const double longest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  if (!(longest > 0) || !finite(v)) return glm::dvec3(0);
  const glm::dvec3 scaled = v / longest;
  return scaled / std::sqrt(glm::dot(scaled, scaled));
}

glm::dvec3 any_tangent(const glm::dvec3& n) {
  const double sign = std::copysign(1.0, n.z), a = -1 / (sign + n.z);
  return unit_or_zero(glm::dvec3(1 + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x));
}

DirectionMap direction_map(const glm::dmat3& linear) {
  DirectionMap map;
  double largest = 0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) largest = std::max(largest, std::fabs(linear[c][r]));
  if (!(largest > 0) || !std::isfinite(largest)) {
    map.singular = true;
    return map;
  }
  const glm::dmat3 m = linear / largest;
  const double determinant = glm::dot(glm::cross(m[0], m[1]), m[2]);
  map.tangents = m;
  map.normals = glm::dmat3(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  map.mirrors = determinant < 0;
  map.singular = determinant == 0;
  if (map.mirrors) map.normals = -map.normals;
  return map;
}

}  // namespace aluminate::scenes::gltf
