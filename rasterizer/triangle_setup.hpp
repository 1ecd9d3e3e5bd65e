// From three vertices to a record, for eight triangles at once: what is not worth a record (not finite, outside, no area, facing
// away, no sample in its bounds) is counted and left out, the rest gets its corners in canonical order. Integers, in binary64
// where they need more than 32 bits: exact, so every vector unit decides alike. canonical.hpp is the definition.
#pragma once


#include <cstdint>

#include "rasterizer/draw.hpp"
#include "rasterizer/limits.hpp"
#include "rasterizer/screen_vertex.hpp"
#include "rasterizer/skip.hpp"
#include "rasterizer/triangle.hpp"

namespace aluminate::raster {

/// Consecutive triangles of one draw.
struct TriangleRange {
  const ScreenVertex* vertices = nullptr;
  const std::uint32_t* indices = nullptr;  // 3 each, into vertices, in range
  std::uint32_t count = 0;
  TriangleId first_id = 0;                 // of triangle 0; consecutive
  std::uint32_t draw = 0;
};

struct SetupRule {
  CullMode mode = CullMode::None;
  bool frustum = true, facing = true, small = true;  // skips that are on
  int width = 0, height = 0;                         // viewport, px
  int samples = 1;
};

/// First and last tile along both axes that can hold a sample of a record.
struct TileBounds {
  std::uint8_t x0, y0, x1, y1;
};
static_assert(kMaxViewportPx / kTilePx <= 256);

/// Where records go, one after the other. Both arrays need kSetupSlack elements beyond the last record.
inline constexpr std::uint32_t kSetupSlack = 8;
struct SetupOutput {
  SetupTriangle* records = nullptr;
  TileBounds* bounds = nullptr;
  std::uint32_t count = 0;
};

/// Sets up the triangles from number `begin` up to the first that has to be cut (kCut), or all; returns where it stopped.
/// Each is a record or in exactly one counter, the first that applies of dropped_nonfinite, frustum (a side all corners are
/// beyond), degenerate, facing, small (bounds without a sample), frustum (bounds outside the viewport), small (bounds of one
/// pixel whose samples are missed).
std::uint32_t set_up_triangles(const TriangleRange& range, std::uint32_t begin, const SetupRule& rule, SetupOutput& out,
                               SetupCounters& counters);

}  // namespace aluminate::raster
