// Cuts a triangle that crosses the near plane, the far plane or the guard band, in homogeneous space, before any division.
// A new corner depends only on its edge (always from the inside end to the outside end), so two triangles that share an
// edge get bit-identical corners on it. In: three clip-space corners. Out: a convex polygon, or nothing.
#pragma once

#include <array>

#include "rasterizer/limits.hpp"
#include "rasterizer/screen_vertex.hpp"

namespace aluminate::raster {

struct ClipCorner {
  double x = 0, y = 0, z = 0, w = 0;
  double b1 = 0, b2 = 0;  // barycentrics in the triangle that is cut
};

struct ClipPolygon {
  std::array<ClipCorner, kMaxClipCorners> corner{};
  int count = 0;          // 0, or 3 .. kMaxClipCorners; fragments are the fan (0, k, k + 1)
};

/// Corners must be finite. Positions that overflow on the way come out as NaN or infinity: the caller's snap refuses them.
ClipPolygon clip_triangle(const ScreenMap& map, const ClipCorner& a, const ClipCorner& b, const ClipCorner& c);

}  // namespace aluminate::raster
