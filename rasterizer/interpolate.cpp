#include "rasterizer/interpolate.hpp"

#include <algorithm>
#include <cmath>

#include "platform/host/error.hpp"
#include "rasterizer/canonical.hpp"
#include "rasterizer/samples.hpp"

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rasterizer/interpolate.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef ALUMINATE_INTERPOLATE_ONCE
#define ALUMINATE_INTERPOLATE_ONCE
namespace aluminate::raster {

/// One quad as numbers: edge values at lane 0 and their steps are integers below 2^48, exact in binary64.
struct QuadTerms {
  double e1, e1_x, e1_y, e2, e2_x, e2_y;  // edge values opposite canonical corners 1 and 2
  double area2;
  double q0, q1, q2;
  double least;                           // smallest s
};

/// Where its lanes are evaluated, in pixels from the centre of lane 0: multiples of 1/256.
struct QuadPlaces {
  double x[4] = {0, 1, 0, 1}, y[4] = {0, 0, 1, 1};
};

constexpr double kLeastShare = 0x1p-20;

}  // namespace aluminate::raster
#endif

HWY_BEFORE_NAMESPACE();
namespace aluminate::raster::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_EMU128
using Tag = hn::CappedTag<double, 2>;
#else
using Tag = hn::CappedTag<double, 4>;  // one quad at most: SSE4 takes two steps, AVX2 and AVX-512 one
#endif

/// Canonical barycentrics 1 and 2 of one quad's four lanes.
void QuadBarycentrics(const QuadTerms& t, const QuadPlaces& places, double* l1, double* l2) {
  const Tag d;
  const auto magic = hn::Set(d, 0x1.8p21), limit = hn::Set(d, kBarycentricLimit), lowest = hn::Set(d, -kBarycentricLimit);
  for (std::size_t i = 0; i < 4; i += hn::MaxLanes(d)) {
    const auto x = hn::LoadU(d, places.x + i), y = hn::LoadU(d, places.y + i);
    // Steps are multiples of 256, so products are integers and sums stay below 2^49: exact.
    const auto e1 = hn::Add(hn::Set(d, t.e1), hn::Add(hn::Mul(x, hn::Set(d, t.e1_x)), hn::Mul(y, hn::Set(d, t.e1_y))));
    const auto e2 = hn::Add(hn::Set(d, t.e2), hn::Add(hn::Mul(x, hn::Set(d, t.e2_x)), hn::Mul(y, hn::Set(d, t.e2_y))));
    const auto e0 = hn::Sub(hn::Sub(hn::Set(d, t.area2), e1), e2);
    const auto n0 = hn::Mul(e0, hn::Set(d, t.q0)), n1 = hn::Mul(e1, hn::Set(d, t.q1)), n2 = hn::Mul(e2, hn::Set(d, t.q2));
    const auto s = hn::Max(hn::Add(hn::Add(n0, n1), n2), hn::Set(d, t.least));
    const auto r = hn::Div(hn::Set(d, 1.0), s);
    const auto b1 = hn::Min(hn::Max(hn::Mul(n1, r), lowest), limit), b2 = hn::Min(hn::Max(hn::Mul(n2, r), lowest), limit);
    hn::StoreU(hn::Sub(hn::Add(b1, magic), magic), d, l1 + i);
    hn::StoreU(hn::Sub(hn::Add(b2, magic), magic), d, l2 + i);
  }
}

/// places: one per quad, or null for pixel centres.
void BatchBarycentrics(const QuadTerms* terms, const QuadPlaces* places, std::size_t quads, double* l1, double* l2) {
  const QuadPlaces centres;
  for (std::size_t q = 0; q < quads; ++q) QuadBarycentrics(terms[q], places ? places[q] : centres, l1 + 4 * q, l2 + 4 * q);
}

