// From clip space to snapped screen positions, once per vertex, so that triangles that share a vertex share its position.
// This scalar function is the definition; project_vertices() gives the same bits with vectors.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "rasterizer/draw.hpp"
#include "rasterizer/limits.hpp"

namespace aluminate::raster {

/// Outcodes. A triangle whose corners share a side bit is outside; one with any Cut bit goes through clip_triangle.
enum VertexFlag : std::uint32_t {
  kLeft = 1, kRight = 2, kBottom = 4, kTop = 8, kNear = 16, kFar = 32,
  kSides = kLeft | kRight | kBottom | kTop | kNear | kFar,
  kCut = 64,         // beyond near, far or the guard band, or w <= 0: has no screen position (x = y = z4 = 0)
  kNonFinite = 128,
};

struct ScreenVertex {
  std::int32_t x = 0, y = 0;  // s15.8 px
  std::int32_t z4 = 0;        // D24 with 4 fraction bits
  std::uint32_t flags = 0;
};

/// Pixel coordinates = x/w * half + half, 256 sub per pixel; y points down.
struct ScreenMap {
  double half_x, half_y;      // px
  double guard_low_x, guard_high_x, guard_low_y, guard_high_y;
  explicit ScreenMap(const Viewport& viewport)
      : half_x(viewport.width * 0.5),
        half_y(viewport.height * 0.5),
        guard_low_x(half_x + kGuardBandPx),
        guard_high_x(kGuardBandPx - half_x),
        guard_low_y(half_y + kGuardBandPx),
        guard_high_y(kGuardBandPx - half_y) {}
};

/// Signed distances to the planes triangles are cut at, >= 0 inside, homogeneous (times w).
enum CutPlane : int { kCutNear, kCutFar, kCutLeft, kCutRight, kCutTop, kCutBottom, kCutPlanes };
inline double cut_distance(const ScreenMap& map, int plane, double x, double y, double z, double w) noexcept {
  switch (plane) {
    case kCutNear: return z;
    case kCutFar: return w - z;
    case kCutLeft: return map.guard_low_x * w + map.half_x * x;
    case kCutRight: return map.guard_high_x * w - map.half_x * x;
    case kCutTop: return map.guard_low_y * w - map.half_y * y;
    default: return map.guard_high_y * w + map.half_y * y;
  }
}

/// To the nearest integer, ties to even; |value| < 2^51.
inline double round_even(double value) noexcept {
  constexpr double kMagic = 0x1.8p52;
  return (value + kMagic) - kMagic;
}

/// Divides and snaps a vertex inside all cut planes. False when the quotients do not fit the guard band (w = 0, overflow).
inline bool snap_vertex(const ScreenMap& map, double x, double y, double z, double w, ScreenVertex& out) noexcept {
  const double half_x = map.half_x * kSubpixels, half_y = map.half_y * kSubpixels;
  const double sx = round_even((x / w) * half_x + half_x);
  const double sy = round_even(half_y - (y / w) * half_y);
  const double sz = round_even((z / w) * (static_cast<double>(kDepthMax) * (1 << kVertexDepthBits)));
  // A corner cut at the guard band may miss it by the rounding of its own coordinates: a pixel is forgiven and held back.
  constexpr double kLimit = kGuardBandSub, kForgiven = kLimit + kSubpixels;
  const bool fits = w > 0 && std::fabs(sx) <= kForgiven && std::fabs(sy) <= kForgiven && sz >= 0 &&
                    sz <= static_cast<double>(kDepthMax) * (1 << kVertexDepthBits);
  if (!fits) return false;
  out.x = static_cast<std::int32_t>(std::clamp(sx, -kLimit, kLimit));
  out.y = static_cast<std::int32_t>(std::clamp(sy, -kLimit, kLimit));
  out.z4 = static_cast<std::int32_t>(sz);
  return true;
}

inline ScreenVertex project_vertex(const ScreenMap& map, double x, double y, double z, double w) noexcept {
  ScreenVertex out;
  // |v| < inf is false for NaN too.
  constexpr double kInfinity = HUGE_VAL;
  const bool finite = std::fabs(x) < kInfinity && std::fabs(y) < kInfinity && std::fabs(z) < kInfinity && std::fabs(w) < kInfinity;
  if (!finite) {
    out.flags = kNonFinite;
    return out;
  }
  out.flags = (x < -w ? kLeft : 0u) | (x > w ? kRight : 0u) | (y < -w ? kBottom : 0u) | (y > w ? kTop : 0u) |
              (z < 0 ? kNear : 0u) | (z > w ? kFar : 0u);
  bool inside = w > 0;
  for (int plane = 0; plane < kCutPlanes; ++plane) inside = inside && cut_distance(map, plane, x, y, z, w) >= 0;
  if (!inside || !snap_vertex(map, x, y, z, w, out)) out.flags |= kCut;
  return out;
}

/// out[i] = project_vertex(positions i) for i in [begin, end).
void project_vertices(const ScreenMap& map, const ClipPositions& positions, std::size_t begin, std::size_t end,
                      ScreenVertex* out);

}  // namespace aluminate::raster
