// Small triangles, one sample a pixel: prepared eight at a time with one triangle a lane, then drawn one after the other with
// one pixel a lane. Meshes are made of them, and what each one needs before its first pixel (bounds, edges, depth slopes) costs
// several times its pixels. The numbers are those of triangle_walk-inl.hpp and canonical.hpp, only in fewer bits.
#if defined(ALUMINATE_SMALL_TRIANGLES) == defined(HWY_TARGET_TOGGLE)
#ifdef ALUMINATE_SMALL_TRIANGLES
#undef ALUMINATE_SMALL_TRIANGLES
#else
#define ALUMINATE_SMALL_TRIANGLES
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "rasterizer/canonical.hpp"
#include "rasterizer/hierarchical_depth-inl.hpp"
#include "rasterizer/opaque_stamps-inl.hpp"
#include "rasterizer/record_lanes-inl.hpp"
#include "rasterizer/stamp_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace aluminate::raster::HWY_NAMESPACE {

constexpr std::size_t kSmallGroup = 8;

// Bounds of at most this many sub hold 13 pixels, hence 4 stamps, each way.
constexpr std::int32_t kSmallSub = 12 * kSubpixels;
static_assert(kSmallSub / kSubpixels + 1 + (kStampPx - 1) <= 4 * kStampPx);
// A stamp that holds a pixel of the bounds begins at most 3 pixels before them: |dx|, |dy| <= kSmallSub and |p - a| <= kReach,
// so its edge values, and after the shift those of all 4x4 stamps from the first one on, fit 32 bits unclamped.
constexpr std::int64_t kReach = kSmallSub + kStampPx * kSubpixels;
static_assert(2 * kSmallSub * kReach + 1 <= INT32_MAX);
static_assert((2 * kSmallSub * kReach >> kSubpixelBits) + 2 * 15 * kSmallSub <= INT32_MAX);

static_assert(kSmallGroup % kCornerLanes == 0);
// In binary64 where integers need up to 53 bits (limits.hpp).
using Quotient = hn::CappedTag<double, kSmallGroup>;
constexpr Quotient kQuotient;
constexpr hn::Rebind<std::int32_t, Quotient> kNumerator;
constexpr std::size_t kQuotientLanes = hn::MaxLanes(Quotient());

/// What drawing a record needs, ready to be broadcast. Pixels are tile-relative.
struct alignas(16) SmallRecord {
  std::int32_t c[3];                          // edge values at the first pixel of the first stamp (single: of the pixel)
  std::int32_t z_max;
  std::int32_t best[3];                       // what each edge can gain within a stamp
  std::int32_t z4;
  std::int32_t step_x0, step_y0, step_x1, step_y1;  // edges 0 and 1, per pixel; edge 2 makes their sum 0
  std::int32_t x0, y0, x1, y1;                // as in Walk
  std::int32_t to_x, to_y;                    // from corner 0 to the centre of the first stamp's first pixel, sub
  std::int32_t unused[2];
};
constexpr std::size_t kSmallPieces = sizeof(SmallRecord) / 16;

/// Up to 8 consecutive records of a tile. Bit i of a mask, element i of an array: record i.
struct alignas(64) SmallGroup {
  const SetupTriangle* record[kSmallGroup];
  std::uint32_t large;   // not small: looked at no further
  std::uint32_t live;    // to be drawn: large, or with pixels in the tile and not hidden
  std::uint32_t single;  // bounds of one pixel
  std::uint32_t hidden;  // behind everything in the tile
  SmallRecord small[kSmallGroup];
  alignas(64) double slope_x[kSmallGroup], slope_y[kSmallGroup];  // depth_slope before truncation
  std::int32_t dx0[kSmallGroup], dy0[kSmallGroup], dx2[kSmallGroup], dy2[kSmallGroup], dz1[kSmallGroup], dz2[kSmallGroup];
};
static_assert(offsetof(SmallGroup, slope_x) % 64 == 0 && offsetof(SmallGroup, slope_y) % 64 == 0 && offsetof(SmallGroup, dx0) % 32 == 0,
              "whole vectors are stored to each");

