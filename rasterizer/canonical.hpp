// The canonical order of a snapped triangle and its depth plane: the definitions behind SetupTriangle.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "rasterizer/limits.hpp"
#include "rasterizer/samples.hpp"
#include "rasterizer/screen_vertex.hpp"
#include "rasterizer/triangle.hpp"

namespace aluminate::raster {

/// Twice the signed area in sub^2, positive = clockwise on the screen (y down). Exact: below 2^47 (limits.hpp).
inline std::int64_t twice_area(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c) noexcept {
  return std::int64_t{b.x - a.x} * (c.y - a.y) - std::int64_t{c.x - a.x} * (b.y - a.y);
}

struct CanonicalOrder {
  std::array<std::uint8_t, 3> corner{};  // canonical corner k is submitted corner[k]
  std::int64_t area2 = 0;                // > 0; 0 = degenerate
  bool front_facing = false;             // counter-clockwise with y up: negative before reordering
};

/// Topmost, then leftmost corner first; the rest clockwise. Distinct corners of a triangle with area have no ties.
inline CanonicalOrder canonical_order(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c) noexcept {
  CanonicalOrder order;
  const std::int64_t area2 = twice_area(a, b, c);
  order.front_facing = area2 < 0;
  order.area2 = area2 < 0 ? -area2 : area2;
  const auto before = [](const ScreenVertex& p, const ScreenVertex& q) { return p.y < q.y || (p.y == q.y && p.x < q.x); };
  const unsigned first = before(b, a) ? (before(c, b) ? 2 : 1) : (before(c, a) ? 2 : 0);
  static constexpr std::uint8_t kWalk[2][3][3] = {{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}, {{0, 2, 1}, {1, 0, 2}, {2, 1, 0}}};
  const std::uint8_t* walk = kWalk[area2 < 0][first];  // backwards when counter-clockwise
  order.corner = {walk[0], walk[1], walk[2]};
  return order;
}

/// Depth with 4 fraction bits to D24, half up.
inline std::uint32_t depth_from_z4(std::int32_t z4) noexcept {
  return static_cast<std::uint32_t>((z4 + (1 << (kVertexDepthBits - 1))) >> kVertexDepthBits);
}

/// One depth slope per sub in 2^-38 D24: the binary64 quotient (numerator and area are exact), scaled, held below 2^62 and
/// truncated. Error below 2^-38 + 2^-53 |slope|: at 2^23 sub less than 2^-13 D24 unless the whole depth range passes within
/// a few pixels; such slivers are bounded by the clamp to [z_min, z_max].
inline constexpr double kSlopeScale = 0x1p34, kSlopeLimit = 0x1p62;  // z4 units to 2^-38 D24: 38 - 4
static_assert(kPlaneBits - kVertexDepthBits == 34);
inline std::int64_t depth_slope(std::int64_t numerator, std::int64_t area2) noexcept {
  double slope = static_cast<double>(numerator) / static_cast<double>(area2) * kSlopeScale;
  slope = slope > kSlopeLimit ? kSlopeLimit : slope;
  slope = slope < -kSlopeLimit ? -kSlopeLimit : slope;
  return static_cast<std::int64_t>(slope);
}

/// Edge value of side k (canonical corner k to the next) at (x, y) sub minus the tie bias: >= 0 inside. A sample on an edge
/// belongs to the triangle when that edge is a top or a left one, so neighbours share every sample out [D3D11-FS 3.4.2].
inline std::int64_t biased_edge(const std::int32_t* tx, const std::int32_t* ty, int k, std::int64_t x, std::int64_t y) noexcept {
  const int n = k == 2 ? 0 : k + 1;
  const std::int64_t dx = tx[n] - tx[k], dy = ty[n] - ty[k];
  const bool top_left = dy < 0 || (dy == 0 && dx > 0);
  return dx * (y - ty[k]) - dy * (x - tx[k]) - (top_left ? 0 : 1);
}

/// Whether the triangle of these canonical corners covers the point (x, y) sub.
inline bool covers(const std::int32_t* tx, const std::int32_t* ty, std::int64_t x, std::int64_t y) noexcept {
  return (biased_edge(tx, ty, 0, x, y) | biased_edge(tx, ty, 1, x, y) | biased_edge(tx, ty, 2, x, y)) >= 0;
}

/// Whether the triangle covers a sample of pixel (px, py).
template <int kSamples>
[[gnu::always_inline]] inline bool covers_pixel(const SetupTriangle& t, int px, int py) noexcept {
  using Pattern = SamplePattern<kSamples>;
  bool any = false;
  for (int s = 0; s < kSamples; ++s)
    any = any || covers(t.x, t.y, std::int64_t{px} * kSubpixels + Pattern::kX[s], std::int64_t{py} * kSubpixels + Pattern::kY[s]);
  return any;
}

/// v0, v1, v2 are in canonical order.
inline void fill_corners(const ScreenVertex& v0, const ScreenVertex& v1, const ScreenVertex& v2, SetupTriangle& out) noexcept {
  out.x[0] = v0.x, out.x[1] = v1.x, out.x[2] = v2.x;
  out.y[0] = v0.y, out.y[1] = v1.y, out.y[2] = v2.y;
  out.z4[0] = v0.z4, out.z4[1] = v1.z4, out.z4[2] = v2.z4;
  out.z_min = depth_from_z4(std::min(std::min(v0.z4, v1.z4), v2.z4));
}

/// Depth of a sample, the definition (all arithmetic modulo 2^64, then 2^32; exact for every covered sample because the true
/// value has 62 bits, then 31):
///   P(X, Y) = (z0 << 34) + 2^37 + z_dx (X - x0) + z_dy (Y - y0)          plane plus half a step, at sub position (X, Y)
///   A = P(this sample of the stamp's first pixel) >> 31                  7 fraction bits, floor
///   g = (256 slope + 2^30) >> 31                                         step per pixel, 7 fraction bits, nearest
///   depth = clamp((A + i gx + j gy) >> 7, z_min, z_max)                  i, j = pixel in the 4x4 stamp
/// Off the exact plane by at most 1/2 + 2^-7 + 6 * 2^-8 + 2^-13 D24. Slope 0 gives the corners' depth at every sample.
struct DepthSteps {
  std::uint64_t origin;        // P at the centre of a first pixel: of the tile, or of a stamp in it
  std::uint64_t sub_x, sub_y;  // slope
  std::uint64_t px_x, px_y;    // 256 * slope: one pixel
  std::uint32_t lane_x, lane_y;  // gx, gy
  std::int32_t z_min, z_max;
};

/// to_x, to_y: from corner 0, whose depth is z4, to the centre of the first pixel, sub.
inline DepthSteps depth_steps(std::int64_t slope_x, std::int64_t slope_y, std::int32_t z4, std::int32_t to_x, std::int32_t to_y,
                              std::uint32_t z_min, std::uint32_t z_max) noexcept {
  const auto dx = static_cast<std::uint64_t>(slope_x), dy = static_cast<std::uint64_t>(slope_y);
  DepthSteps steps;
  steps.z_min = static_cast<std::int32_t>(z_min);
  steps.z_max = static_cast<std::int32_t>(z_max);
  steps.origin = (static_cast<std::uint64_t>(z4) << (kPlaneBits - kVertexDepthBits)) + (std::uint64_t{1} << (kPlaneBits - 1)) +
                 dx * static_cast<std::uint64_t>(std::int64_t{to_x}) + dy * static_cast<std::uint64_t>(std::int64_t{to_y});
  steps.sub_x = dx;
  steps.sub_y = dy;
  steps.px_x = dx << kSubpixelBits;
  steps.px_y = dy << kSubpixelBits;
  constexpr int kShift = kPlaneBits - kStampDepthBits;
  constexpr std::uint64_t kHalf = std::uint64_t{1} << (kShift - 1);
  steps.lane_x = static_cast<std::uint32_t>(static_cast<std::int64_t>(steps.px_x + kHalf) >> kShift);
  steps.lane_y = static_cast<std::uint32_t>(static_cast<std::int64_t>(steps.px_y + kHalf) >> kShift);
  return steps;
}

/// From the tile's first pixel on.
inline DepthSteps depth_steps(const SetupTriangle& t, TileOrigin tile) noexcept {
  const std::int64_t x1 = t.x[1] - t.x[0], x2 = t.x[2] - t.x[0], y1 = t.y[1] - t.y[0], y2 = t.y[2] - t.y[0];
  const std::int64_t z1 = t.z4[1] - t.z4[0], z2 = t.z4[2] - t.z4[0];
  const std::int64_t area2 = x1 * y2 - x2 * y1;
  return depth_steps(depth_slope(z1 * y2 - z2 * y1, area2), depth_slope(z2 * x1 - z1 * x2, area2), t.z4[0],
                     tile.x * kSubpixels + kHalfPixel - t.x[0], tile.y * kSubpixels + kHalfPixel - t.y[0], t.z_min,
                     depth_from_z4(std::max(std::max(t.z4[0], t.z4[1]), t.z4[2])));
}

/// A from P.
inline std::uint32_t anchor_of(std::uint64_t plane) noexcept {
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(plane) >> (kPlaneBits - kStampDepthBits));
}
/// P at the centre of the tile's pixel (x, y).
inline std::uint64_t centre_plane(const DepthSteps& steps, int x, int y) noexcept {
  return steps.origin + steps.px_x * static_cast<std::uint64_t>(x) + steps.px_y * static_cast<std::uint64_t>(y);
}
/// P at a sample minus P at its pixel's centre.
template <int kSamples>
std::uint64_t sample_plane(const DepthSteps& steps, int sample) noexcept {
  using Pattern = SamplePattern<kSamples>;
  return steps.sub_x * static_cast<std::uint64_t>(std::int64_t{Pattern::kX[sample] - kHalfPixel}) +
         steps.sub_y * static_cast<std::uint64_t>(std::int64_t{Pattern::kY[sample] - kHalfPixel});
}

}  // namespace aluminate::raster
