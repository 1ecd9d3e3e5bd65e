#include "rasterizer/triangle_cull.hpp"

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rasterizer/triangle_cull.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace aluminate::raster::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Wide = hn::CappedTag<double, 8>;             // exact integers below 2^53
using Narrow = hn::Rebind<std::int32_t, Wide>;     // as many int32
constexpr Wide kWide;
constexpr Narrow kNarrow;
using WideVector = hn::Vec<Wide>;
using NarrowVector = hn::Vec<Narrow>;
constexpr std::size_t kLanes = hn::MaxLanes(Wide());
static_assert(kCullGroup % kLanes == 0);

template <class Tag, class Mask>
HWY_INLINE std::uint32_t bits_of(Tag tag, Mask mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(tag, mask, bytes);
  return bytes[0];
}

/// Lanes where (x, y) lies inside the triangle or on a top or left edge [D3D11-FS 3.4.2]. sign: +1 clockwise, -1 counter-clockwise.
struct Corners {
  WideVector x[3], y[3], sign;
};
HWY_INLINE std::uint32_t covers(const Corners& t, WideVector x, WideVector y) {
  std::uint32_t inside = (1u << kLanes) - 1;
  for (int k = 0; k < 3; ++k) {
    const int n = k == 2 ? 0 : k + 1;
    const WideVector dx = hn::Mul(hn::Sub(t.x[n], t.x[k]), t.sign), dy = hn::Mul(hn::Sub(t.y[n], t.y[k]), t.sign);
    // Below 2^47 (limits.hpp), products and difference exact.
    const WideVector edge = hn::Sub(hn::Mul(dx, hn::Sub(y, t.y[k])), hn::Mul(dy, hn::Sub(x, t.x[k])));
    const WideVector zero = hn::Zero(kWide);
    const auto top_left = hn::Or(hn::Lt(dy, zero), hn::And(hn::Eq(dy, zero), hn::Gt(dx, zero)));
    inside &= bits_of(kWide, hn::Or(hn::Gt(edge, zero), hn::And(hn::Eq(edge, zero), top_left)));
  }
  return inside;
}