/// Bounds, edges and masks of kCornerLanes records from `first` on.
HWY_INLINE void prepare_edges(const TileMemory& tile, bool tile_hiz, std::size_t first, SmallGroup& group) {
  static_assert(offsetof(SetupTriangle, x) == 0 && offsetof(SetupTriangle, y) == 12 && offsetof(SetupTriangle, z4) == 24 &&
                offsetof(SetupTriangle, z_min) == 36 && offsetof(SetupTriangle, draw_and_culled) == 44);
  CornerVector low[4], middle[4], high[4];
  const auto fields = [&](std::size_t from) {
    return [&, from](std::size_t lane) { return reinterpret_cast<const std::int32_t*>(group.record[first + lane]) + from; };
  };
  load_fields(fields(0), low);
  load_fields(fields(4), middle);
  load_fields(fields(8), high);
  const CornerVector x[3] = {low[0], low[1], low[2]}, y[3] = {low[3], middle[0], middle[1]}, z4[3] = {middle[2], middle[3], high[0]};
  const auto set = [](std::int32_t v) HWY_ATTR { return hn::Set(kCorner, v); };
  const CornerVector zero = hn::Zero(kCorner);

  const CornerVector left = hn::Min(hn::Min(x[0], x[1]), x[2]), right = hn::Max(hn::Max(x[0], x[1]), x[2]);
  const CornerVector top = y[0], bottom = hn::Max(y[1], y[2]);  // canonical order starts at the top
  constexpr std::int32_t kToFirst = kSubpixels - 1 - kHalfPixel;  // first_pixel, last_pixel of samples.hpp
  const CornerVector origin_x = set(tile.origin.x), origin_y = set(tile.origin.y);
  const CornerVector x0 = hn::Max(hn::Sub(hn::ShiftRight<kSubpixelBits>(hn::Add(left, set(kToFirst))), origin_x), zero);
  const CornerVector y0 = hn::Max(hn::Sub(hn::ShiftRight<kSubpixelBits>(hn::Add(top, set(kToFirst))), origin_y), zero);
  const CornerVector x1 = hn::Min(hn::Sub(hn::ShiftRight<kSubpixelBits>(hn::Sub(right, set(kHalfPixel))), origin_x), set(tile.width - 1));
  const CornerVector y1 = hn::Min(hn::Sub(hn::ShiftRight<kSubpixelBits>(hn::Sub(bottom, set(kHalfPixel))), origin_y), set(tile.height - 1));
  const auto large = hn::Or(hn::Gt(hn::Sub(right, left), set(kSmallSub)), hn::Gt(hn::Sub(bottom, top), set(kSmallSub)));
  const auto outside = hn::Or(hn::Gt(x0, x1), hn::Gt(y0, y1)), culled = hn::Lt(high[3], zero);
  const auto single = hn::And(hn::Eq(x0, x1), hn::Eq(y0, y1));
  const auto behind = hn::Gt(high[1], set(tile_hiz ? static_cast<std::int32_t>(tile.tile_max) - 1 : INT32_MAX));
  const std::uint32_t large_bits = corner_bits(large), drawn_bits = kAllCorners & ~corner_bits(culled), behind_bits = corner_bits(behind);
  group.large |= large_bits << first;
  group.single |= corner_bits(single) << first;
  group.hidden |= (behind_bits & ~large_bits & drawn_bits) << first;
  group.live |= (drawn_bits & (large_bits | ~(behind_bits | corner_bits(outside)))) << first;

  if ((group.live >> first & kAllCorners) == 0) return;

  const auto first_centre = [&](CornerVector px, CornerVector origin) HWY_ATTR {
    return hn::Add(hn::ShiftLeft<kSubpixelBits>(hn::Add(px, origin)), set(kHalfPixel));
  };
  const CornerVector stamp_mask = set(~(kStampPx - 1));
  const CornerVector stamp_px = first_centre(hn::And(x0, stamp_mask), origin_x), stamp_py = first_centre(hn::And(y0, stamp_mask), origin_y);
  const CornerVector px = hn::IfThenElse(single, first_centre(x0, origin_x), stamp_px), py = hn::IfThenElse(single, first_centre(y0, origin_y), stamp_py);
  CornerVector c[3], best[3], dx[3], dy[3];
  for (int k = 0; k < 3; ++k) {
    const int n = k == 2 ? 0 : k + 1;
    dx[k] = hn::Sub(x[n], x[k]);
    dy[k] = hn::Sub(y[n], y[k]);
    const CornerVector edge = hn::Sub(hn::Mul(dx[k], hn::Sub(py, y[k])), hn::Mul(dy[k], hn::Sub(px, x[k])));
    const auto top_left = hn::Or(hn::Lt(dy[k], zero), hn::And(hn::Eq(dy[k], zero), hn::Gt(dx[k], zero)));
    const CornerVector biased = hn::Add(edge, hn::IfThenZeroElse(top_left, set(-1)));
    c[k] = hn::ShiftRight<kSubpixelBits>(biased);  // floor
    const CornerVector gain = hn::Add(hn::Max(hn::Neg(dy[k]), zero), hn::Max(dx[k], zero));
    best[k] = hn::Add(hn::Add(gain, gain), gain);
    static_assert(kStampPx - 1 == 3);
  }
  const CornerVector z_most = hn::Max(hn::Max(z4[0], z4[1]), z4[2]);
  const CornerVector z_max = hn::ShiftRight<kVertexDepthBits>(hn::Add(z_most, set(1 << (kVertexDepthBits - 1))));
  static_assert(offsetof(SmallRecord, c) == 0 && offsetof(SmallRecord, z_max) == 12 && offsetof(SmallRecord, best) == 16 && offsetof(SmallRecord, z4) == 28 &&
                offsetof(SmallRecord, step_x0) == 32 && offsetof(SmallRecord, x0) == 48 && offsetof(SmallRecord, to_x) == 64);
  const PieceRows<kSmallPieces> rows({c[0], c[1], c[2], z_max, best[0], best[1], best[2], z4[0], hn::Neg(dy[0]), dx[0], hn::Neg(dy[1]), dx[1],
                                      x0, y0, x1, y1, hn::Sub(stamp_px, x[0]), hn::Sub(stamp_py, y[0]), zero, zero});
  for (std::size_t lane = 0; lane < kCornerLanes; ++lane) rows.store(lane, reinterpret_cast<std::int32_t*>(group.small + first + lane));
  const auto store = [first](CornerVector v, std::int32_t* array) HWY_ATTR { hn::Store(v, kCorner, array + first); };
  store(dx[0], group.dx0);
  store(dy[0], group.dy0);
  store(dx[2], group.dx2);
  store(dy[2], group.dy2);
  store(hn::Sub(z4[1], z4[0]), group.dz1);
  store(hn::Sub(z4[2], z4[0]), group.dz2);
}

