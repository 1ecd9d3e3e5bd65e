// From a pixel and its depth back to the world. In: a view; NDC and D24 depth. Out: the numbers a shader
// needs for it and the same sums in binary64. Literal IEEE operations only: the bill depends on them.
#pragma once

#include <glm/glm.hpp>

#include "rasterizer/limits.hpp"
#include "scenes/view.hpp"

namespace aluminate::passes {

/// Perspective: distance along the view = z / (x - y depth), from clip z / w = f (d - n) / (d (f - n)). All
/// three are scaled by one power of two s with n s in (1/16, 1/8], so that neither they nor the reciprocal
/// leave the range of a narrow fixed-point format: x = s, y = s (1 - n / f), z = s n. Orthographic: distance
/// = x + y depth. position = eye + (right ndc.x + up ndc.y + forward) * distance, orthographic: eye + right
/// ndc.x + up ndc.y + forward * distance.
struct ViewRays {
  glm::dvec3 depth_to_distance{0}, forward{0}, right{0}, up{0};
  bool perspective = true;

  explicit ViewRays(const scenes::View& view) : eye_(view.eye) {
    const double n = view.near_plane, f = view.far_plane;
    forward = -view.back;
    perspective = view.perspective;
    if (perspective) {
      double scale = 1;
      while (n * scale > 0.125) scale *= 0.5;
      while (n * scale <= 0.0625) scale *= 2;
      depth_to_distance = {scale, scale * (1 - n / f), scale * n};
      right = view.right * (view.tan_half_fovy * view.aspect);
      up = view.up * view.tan_half_fovy;
    } else {
      depth_to_distance = {n, f - n, 0};
      right = view.right * (view.half_height * view.aspect);
      up = view.up * view.half_height;
    }
  }

  double distance(std::uint32_t depth_d24) const {
    const double depth = depth_d24 * (1.0 / raster::kDepthMax);
    return perspective ? depth_to_distance.z / (depth_to_distance.x - depth * depth_to_distance.y)
                       : depth_to_distance.x + depth * depth_to_distance.y;
  }
  glm::dvec3 position(const glm::dvec2& ndc, double distance) const {
    const glm::dvec3 across = right * ndc.x + up * ndc.y;
    return perspective ? eye_ + (across + forward) * distance : eye_ + across + forward * distance;
  }

 private:
  glm::dvec3 eye_;
};

/// Centre of pixel x of `width` in [-1, 1]; for rows pass -y's result (NDC y points up).
inline double pixel_ndc(int pixel, int size) { return (2.0 * pixel + 1.0) / size - 1.0; }

}  // namespace aluminate::passes
