// One triangle ready for the tiles: snapped corners, depth plane, identity, in one cache line that bins hold by value.
// Corners are in canonical order, so that the six ways to submit a triangle give the same coverage and depth: positive
// area (clockwise on the screen, y down), starting at the topmost, then leftmost corner.
#pragma once

#include <cstdint>

#include "rasterizer/draw.hpp"
#include "rasterizer/limits.hpp"

namespace aluminate::raster {

struct alignas(64) SetupTriangle {
  std::int32_t x[3], y[3];       // s15.8 px, |v| <= kGuardBandSub
  std::int32_t z0;               // depth of corner 0, D24 with 4 fraction bits
  std::uint32_t z_min, z_max;    // range of the corners, D24: every pixel's depth is clamped into it
  std::uint32_t id;              // TriangleId
  std::uint32_t draw;
  std::uint32_t culled;          // 1 = not to be drawn (facing, when Skip::Facing is off)
  std::int64_t z_dx, z_dy;       // depth slope per sub, 2^-38 D24
};
static_assert(sizeof(SetupTriangle) == 64);

}  // namespace aluminate::raster