/// Depth slopes (depth_slope of canonical.hpp, the same operations) of kQuotientLanes records from `first` on.
HWY_INLINE void prepare_slopes(std::size_t first, SmallGroup& group) {
  const auto get = [first](const std::int32_t* array) HWY_ATTR { return hn::PromoteTo(kQuotient, hn::Load(kNumerator, array + first)); };
  // Corners 1 and 2 from corner 0: edge 0, and edge 2 backwards.
  const auto x1 = get(group.dx0), y1 = get(group.dy0), back_x2 = get(group.dx2), back_y2 = get(group.dy2);
  const auto z1 = get(group.dz1), z2 = get(group.dz2);
  const auto area2 = hn::Sub(hn::Mul(back_x2, y1), hn::Mul(x1, back_y2));
  const auto down_x = hn::Add(hn::Mul(z1, back_y2), hn::Mul(z2, y1)), down_y = hn::Add(hn::Mul(z2, x1), hn::Mul(z1, back_x2));
  const auto slope = [&](auto numerator) HWY_ATTR {
    const auto scaled = hn::Mul(hn::Div(numerator, area2), hn::Set(kQuotient, kSlopeScale));
    return hn::Max(hn::Min(scaled, hn::Set(kQuotient, kSlopeLimit)), hn::Set(kQuotient, -kSlopeLimit));
  };
  hn::Store(slope(hn::Neg(down_x)), kQuotient, group.slope_x + first);
  hn::Store(slope(down_y), kQuotient, group.slope_y + first);
}

/// Hidden ones are judged by the tile's farthest depth before the first of the group is drawn.
HWY_INLINE void prepare_group(TileMemory& tile, const SetupTriangle* records, std::size_t count, bool tile_hiz, SmallGroup& group) {
  for (std::size_t i = 0; i < kSmallGroup; ++i) group.record[i] = records + std::min(i, count - 1);
  if (tile_hiz && tile.tile_writes >= kTileWorthRefreshing) {
    std::uint32_t farthest = 0;
    for (std::size_t i = 0; i < kSmallGroup; ++i) farthest = std::max(farthest, group.record[i]->z_min);
    refresh_tile<1>(tile, farthest);
  }
  group.live = group.large = group.single = group.hidden = 0;
  for (std::size_t first = 0; first < kSmallGroup; first += kCornerLanes) prepare_edges(tile, tile_hiz, first, group);
  const std::uint32_t meant = (1u << count) - 1;
  group.live &= meant;
  group.hidden &= meant;
  if ((group.live & ~group.large) == 0) return;
  for (std::size_t first = 0; first < kSmallGroup; first += kQuotientLanes) prepare_slopes(first, group);
}

HWY_INLINE DepthSteps steps_of(const SmallGroup& group, std::size_t i) {
  const SmallRecord& t = group.small[i];
  return depth_steps(static_cast<std::int64_t>(group.slope_x[i]), static_cast<std::int64_t>(group.slope_y[i]), t.z4, t.to_x, t.to_y,
                     group.record[i]->z_min, static_cast<std::uint32_t>(t.z_max));
}

