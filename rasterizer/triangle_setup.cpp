#include "rasterizer/triangle_setup.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

#include "rasterizer/samples.hpp"

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rasterizer/triangle_setup.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "rasterizer/record_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace aluminate::raster::HWY_NAMESPACE {

HWY_INLINE CornerVector set(std::int32_t v) { return hn::Set(kCorner, v); }
HWY_INLINE CornerVector least(const CornerVector (&v)[3]) { return hn::Min(hn::Min(v[0], v[1]), v[2]); }
HWY_INLINE CornerVector most(const CornerVector (&v)[3]) { return hn::Max(hn::Max(v[0], v[1]), v[2]); }
HWY_INLINE std::uint32_t bits_with(CornerVector flags, std::uint32_t flag) {
  return corner_bits(hn::Ne(hn::And(flags, set(static_cast<std::int32_t>(flag))), hn::Zero(kCorner)));
}

/// ax by - bx ay rounded to binary32, which keeps the sign and whether it is zero of an integer below 2^48.
using Area = hn::Rebind<float, Corner>;
template <class Integers>
HWY_INLINE auto cross(Integers ax, Integers ay, Integers bx, Integers by) {
  const hn::Rebind<double, hn::DFromV<Integers>> wide;
  const auto area = hn::Sub(hn::Mul(hn::PromoteTo(wide, ax), hn::PromoteTo(wide, by)), hn::Mul(hn::PromoteTo(wide, bx), hn::PromoteTo(wide, ay)));
  return hn::DemoteTo(hn::Rebind<float, decltype(wide)>(), area);
}
HWY_INLINE hn::Vec<Area> signed_area(const CornerVector (&x)[3], const CornerVector (&y)[3]) {
  const CornerVector ax = hn::Sub(x[1], x[0]), ay = hn::Sub(y[1], y[0]), bx = hn::Sub(x[2], x[0]), by = hn::Sub(y[2], y[0]);
#if HWY_TARGET == HWY_SCALAR || HWY_MAX_BYTES >= 64
  return cross(ax, ay, bx, by);
#else
  const hn::Half<Corner> half;
  return hn::Combine(Area(), cross(hn::UpperHalf(half, ax), hn::UpperHalf(half, ay), hn::UpperHalf(half, bx), hn::UpperHalf(half, by)),
                     cross(hn::LowerHalf(half, ax), hn::LowerHalf(half, ay), hn::LowerHalf(half, bx), hn::LowerHalf(half, by)));
#endif
}

/// Lanes whose triangle (clockwise corners, bounds of few pixels) covers a sample of pixel (px, py).
template <int kSamples>
HWY_INLINE std::uint32_t touches_pixel(const CornerVector (&x)[3], const CornerVector (&y)[3], CornerVector px, CornerVector py) {
  using Pattern = SamplePattern<kSamples>;
  const CornerVector zero = hn::Zero(kCorner), corner_x = hn::ShiftLeft<kSubpixelBits>(px), corner_y = hn::ShiftLeft<kSubpixelBits>(py);
  CornerVector outside[kSamples];
  for (int s = 0; s < kSamples; ++s) outside[s] = zero;
  for (int k = 0; k < 3; ++k) {
    const int n = k == 2 ? 0 : k + 1;
    const CornerVector dx = hn::Sub(x[n], x[k]), dy = hn::Sub(y[n], y[k]);
    const CornerMask top_left = hn::Or(hn::Lt(dy, zero), hn::And(hn::Eq(dy, zero), hn::Gt(dx, zero)));
    const CornerVector bias = hn::IfThenZeroElse(top_left, set(-1)), to_x = hn::Sub(corner_x, x[k]), to_y = hn::Sub(corner_y, y[k]);
    for (int s = 0; s < kSamples; ++s) {
      const CornerVector edge = hn::Sub(hn::Mul(dx, hn::Add(to_y, set(Pattern::kY[s]))), hn::Mul(dy, hn::Add(to_x, set(Pattern::kX[s]))));
      outside[s] = hn::Or(outside[s], hn::Add(edge, bias));
    }
  }
  std::uint32_t missed = kAllCorners;
  for (int s = 0; s < kSamples; ++s) missed &= corner_bits(hn::Lt(outside[s], zero));
  return ~missed;
}
// Bounds that hold one pixel's samples alone are less than 4 pixels wide, and so is the way from it to a corner.
constexpr std::int32_t kFewPixels = 4 * kSubpixels;
static_assert(2 * kFewPixels * (2 * kFewPixels) + 1 <= INT32_MAX);