void Attribute(const double* b1, const double* b2, const double* a0, const double* d1, const double* d2, double* out) {
#if HWY_NATIVE_FMA
  const Tag d;
  const auto magic = hn::Set(d, 0x1.8p21);
  for (std::size_t q = 0; q < kBatchQuads; ++q)
    for (std::size_t i = 4 * q; i < 4 * q + 4; i += hn::MaxLanes(d)) {
      const auto p1 = hn::Sub(hn::MulAdd(hn::Load(d, b1 + i), hn::Set(d, d1[q]), magic), magic);
      const auto p2 = hn::Sub(hn::MulAdd(hn::Load(d, b2 + i), hn::Set(d, d2[q]), magic), magic);
      hn::StoreU(hn::Add(hn::Add(hn::Set(d, a0[q]), p1), p2), d, out + i);
    }
#else
  // Without the instruction the C library's exact fma gives the same bits, slowly.
  constexpr double kMagic = 0x1.8p21;
  for (std::size_t lane = 0; lane < kBatchLanes; ++lane) {
    const std::size_t q = lane / 4;
    const double p1 = std::fma(b1[lane], d1[q], kMagic) - kMagic, p2 = std::fma(b2[lane], d2[q], kMagic) - kMagic;
    out[lane] = a0[q] + p1 + p2;
  }
#endif
}

/// Quad by quad: barycentrics stay in registers, and a corner's attributes lie side by side in memory.
double Attributes(const BarycentricRows& rows, const AttributeCorners* corners, std::size_t quads, const AttributeRow* attributes,
                  std::size_t count, double* out) {
  const Tag d;
  auto greatest = hn::Zero(d);
#if HWY_NATIVE_FMA
  const auto magic = hn::Set(d, 0x1.8p21);
  for (std::size_t q = 0; q < quads; ++q)
    for (std::size_t i = 4 * q; i < 4 * q + 4; i += hn::MaxLanes(d)) {
      const auto b1 = hn::Load(d, rows.b1.data() + i), b2 = hn::Load(d, rows.b2.data() + i);
      const double *c0 = corners[q][0], *c1 = corners[q][1], *c2 = corners[q][2];
      for (const AttributeRow* a = attributes; a != attributes + count; ++a) {
        const auto a0 = hn::Set(d, c0[a->attribute]);
        const auto d1 = hn::Sub(hn::Set(d, c1[a->attribute]), a0), d2 = hn::Sub(hn::Set(d, c2[a->attribute]), a0);
        const auto p1 = hn::Sub(hn::MulAdd(b1, d1, magic), magic), p2 = hn::Sub(hn::MulAdd(b2, d2, magic), magic);
        const auto value = hn::Add(hn::Add(a0, p1), p2);
        greatest = hn::Max(greatest, hn::Abs(value));
        hn::StoreU(value, d, out + std::size_t{a->row} * kBatchLanes + i);
      }
    }
#else
  for (std::size_t q = 0; q < quads; ++q)
    for (const AttributeRow* a = attributes; a != attributes + count; ++a) {
      const double a0 = corners[q][0][a->attribute];
      const double d1 = corners[q][1][a->attribute] - a0, d2 = corners[q][2][a->attribute] - a0;
      constexpr double kMagic = 0x1.8p21;
      for (std::size_t lane = 4 * q; lane < 4 * q + 4; ++lane) {
        const double p1 = std::fma(rows.b1[lane], d1, kMagic) - kMagic, p2 = std::fma(rows.b2[lane], d2, kMagic) - kMagic;
        const double value = a0 + p1 + p2;
        greatest = hn::Max(greatest, hn::Set(d, std::fabs(value)));
        out[std::size_t{a->row} * kBatchLanes + lane] = value;
      }
    }
#endif
  for (const AttributeRow* a = attributes; a != attributes + count; ++a)
    std::fill(out + std::size_t{a->row} * kBatchLanes + 4 * quads, out + (std::size_t{a->row} + 1) * kBatchLanes, 0.0);
  return hn::GetLane(hn::MaxOfLanes(d, greatest));
}

}  // namespace aluminate::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace aluminate::raster {

HWY_EXPORT(BatchBarycentrics);
HWY_EXPORT(Attribute);
HWY_EXPORT(Attributes);

