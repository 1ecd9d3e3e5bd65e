#include "rasterizer/screen_vertex.hpp"

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rasterizer/project.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace aluminate::raster::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::ScalableTag<double>;
constexpr Tag kTag;
constexpr std::size_t kLanes = hn::MaxLanes(Tag());

/// True when every vertex of the group is finite and inside all cut planes (the common case); then x, y, z4 hold its snapped
/// position and the bits of `left` .. `top` its side flags, by the same operations as project_vertex and therefore the same
/// bits. False: one by one.
struct Group {
  double x[kLanes], y[kLanes], z4[kLanes];
  std::uint8_t left[8], right[8], bottom[8], top[8];
};
HWY_INLINE bool project_group(const ScreenMap& map, const double* px, const double* py, const double* pz, const double* pw, Group& out) {
  const auto x = hn::LoadU(kTag, px), y = hn::LoadU(kTag, py), z = hn::LoadU(kTag, pz), w = hn::LoadU(kTag, pw);
  const auto zero = hn::Zero(kTag);
  const auto half_px_x = hn::Set(kTag, map.half_x), half_px_y = hn::Set(kTag, map.half_y);
  // NaN fails every comparison, infinities one of a pair; w within these bounds keeps the quotients finite.
  const auto plausible_w = hn::And(hn::Gt(w, hn::Set(kTag, 0x1p-500)), hn::Lt(w, hn::Set(kTag, 0x1p500)));
  const auto in_depth = hn::And(hn::Ge(z, zero), hn::Ge(hn::Sub(w, z), zero));
  const auto in_x = hn::And(hn::Ge(hn::Add(hn::Mul(hn::Set(kTag, map.guard_low_x), w), hn::Mul(half_px_x, x)), zero),
                            hn::Ge(hn::Sub(hn::Mul(hn::Set(kTag, map.guard_high_x), w), hn::Mul(half_px_x, x)), zero));
  const auto in_y = hn::And(hn::Ge(hn::Sub(hn::Mul(hn::Set(kTag, map.guard_low_y), w), hn::Mul(half_px_y, y)), zero),
                            hn::Ge(hn::Add(hn::Mul(hn::Set(kTag, map.guard_high_y), w), hn::Mul(half_px_y, y)), zero));
  if (!hn::AllTrue(kTag, hn::And(hn::And(in_x, in_y), hn::And(in_depth, plausible_w)))) return false;
  const auto half_x = hn::Set(kTag, map.half_x * kSubpixels), half_y = hn::Set(kTag, map.half_y * kSubpixels);
  const auto magic = hn::Set(kTag, 0x1.8p52), limit = hn::Set(kTag, kGuardBandSub), lowest = hn::Set(kTag, -kGuardBandSub);
  const auto scale_z = hn::Set(kTag, static_cast<double>(kDepthMax) * (1 << kVertexDepthBits));
  const auto snap = [&](auto value) HWY_ATTR { return hn::Sub(hn::Add(value, magic), magic); };
  const auto hold = [&](auto value) HWY_ATTR { return hn::Min(hn::Max(value, lowest), limit); };
  hn::StoreU(hold(snap(hn::Add(hn::Mul(hn::Div(x, w), half_x), half_x))), kTag, out.x);
  hn::StoreU(hold(snap(hn::Sub(half_y, hn::Mul(hn::Div(y, w), half_y)))), kTag, out.y);
  hn::StoreU(snap(hn::Mul(hn::Div(z, w), scale_z)), kTag, out.z4);
  const auto minus_w = hn::Neg(w);
  hn::StoreMaskBits(kTag, hn::Lt(x, minus_w), out.left);
  hn::StoreMaskBits(kTag, hn::Gt(x, w), out.right);
  hn::StoreMaskBits(kTag, hn::Lt(y, minus_w), out.bottom);
  hn::StoreMaskBits(kTag, hn::Gt(y, w), out.top);
  return true;
}

void Project(const ScreenMap& map, const ClipPositions& p, std::size_t begin, std::size_t end, ScreenVertex* out) {
  std::size_t i = begin;
  for (; i + kLanes <= end; i += kLanes) {
    Group group;
    if (project_group(map, p.x.data() + i, p.y.data() + i, p.z.data() + i, p.w.data() + i, group)) {
      for (std::size_t k = 0; k < kLanes; ++k)
        out[i + k] = {static_cast<std::int32_t>(group.x[k]), static_cast<std::int32_t>(group.y[k]), static_cast<std::int32_t>(group.z4[k]),
                      static_cast<std::uint32_t>((group.left[0] >> k & 1) * kLeft | (group.right[0] >> k & 1) * kRight |
                                                 (group.bottom[0] >> k & 1) * kBottom | (group.top[0] >> k & 1) * kTop)};
    } else {
      for (std::size_t k = i; k < i + kLanes; ++k) out[k] = project_vertex(map, p.x[k], p.y[k], p.z[k], p.w[k]);
    }
  }
  for (; i < end; ++i) out[i] = project_vertex(map, p.x[i], p.y[i], p.z[i], p.w[i]);
}

}  // namespace aluminate::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace aluminate::raster {

HWY_EXPORT(Project);

void project_vertices(const ScreenMap& map, const ClipPositions& positions, std::size_t begin, std::size_t end,
                      ScreenVertex* out) {
  HWY_DYNAMIC_DISPATCH(Project)(map, positions, begin, end, out);
}

}  // namespace aluminate::raster
#endif