/// A record of one pixel.
template <BillRule::Kind kBill>
HWY_INLINE void draw_single(TileMemory& tile, const SmallGroup& group, std::size_t i, const KernelOptions& options, BillBuffer& bill) {
  const SmallRecord& t = group.small[i];
  if ((t.c[0] | t.c[1] | t.c[2]) < 0) return;
  draw_single_pixel<kBill>(tile, *group.record[i], steps_of(group, i), t.x0, t.y0, options, bill);
}

// Of a 4x4 square of stamps, as lanes: those in its first columns and rows, and each one's first pixel.
struct StampSquare {
  std::uint16_t columns[4], rows[4];
  std::int64_t x[16], y[16];
};
constexpr StampSquare make_stamp_square() {
  StampSquare square{};
  for (int lane = 0; lane < 16; ++lane) {
    for (int n = 0; n < 4; ++n) {
      if (lane_x(lane) <= n) square.columns[n] |= static_cast<std::uint16_t>(1u << lane);
      if (lane_y(lane) <= n) square.rows[n] |= static_cast<std::uint16_t>(1u << lane);
    }
    square.x[lane] = kStampPx * lane_x(lane);
    square.y[lane] = kStampPx * lane_y(lane);
  }
  return square;
}
constexpr StampSquare kStampSquare = make_stamp_square();

/// A record of several pixels in up to 4x4 stamps.
template <BillRule::Kind kBill>
HWY_INLINE void draw_stamps(TileMemory& tile, const SmallGroup& group, std::size_t i, const KernelOptions& options, BillBuffer& bill,
                            std::uint64_t& hidden_blocks) {
  const SmallRecord& t = group.small[i];
  const SetupTriangle& record = *group.record[i];
  const int first_stamp = stamp_at(t.x0, t.y0);
  if (options.block_hiz && ((t.x0 ^ t.x1) | (t.y0 ^ t.y1)) < kBlockPx) {
    const int block = first_stamp >> 4;
    refresh_block<1>(tile, block, record.z_min);
    if (static_cast<std::int32_t>(record.z_min) >= tile.block_max[block]) {
      ++hidden_blocks;
      return;
    }
  }
  const DepthSteps steps = steps_of(group, i);
  OpaqueStamps<1, kBill> emit(tile, record, steps, options, bill);
  Vector16 lanes[3] = {lane_plane(t.step_x0, t.step_y0), lane_plane(t.step_x1, t.step_y1), {}};
  for (std::size_t p = 0; p < kParts; ++p) lanes[2].part[p] = hn::Neg(hn::Add(lanes[0].part[p], lanes[1].part[p]));
  const int columns = (t.x1 >> 2) - (t.x0 >> 2), rows = (t.y1 >> 2) - (t.y0 >> 2);
  Coverage<1> covered;
  if ((columns | rows) == 0) {
    cover(covered, hn::Set(kTag, t.c[0]), hn::Set(kTag, t.c[1]), hn::Set(kTag, t.c[2]), lanes);
    if (covered.any != 0) emit.some(first_stamp, covered, steps.origin);
    return;
  }
  // One stamp a lane: those where each edge has a pixel inside.
  alignas(64) std::int32_t corner[3][16];  // edge values at the stamps' first pixels
  std::uint32_t rejected = 0;
  for (std::size_t p = 0; p < kParts; ++p) {
    Vector any_best = hn::Zero(kTag);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector at = hn::Add(hn::ShiftLeft<2>(lanes[k].part[p]), hn::Set(kTag, t.c[k]));
      hn::Store(at, kTag, corner[k] + p * kLanes);
      any_best = hn::Or(any_best, hn::Add(at, hn::Set(kTag, t.best[k])));
    }
    rejected |= sign_bits(any_best, p);
  }
  for (std::uint32_t left = ~rejected & kStampSquare.columns[columns] & kStampSquare.rows[rows]; left != 0; left &= left - 1) {
    const int lane = std::countr_zero(left);
    cover(covered, hn::Set(kTag, corner[0][lane]), hn::Set(kTag, corner[1][lane]), hn::Set(kTag, corner[2][lane]), lanes);
    if (covered.any == 0) continue;
    emit.some(stamp_beyond(first_stamp, lane), covered,
              steps.origin + steps.px_x * static_cast<std::uint64_t>(kStampSquare.x[lane]) + steps.px_y * static_cast<std::uint64_t>(kStampSquare.y[lane]));
  }
}

}  // namespace aluminate::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