namespace {

/// A triangle's part of QuadTerms: q and the least sum do not depend on the position.
struct Perspective {
  double q0, q1, q2, least;
};

Perspective perspective(const TriangleInfo& t, double area2) {
  const double w_min = std::min(std::min(t.w[0], t.w[1]), t.w[2]);
  Perspective p;
  p.q0 = w_min / t.w[0];
  p.q1 = w_min / t.w[1];
  p.q2 = w_min / t.w[2];
  p.least = kLeastShare * area2 * std::min(std::min(p.q0, p.q1), p.q2);
  return p;
}

/// Edge value of corners a -> b at (x, y), exact: below 2^47 inside the guard band, and a helper lane is 256 sub beyond.
std::int64_t edge(const TriangleInfo& t, std::size_t a, std::size_t b, std::int64_t x, std::int64_t y) {
  return std::int64_t{t.x[b] - t.x[a]} * (y - t.y[a]) - std::int64_t{t.y[b] - t.y[a]} * (x - t.x[a]);
}

/// interpolate.hpp: the centre, or the first covered sample where only samples are covered. (x, y): centre of lane 0.
QuadPlaces centroid_places(const TriangleInfo& t, std::int64_t x, std::int64_t y) {
  using Pattern = SamplePattern<4>;
  std::int64_t edge[3], dx[3], dy[3], lowest = 0;
  for (int k = 0; k < 3; ++k) {
    const int n = k == 2 ? 0 : k + 1;
    edge[k] = biased_edge(t.x.data(), t.y.data(), k, x, y);
    dx[k] = t.x[static_cast<std::size_t>(n)] - t.x[static_cast<std::size_t>(k)];
    dy[k] = t.y[static_cast<std::size_t>(n)] - t.y[static_cast<std::size_t>(k)];
    lowest |= edge[k] + kSubpixels * (std::min<std::int64_t>(dx[k], 0) + std::min<std::int64_t>(-dy[k], 0));
  }
  QuadPlaces places;
  if (lowest >= 0) return places;  // all four centres are covered
  const auto covered = [&](std::int64_t right, std::int64_t down) {
    std::int64_t signs = 0;
    for (int k = 0; k < 3; ++k) signs |= edge[k] + dx[k] * down - dy[k] * right;
    return signs >= 0;
  };
  for (int lane = 0; lane < 4; ++lane) {
    const int right = (lane & 1) * kSubpixels, down = (lane >> 1) * kSubpixels;
    if (covered(right, down)) continue;
    for (int s = 0; s < 4; ++s) {
      const int sample_x = right + Pattern::kX[s] - kHalfPixel, sample_y = down + Pattern::kY[s] - kHalfPixel;
      if (!covered(sample_x, sample_y)) continue;
      places.x[lane] = sample_x / double{kSubpixels};
      places.y[lane] = sample_y / double{kSubpixels};
      break;
    }
  }
  return places;
}

}  // namespace

