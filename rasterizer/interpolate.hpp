// Perspective barycentrics and attributes of 64 lanes in the shader's number system: every result is an integer multiple of
// 2^-31 carried in a binary64, from exact integer edge values, by the same IEEE operations on every machine.
// In: triangle ids and quad positions. Out: rows of 64 doubles, lane 4 quad + l, helper lanes extrapolated.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "rasterizer/frame.hpp"
#include "rasterizer/limits.hpp"

namespace aluminate::raster {

/// Extrapolation outside a triangle stops at this many times its own size: |b1|, |b2| <= 256 keeps b (a1 - a0) within the
/// VM's 2^20 for attribute ranges up to 2^11. Reached only in helper lanes of triangles below 1/256 px or near the horizon.
inline constexpr double kBarycentricLimit = 256;

/// What interpolated attributes are multiples of.
inline constexpr double kAttributeStep = 0x1p-31;

/// Barycentrics of the submitted triangle at the lanes of up to 16 quads; b0 = 1 - b1 - b2 exactly. 1/w is held above 0 where
/// a helper lane lies beyond the horizon.
struct alignas(64) BarycentricRows {
  std::array<double, kBatchLanes> b1{}, b2{};
};

/// One quad to interpolate: absolute pixel of its lane 0.
struct QuadPosition {
  TriangleId triangle = kNoTriangle;
  std::uint16_t x = 0, y = 0;
};

/// Fills 4 quads.size() lanes (<= 64); `info`, when not empty, receives frame.triangle() of each quad, so that the caller
/// can find vertices and facing. Lanes of quads beyond the list are left alone.
///
/// A lane is evaluated at its pixel's centre, except with four samples where the triangle covers a sample but not the centre:
/// then at the covered sample nearest the centre, so that nothing visible is extrapolated. All four are equally near: the one
/// with the lowest number. It depends on the triangle alone, not on what hides it. Differences between lanes of a quad, and
/// with them texture detail, then see lanes up to half a pixel out of their grid along edges, as consoles did.
///
/// Definition, per lane, binary64 with one rounding per operation, corners in canonical order (triangle.hpp):
///   E_i exact integer edge value opposite corner i at that point; q_i = min(w) / w_i; n_i = E_i q_i;
///   s = max((n_0 + n_1) + n_2, 2^-20 (E_0 + E_1 + E_2) q_min);  r = 1 / s;  L_i = grid(clamp(n_i r)), i = 1, 2;
///   grid rounds to a multiple of 2^-31, to even; L_0 = 1 - L_1 - L_2; b_k = L of the canonical place of corner k.
///   Clipped fragments: b_k = grid sum of L_i b_k(corner i).
void interpolate_barycentrics(const Frame& frame, std::span<const QuadPosition> quads, BarycentricRows& rows,
                              std::span<TriangleInfo> info = {});

/// out[lane] = a0 + grid(b1 d1) + grid(b2 d2) with a0, d1 = a1 - a0, d2 = a2 - a0 per quad, all multiples of 2^-31 with
/// |.| < 2^20: sums and differences are exact, products are rounded once. d1 = d2 = 0 gives a0 exactly.
void interpolate_attribute(const BarycentricRows& rows, std::span<const double, kBatchQuads> a0,
                           std::span<const double, kBatchQuads> d1, std::span<const double, kBatchQuads> d2,
                           std::span<double, kBatchLanes> out);

/// Where a batch's attributes come from and go: attribute `attribute` of every vertex to row `row` of the output.
struct AttributeRow {
  std::uint32_t attribute = 0, row = 0;
};
/// First attributes of the three submitted corners of a quad's triangle.
using AttributeCorners = std::array<const double*, 3>;

/// interpolate_attribute for all attributes of a batch in one pass: out[row * kBatchLanes + lane] for the lanes of
/// corners.size() quads (<= 16), 0 in the lanes beyond them. Returns the greatest magnitude written. The same bits.
double interpolate_attributes(const BarycentricRows& rows, std::span<const AttributeCorners> corners,
                              std::span<const AttributeRow> attributes, double* out);

/// value rounded to the 2^-31 grid, to even; |value| < 2^20.
inline double to_fx31(double value) {
  constexpr double kMagic = 0x1.8p21;  // 1.5 * 2^(52 - 31)
  return (value + kMagic) - kMagic;
}

}  // namespace aluminate::raster
