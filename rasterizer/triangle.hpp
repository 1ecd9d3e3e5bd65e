// One triangle ready for the tiles: snapped corners and identity, small enough for bins to hold it by value (an index would
// cost a cache miss per triangle and tile, many times what the copy costs).
// Corners are in canonical order, so that the six ways to submit a triangle give the same coverage and depth: positive
// area (clockwise on the screen, y down), starting at the topmost, then leftmost corner.
#pragma once

#include <cstdint>

#include "rasterizer/draw.hpp"
#include "rasterizer/limits.hpp"

namespace aluminate::raster {

struct alignas(16) SetupTriangle {
  std::int32_t x[3], y[3];       // s15.8 px, |v| <= kGuardBandSub
  std::int32_t z4[3];            // depth of the corners, D24 with 4 fraction bits
  std::uint32_t z_min;           // smallest depth of a corner, D24: no pixel is nearer
  TriangleId id;
  std::uint32_t draw_and_culled; // bit 31: not to be drawn (culled face while Skip::Facing is off)

  static constexpr std::uint32_t kCulled = 0x80000000u;
  std::uint32_t draw() const { return draw_and_culled & ~kCulled; }
  bool culled() const { return (draw_and_culled & kCulled) != 0; }
};
static_assert(sizeof(SetupTriangle) == 48);

}  // namespace aluminate::raster
