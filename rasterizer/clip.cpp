#include "rasterizer/clip.hpp"

namespace aluminate::raster {
namespace {

ClipCorner cut_edge(int plane, const ClipCorner& inside, double inside_distance, const ClipCorner& outside,
                    double outside_distance) {
  const double t = inside_distance / (inside_distance - outside_distance);  // in [0, 1)
  ClipCorner cut;
  cut.x = inside.x + t * (outside.x - inside.x);
  cut.y = inside.y + t * (outside.y - inside.y);
  cut.z = inside.z + t * (outside.z - inside.z);
  cut.w = inside.w + t * (outside.w - inside.w);
  cut.b1 = inside.b1 + t * (outside.b1 - inside.b1);
  cut.b2 = inside.b2 + t * (outside.b2 - inside.b2);
  if (plane == kCutNear) cut.z = 0;      // rounding must not leave the depth range
  if (plane == kCutFar) cut.z = cut.w;
  return cut;
}

}  // namespace

ClipPolygon clip_triangle(const ScreenMap& map, const ClipCorner& a, const ClipCorner& b, const ClipCorner& c) {
  ClipPolygon polygon;
  polygon.corner[0] = a;
  polygon.corner[1] = b;
  polygon.corner[2] = c;
  polygon.count = 3;
  for (int plane = 0; plane < kCutPlanes; ++plane) {
    ClipPolygon kept;
    double distance[kMaxClipCorners];
    for (int i = 0; i < polygon.count; ++i) {
      const ClipCorner& v = polygon.corner[static_cast<std::size_t>(i)];
      distance[i] = cut_distance(map, plane, v.x, v.y, v.z, v.w);
    }
    const auto keep = [&kept](const ClipCorner& corner) {
      // A convex polygon gains at most one corner per plane; rounding can make it concave by an ulp, never longer than this.
      if (kept.count < kMaxClipCorners) kept.corner[static_cast<std::size_t>(kept.count++)] = corner;
    };
    for (int i = 0; i < polygon.count; ++i) {
      const int next = i + 1 == polygon.count ? 0 : i + 1;
      const ClipCorner& from = polygon.corner[static_cast<std::size_t>(i)];
      const ClipCorner& to = polygon.corner[static_cast<std::size_t>(next)];
      const bool from_inside = distance[i] >= 0, to_inside = distance[next] >= 0;
      if (from_inside) keep(from);
      if (from_inside && !to_inside) keep(cut_edge(plane, from, distance[i], to, distance[next]));
      if (!from_inside && to_inside) keep(cut_edge(plane, to, distance[next], from, distance[i]));
    }
    polygon = kept;
    if (polygon.count < 3) {
      polygon.count = 0;
      return polygon;
    }
  }
  return polygon;
}

}  // namespace aluminate::raster