/// To: corner 0 topmost, then leftmost, cyclic order kept.
HWY_INLINE void rotate_first(CornerVector (&x)[3], CornerVector (&y)[3], CornerVector (&z)[3]) {
  const auto before = [&](int a, int b) HWY_ATTR { return hn::Or(hn::Lt(y[a], y[b]), hn::And(hn::Eq(y[a], y[b]), hn::Lt(x[a], x[b]))); };
  const CornerMask one = before(1, 0), two_before_one = before(2, 1), two_before_zero = before(2, 0);
  const CornerMask two = hn::Or(hn::And(one, two_before_one), hn::AndNot(one, two_before_zero));
  for (CornerVector* v : {x, y, z}) {
    const CornerVector a = v[0], b = v[1], c = v[2];
    v[0] = hn::IfThenElse(two, c, hn::IfThenElse(one, b, a));
    v[1] = hn::IfThenElse(two, a, hn::IfThenElse(one, c, b));
    v[2] = hn::IfThenElse(two, b, hn::IfThenElse(one, a, c));
  }
}

template <int kSamples>
std::uint32_t set_up(const TriangleRange& range, std::uint32_t begin, const SetupRule& rule, SetupOutput& out, SetupCounters& counters) {
  using Pattern = SamplePattern<kSamples>;
  const CornerVector zero = hn::Zero(kCorner);
  // first_pixel and last_pixel of samples.hpp.
  const CornerVector to_first = set(kSubpixels - 1 - Pattern::kHigh), to_last = set(Pattern::kLow);
  const CornerVector right_edge = set(rule.width - 1), bottom_edge = set(rule.height - 1);
  const auto count = [](std::uint32_t lanes) { return static_cast<std::uint64_t>(std::popcount(lanes)); };
  bool stop = false;
  while (begin < range.count && !stop) {
    std::uint32_t here = std::min(static_cast<std::uint32_t>(kCornerLanes), range.count - begin);
    CornerVector x[3], y[3], z[3], flags[3];
    const std::uint32_t* index = range.indices + std::size_t{3} * begin;
    for (std::size_t k = 0; k < 3; ++k) {
      CornerVector field[4];
      load_fields(
          [&](std::size_t lane) {
            const std::size_t triangle = here == kCornerLanes ? lane : std::min<std::size_t>(lane, here - 1);
            return reinterpret_cast<const std::int32_t*>(range.vertices + index[3 * triangle + k]);
          },
          field);
      x[k] = field[0], y[k] = field[1], z[k] = field[2], flags[k] = field[3];
    }
    std::uint32_t left = (1u << here) - 1;
    const CornerVector any_flag = hn::Or(hn::Or(flags[0], flags[1]), flags[2]);
    if (!hn::AllTrue(kCorner, hn::Eq(any_flag, zero))) {
      const std::uint32_t nonfinite = bits_with(any_flag, kNonFinite);
      const std::uint32_t beyond = rule.frustum ? bits_with(hn::And(hn::And(flags[0], flags[1]), flags[2]), kSides) & ~nonfinite : 0;
      if (const std::uint32_t cut = bits_with(any_flag, kCut) & ~(nonfinite | beyond) & left) {
        here = static_cast<std::uint32_t>(std::countr_zero(cut));
        left &= (1u << here) - 1;
        stop = true;
      }
      counters.dropped_nonfinite += count(nonfinite & left);
      counters.frustum += count(beyond & left);
      left &= ~(nonfinite | beyond);
    }
    begin += here;

    const hn::Vec<Area> area = signed_area(x, y);
    const auto no_area = hn::Eq(area, hn::Zero(Area())), negative = hn::Lt(area, hn::Zero(Area()));
    const std::uint32_t degenerate = mask_bits(Area(), no_area) & left, front = mask_bits(Area(), negative);
    const std::uint32_t culled = rule.mode == CullMode::None ? 0 : rule.mode == CullMode::Back ? ~front : front;
    const std::uint32_t facing = rule.facing ? culled & left & ~degenerate : 0;
    counters.degenerate += count(degenerate);
    counters.facing += count(facing);
    left &= ~(degenerate | facing);
    if (left == 0) continue;

    CornerVector x0 = hn::ShiftRight<kSubpixelBits>(hn::Add(least(x), to_first)), x1 = hn::ShiftRight<kSubpixelBits>(hn::Sub(most(x), to_last));
    CornerVector y0 = hn::ShiftRight<kSubpixelBits>(hn::Add(least(y), to_first)), y1 = hn::ShiftRight<kSubpixelBits>(hn::Sub(most(y), to_last));
    std::uint32_t small = corner_bits(hn::Or(hn::Gt(x0, x1), hn::Gt(y0, y1))) & left;
    if (!rule.small) {
      x1 = hn::Max(x0, x1);  // some tile near it, for the proof that it covers nothing there
      y1 = hn::Max(y0, y1);
      small = 0;
    }
    const CornerMask few = hn::And(hn::Lt(hn::Sub(x1, x0), set(1)), hn::Lt(hn::Sub(y1, y0), set(1)));  // before the viewport cuts them
    x0 = hn::Max(x0, zero);
    y0 = hn::Max(y0, zero);
    x1 = hn::Min(x1, right_edge);
    y1 = hn::Min(y1, bottom_edge);
    const std::uint32_t outside = corner_bits(hn::Or(hn::Gt(x0, x1), hn::Gt(y0, y1))) & left & ~small;
    counters.frustum += count(outside);
    left &= ~(small | outside);
    // Clockwise.
    const CornerMask swap = hn::RebindMask(kCorner, negative);
    for (CornerVector* v : {x, y, z}) {
      const CornerVector one = v[1];
      v[1] = hn::IfThenElse(swap, v[2], one);
      v[2] = hn::IfThenElse(swap, one, v[2]);
    }
    // One pixel in the bounds: often the triangle misses its samples. Cheaper to know now than to carry it to a tile.
    if (const std::uint32_t single = rule.small ? corner_bits(few) & left : 0) {
      const std::uint32_t missed = single & ~touches_pixel<kSamples>(x, y, x0, y0);
      small |= missed;
      left &= ~missed;
    }
    counters.small += count(small);
    if (left == 0) continue;

    rotate_first(x, y, z);
    const CornerVector z_min = hn::ShiftRight<kVertexDepthBits>(hn::Add(least(z), set(1 << (kVertexDepthBits - 1))));
    const CornerVector id = hn::Iota(kCorner, static_cast<std::int32_t>(range.first_id + begin - here));
    CornerVector draw = set(static_cast<std::int32_t>(range.draw));
    if (!rule.facing && rule.mode != CullMode::None) {
      const CornerVector marked = set(static_cast<std::int32_t>(range.draw | SetupTriangle::kCulled));
      draw = rule.mode == CullMode::Front ? hn::IfThenElse(swap, marked, draw) : hn::IfThenElse(swap, draw, marked);
    }
    static_assert(offsetof(SetupTriangle, x) == 0 && offsetof(SetupTriangle, y) == 12 && offsetof(SetupTriangle, z4) == 24 &&
                  offsetof(SetupTriangle, z_min) == 36 && offsetof(SetupTriangle, id) == 40 && offsetof(SetupTriangle, draw_and_culled) == 44);
    const PieceRows<3> rows({x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2], z_min, id, draw});
    constexpr int kTileBits = std::countr_zero(static_cast<unsigned>(kTilePx));
    alignas(32) std::int32_t tiles[kCornerLanes];
    hn::Store(hn::Or(hn::Or(hn::ShiftRight<kTileBits>(x0), hn::ShiftLeft<8>(hn::ShiftRight<kTileBits>(y0))),
                     hn::Or(hn::ShiftLeft<16>(hn::ShiftRight<kTileBits>(x1)), hn::ShiftLeft<24>(hn::ShiftRight<kTileBits>(y1)))),
              kCorner, tiles);
    // Every lane is stored, those left out are written over by the next: cheaper than a branch each.
    for (std::size_t lane = 0; lane < kCornerLanes; ++lane) {
      rows.store(lane, reinterpret_cast<std::int32_t*>(out.records + out.count));
      std::memcpy(out.bounds + out.count, &tiles[lane], sizeof(TileBounds));
      out.count += left >> lane & 1;
    }
  }
  return begin;
}

std::uint32_t SetUp(const TriangleRange& range, std::uint32_t begin, const SetupRule& rule, SetupOutput& out, SetupCounters& counters) {
  return (rule.samples == 1 ? set_up<1> : set_up<4>)(range, begin, rule, out, counters);
}

}  // namespace aluminate::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace aluminate::raster {

HWY_EXPORT(SetUp);

std::uint32_t set_up_triangles(const TriangleRange& range, std::uint32_t begin, const SetupRule& rule, SetupOutput& out,
                               SetupCounters& counters) {
  return HWY_DYNAMIC_DISPATCH(SetUp)(range, begin, rule, out, counters);
}

}  // namespace aluminate::raster
#endif
