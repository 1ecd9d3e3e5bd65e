// The tests a triangle has to pass before it is worth a record, for 16 triangles at once: area, facing, bounds, and for those
// whose bounds hold one pixel whether they touch a sample of it. In: snapped corners. Out: masks and pixel bounds.
// Integers carried in binary64 where they need more than 32 bits: exact, so every vector unit decides alike.
#pragma once

#include <cstdint>

#include "rasterizer/draw.hpp"
#include "rasterizer/samples.hpp"

namespace aluminate::raster {

inline constexpr int kCullGroup = 16;

/// Corners of up to 16 triangles as submitted, s15.8 px, |v| <= kGuardBandSub.
struct alignas(64) CornerGroup {
  std::int32_t x[3][kCullGroup], y[3][kCullGroup];
};

struct CullRule {
  CullMode mode = CullMode::None;
  bool facing = true, small = true;  // skips that are on
  int width = 0, height = 0;         // viewport, px
  int samples = 1;
};

/// Bit i: triangle i. Each is in exactly one of kept, degenerate, facing, small, outside, the first that applies in the order
/// degenerate, facing, small, outside, small again for a single pixel whose samples are missed.
struct alignas(64) CullResult {
  // Of kept ones: pixels that can hold a sample, inclusive, inside the viewport. First, for their alignment.
  std::int32_t x0[kCullGroup], y0[kCullGroup], x1[kCullGroup], y1[kCullGroup];
  std::uint32_t kept = 0, degenerate = 0, facing = 0, small = 0, outside = 0;
  std::uint32_t culled = 0;          // kept although the face is culled (facing off)
};

/// Only the first `count` triangles are meant; the rest of the group must hold any numbers within the range.
void cull_triangles(const CornerGroup& corners, int count, const CullRule& rule, CullResult& result);

}  // namespace aluminate::raster
