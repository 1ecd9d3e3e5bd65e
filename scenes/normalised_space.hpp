// World units to shading units. Shaders run in fixed point (|value| < 2^20, 31 fraction bits), so a scene of
// 1e-4 or of 1e6 units is first centred and scaled to a bounding radius in [1, 2). The scale is a power of
// two: exact in binary64.
#pragma once

#include "scenes/scene.hpp"

#include <glm/glm.hpp>

namespace aluminate::scenes {

/// p_normalised = (p_world - centre) * 2^exponent. Lengths scale by 2^exponent, squared lengths by
/// 4^exponent.
struct NormalisedSpace {
  glm::dvec3 centre{0};
  int exponent = 0;
  double scale = 1;           // 2^exponent
  double radius_world = 1;    // half diagonal of the bounds, world units; 1 for a scene without extent
  double radius = 1;          // the same in normalised units, in [1, 2)
  glm::dvec3 half_extent{0};  // half the bounds' edges, normalised units

  glm::dvec3 point(const glm::dvec3& world) const { return (world - centre) * scale; }
  glm::dvec3 world(const glm::dvec3& normalised) const { return normalised / scale + centre; }
};

/// From Scene::bounds_min and bounds_max. A scene with no extent (one point, nothing) gets radius 1 and
/// scale 1.
NormalisedSpace normalised_space(const glm::dvec3& bounds_min, const glm::dvec3& bounds_max);
inline NormalisedSpace normalised_space(const Scene& scene) {
  return normalised_space(scene.bounds_min, scene.bounds_max);
}

}  // namespace aluminate::scenes