template <int kSamples>
void cull_part(const CornerGroup& corners, std::size_t first, const CullRule& rule, CullResult& result) {
  using Pattern = SamplePattern<kSamples>;
  NarrowVector x[3], y[3];
  for (int k = 0; k < 3; ++k) {
    x[k] = hn::Load(kNarrow, corners.x[k] + first);
    y[k] = hn::Load(kNarrow, corners.y[k] + first);
  }
  Corners t;
  for (int k = 0; k < 3; ++k) {
    t.x[k] = hn::PromoteTo(kWide, x[k]);
    t.y[k] = hn::PromoteTo(kWide, y[k]);
  }
  const WideVector zero = hn::Zero(kWide);
  const WideVector area = hn::Sub(hn::Mul(hn::Sub(t.x[1], t.x[0]), hn::Sub(t.y[2], t.y[0])),
                                  hn::Mul(hn::Sub(t.x[2], t.x[0]), hn::Sub(t.y[1], t.y[0])));
  const std::uint32_t all = (1u << kLanes) - 1;
  const std::uint32_t degenerate = bits_of(kWide, hn::Eq(area, zero)), front = bits_of(kWide, hn::Lt(area, zero));
  const std::uint32_t culled = rule.mode == CullMode::None ? 0 : rule.mode == CullMode::Back ? all & ~front : front;

  // first_pixel and last_pixel of samples.hpp.
  const NarrowVector to_first = hn::Set(kNarrow, kSubpixels - 1 - Pattern::kHigh), to_last = hn::Set(kNarrow, Pattern::kLow);
  const auto least = [](const NarrowVector (&v)[3]) HWY_ATTR { return hn::Min(hn::Min(v[0], v[1]), v[2]); };
  const auto most = [](const NarrowVector (&v)[3]) HWY_ATTR { return hn::Max(hn::Max(v[0], v[1]), v[2]); };
  NarrowVector x0 = hn::ShiftRight<kSubpixelBits>(hn::Add(least(x), to_first)), x1 = hn::ShiftRight<kSubpixelBits>(hn::Sub(most(x), to_last));
  NarrowVector y0 = hn::ShiftRight<kSubpixelBits>(hn::Add(least(y), to_first)), y1 = hn::ShiftRight<kSubpixelBits>(hn::Sub(most(y), to_last));
  std::uint32_t small = bits_of(kNarrow, hn::Or(hn::Gt(x0, x1), hn::Gt(y0, y1)));
  if (!rule.small) {
    x1 = hn::Max(x0, x1);  // some tile near it, for the proof that it covers nothing there
    y1 = hn::Max(y0, y1);
    small = 0;
  }
  const NarrowVector none = hn::Zero(kNarrow);
  x0 = hn::Max(x0, none);
  y0 = hn::Max(y0, none);
  x1 = hn::Min(x1, hn::Set(kNarrow, rule.width - 1));
  y1 = hn::Min(y1, hn::Set(kNarrow, rule.height - 1));
  const std::uint32_t outside = bits_of(kNarrow, hn::Or(hn::Gt(x0, x1), hn::Gt(y0, y1)));
  const std::uint32_t facing = rule.facing ? culled & ~degenerate : 0;
  std::uint32_t kept = all & ~degenerate & ~facing & ~small & ~outside, missed = 0;
  if (rule.small) {
    // One pixel in the bounds: often the triangle misses its samples. Cheaper to know now than to carry it to a tile.
    const std::uint32_t single = kept & bits_of(kNarrow, hn::And(hn::Eq(x0, x1), hn::Eq(y0, y1)));
    if (single != 0) {
      t.sign = hn::IfThenElse(hn::Lt(area, zero), hn::Set(kWide, -1.0), hn::Set(kWide, 1.0));
      const WideVector px = hn::PromoteTo(kWide, hn::ShiftLeft<kSubpixelBits>(x0)), py = hn::PromoteTo(kWide, hn::ShiftLeft<kSubpixelBits>(y0));
      std::uint32_t touched = 0;
      for (int s = 0; s < kSamples; ++s)
        touched |= covers(t, hn::Add(px, hn::Set(kWide, Pattern::kX[s])), hn::Add(py, hn::Set(kWide, Pattern::kY[s])));
      missed = single & ~touched;
    }
  }
  kept &= ~missed;
  hn::Store(x0, kNarrow, result.x0 + first);
  hn::Store(x1, kNarrow, result.x1 + first);
  hn::Store(y0, kNarrow, result.y0 + first);
  hn::Store(y1, kNarrow, result.y1 + first);
  result.kept |= kept << first;
  result.degenerate |= degenerate << first;
  result.facing |= facing << first;
  result.small |= ((small & ~degenerate & ~facing) | missed) << first;
  result.outside |= (outside & ~degenerate & ~facing & ~small) << first;
  result.culled |= (culled & kept) << first;
}

void Cull(const CornerGroup& corners, std::size_t count, const CullRule& rule, CullResult& result) {
  for (std::size_t first = 0; first < count; first += kLanes) {
    if (rule.samples == 1) cull_part<1>(corners, first, rule, result);
    else cull_part<4>(corners, first, rule, result);
  }
}

}  // namespace aluminate::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace aluminate::raster {

HWY_EXPORT(Cull);

void cull_triangles(const CornerGroup& corners, int count, const CullRule& rule, CullResult& result) {
  result.kept = result.degenerate = result.facing = result.small = result.outside = result.culled = 0;
  HWY_DYNAMIC_DISPATCH(Cull)(corners, static_cast<std::size_t>(count), rule, result);
  const std::uint32_t meant = (1u << count) - 1;
  for (std::uint32_t* mask : {&result.kept, &result.degenerate, &result.facing, &result.small, &result.outside, &result.culled}) *mask &= meant;
}

}  // namespace aluminate::raster
#endif