void interpolate_barycentrics(const Frame& frame, std::span<const QuadPosition> quads, BarycentricRows& rows,
                              std::span<TriangleInfo> info) {
  ALU_CHECK(quads.size() <= kBatchQuads && (info.empty() || info.size() >= quads.size()), "{} quads, {} places for triangles",
            quads.size(), info.size());
  QuadTerms terms[kBatchQuads];
  QuadPlaces places[kBatchQuads];
  const bool centroid = frame.samples() > 1;
  std::array<std::uint8_t, 3> corner[kBatchQuads];
  TriangleInfo triangle;
  TriangleId last = kNoTriangle;
  Perspective p{};
  double area2 = 0;
  bool any_clipped = false;
  for (std::size_t i = 0; i < quads.size(); ++i) {
    const QuadPosition& quad = quads[i];
    if (quad.triangle != last) {
      last = quad.triangle;
      triangle = frame.triangle(last);
      area2 = static_cast<double>(edge(triangle, 0, 1, triangle.x[2], triangle.y[2]));
      p = perspective(triangle, area2);
    }
    if (!info.empty()) info[i] = triangle;
    corner[i] = triangle.corner;
    any_clipped = any_clipped || triangle.clipped;
    const std::int64_t x = std::int64_t{quad.x} * kSubpixels + kHalfPixel, y = std::int64_t{quad.y} * kSubpixels + kHalfPixel;
    if (centroid) places[i] = centroid_places(triangle, x, y);
    QuadTerms& t = terms[i];
    t.e1 = static_cast<double>(edge(triangle, 2, 0, x, y));
    t.e1_x = static_cast<double>(std::int64_t{triangle.y[2] - triangle.y[0]} * kSubpixels);
    t.e1_y = static_cast<double>(std::int64_t{triangle.x[0] - triangle.x[2]} * kSubpixels);
    t.e2 = static_cast<double>(edge(triangle, 0, 1, x, y));
    t.e2_x = static_cast<double>(std::int64_t{triangle.y[0] - triangle.y[1]} * kSubpixels);
    t.e2_y = static_cast<double>(std::int64_t{triangle.x[1] - triangle.x[0]} * kSubpixels);
    t.area2 = area2;
    t.q0 = p.q0, t.q1 = p.q1, t.q2 = p.q2;
    t.least = p.least;
  }
  alignas(64) double l1[kBatchLanes], l2[kBatchLanes];
  HWY_DYNAMIC_DISPATCH(BatchBarycentrics)(terms, centroid ? places : nullptr, quads.size(), l1, l2);

  // From canonical to submitted corners. L0 = 1 - L1 - L2 is exact: multiples of 2^-31 below 2^10.
  for (std::size_t i = 0; i < quads.size(); ++i) {
    const double* place[3];  // of submitted corner k among (L0, L1, L2)
    double l0[4];
    for (std::size_t lane = 0; lane < 4; ++lane) l0[lane] = 1 - l1[4 * i + lane] - l2[4 * i + lane];
    const double* canonical[3] = {l0, l1 + 4 * i, l2 + 4 * i};
    for (std::size_t k = 0; k < 3; ++k) place[corner[i][k]] = canonical[k];
    for (std::size_t lane = 0; lane < 4; ++lane) {
      rows.b1[4 * i + lane] = place[1][lane];
      rows.b2[4 * i + lane] = place[2][lane];
    }
  }
  if (!any_clipped) return;
  for (std::size_t i = 0; i < quads.size(); ++i) {
    if ((quads[i].triangle & kClippedBit) == 0) continue;
    const TriangleInfo fragment = frame.triangle(quads[i].triangle);
    for (std::size_t lane = 4 * i; lane < 4 * i + 4; ++lane) {
      const double c1 = l1[lane], c2 = l2[lane], c0 = 1 - c1 - c2;
      const auto mapped = [&](const std::array<double, 3>& b) {
        const double value = (c0 * b[0] + c1 * b[1]) + c2 * b[2];
        return to_fx31(std::clamp(value, -kBarycentricLimit, kBarycentricLimit));
      };
      rows.b1[lane] = mapped(fragment.b1);
      rows.b2[lane] = mapped(fragment.b2);
    }
  }
}

void interpolate_attribute(const BarycentricRows& rows, std::span<const double, kBatchQuads> a0,
                           std::span<const double, kBatchQuads> d1, std::span<const double, kBatchQuads> d2,
                           std::span<double, kBatchLanes> out) {
  HWY_DYNAMIC_DISPATCH(Attribute)(rows.b1.data(), rows.b2.data(), a0.data(), d1.data(), d2.data(), out.data());
}

double interpolate_attributes(const BarycentricRows& rows, std::span<const AttributeCorners> corners,
                              std::span<const AttributeRow> attributes, double* out) {
  return HWY_DYNAMIC_DISPATCH(Attributes)(rows, corners.data(), corners.size(), attributes.data(), attributes.size(), out);
}

}  // namespace aluminate::raster
#endif
