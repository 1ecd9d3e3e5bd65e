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

/// True when every vertex of the group lies in the view volume (the common case, no flags); then x, y, z4 hold its snapped
/// position, by the same operations as project_vertex and therefore the same bits. False: one by one.
struct Group {
  double x[kLanes], y[kLanes], z4[kLanes];
};
HWY_INLINE bool project_group(const ScreenMap& map, const double* px, const double* py, const double* pz, const double* pw, Group& out) {
  const auto x = hn::LoadU(kTag, px), y = hn::LoadU(kTag, py), z = hn::LoadU(kTag, pz), w = hn::LoadU(kTag, pw);
  const auto zero = hn::Zero(kTag);
  // Inside the view volume means: finite, in front, inside the guard band, no side flag. NaN fails every comparison.
  const auto inside_x = hn::Le(hn::Abs(x), w), inside_y = hn::Le(hn::Abs(y), w);
  const auto inside_z = hn::And(hn::Ge(z, zero), hn::Le(z, w));
  const auto w_fine = hn::And(hn::Gt(w, hn::Set(kTag, 0x1p-500)), hn::Lt(w, hn::Set(kTag, 0x1p500)));  // quotients are finite
  if (!hn::AllTrue(kTag, hn::And(hn::And(inside_x, inside_y), hn::And(inside_z, w_fine)))) return false;
  const auto half_x = hn::Set(kTag, map.half_x * kSubpixels), half_y = hn::Set(kTag, map.half_y * kSubpixels);
  const auto magic = hn::Set(kTag, 0x1.8p52);
  const auto scale_z = hn::Set(kTag, static_cast<double>(kDepthMax) * (1 << kVertexDepthBits));
  const auto snap = [&](auto value) HWY_ATTR { return hn::Sub(hn::Add(value, magic), magic); };
  hn::StoreU(snap(hn::Add(hn::Mul(hn::Div(x, w), half_x), half_x)), kTag, out.x);
  hn::StoreU(snap(hn::Sub(half_y, hn::Mul(hn::Div(y, w), half_y))), kTag, out.y);
  hn::StoreU(snap(hn::Mul(hn::Div(z, w), scale_z)), kTag, out.z4);
  return true;
}

void Project(const ScreenMap& map, const ClipPositions& p, std::size_t begin, std::size_t end, ScreenVertex* out) {
  std::size_t i = begin;
  for (; i + kLanes <= end; i += kLanes) {
    Group group;
    if (project_group(map, p.x.data() + i, p.y.data() + i, p.z.data() + i, p.w.data() + i, group)) {
      for (std::size_t k = 0; k < kLanes; ++k)
        out[i + k] = {static_cast<std::int32_t>(group.x[k]), static_cast<std::int32_t>(group.y[k]), static_cast<std::int32_t>(group.z4[k]), 0};
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
