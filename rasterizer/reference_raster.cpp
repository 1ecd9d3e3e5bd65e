#include "rasterizer/reference_raster.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "rasterizer/canonical.hpp"
#include "rasterizer/clip.hpp"

namespace aluminate::raster {
namespace {

__extension__ using Wide = __int128;
__extension__ using UnsignedWide = unsigned __int128;

struct Corner {
  Wide x, y, z4;
};

class Reference {
 public:
  Reference(const FrameInput& input, const BillRule& bill, const ReferenceShader& shade)
      : input_(input), bill_(bill), shade_(shade), map_(input.viewport) {
    image_.width = input.viewport.width;
    image_.height = input.viewport.height;
    image_.samples = input.samples;
    const auto pixels = static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.height);
    const auto samples = pixels * static_cast<std::size_t>(input.samples);
    image_.visibility.assign(samples, kNoTriangle);
    image_.depth.assign(samples, kDepthMax);
    image_.hits.assign(samples, 0);
    image_.covered.assign(pixels, 0);
    image_.helpers.assign(pixels, 0);
    image_.billed_per_draw.assign(input.draws.size(), 0);
  }

  ReferenceImage run() {
    std::uint32_t sequence = 0;
    for (draw_ = 0; draw_ < input_.draws.size(); ++draw_) {
      const Draw& draw = input_.draws[draw_];
      for (std::uint32_t t = 0; t < draw.triangle_count; ++t, ++sequence) {
        const std::uint32_t* index = input_.indices.data() + draw.first_index + 3 * std::size_t{t};
        submit(draw.first_vertex + index[0], draw.first_vertex + index[1], draw.first_vertex + index[2], sequence);
      }
    }
    return std::move(image_);
  }

 private:
  void submit(std::size_t ia, std::size_t ib, std::size_t ic, std::uint32_t sequence) {
    const ClipPositions& p = input_.positions;
    std::array<ScreenVertex, 3> v;
    const std::size_t from[3] = {ia, ib, ic};
    std::uint32_t flags = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      v[k] = project_vertex(map_, p.x[from[k]], p.y[from[k]], p.z[from[k]], p.w[from[k]]);
      flags |= v[k].flags;
    }
    if (flags & kNonFinite) return;
    if ((flags & kCut) == 0) {
      triangle(v[0], v[1], v[2], sequence, 0);
      return;
    }
    const ClipPolygon polygon = clip_triangle(map_, {p.x[ia], p.y[ia], p.z[ia], p.w[ia], 0, 0}, {p.x[ib], p.y[ib], p.z[ib], p.w[ib], 1, 0},
                                              {p.x[ic], p.y[ic], p.z[ic], p.w[ic], 0, 1});
    std::vector<ScreenVertex> corner(static_cast<std::size_t>(polygon.count));
    for (std::size_t i = 0; i < corner.size(); ++i) {
      const ClipCorner& c = polygon.corner[i];
      if (!snap_vertex(map_, c.x, c.y, c.z, c.w, corner[i])) return;
    }
    Wide total = 0;
    for (std::size_t k = 1; k + 1 < corner.size(); ++k) total += signed_area(corner[0], corner[k], corner[k + 1]);
    for (std::size_t k = 1; k + 1 < corner.size(); ++k) triangle(corner[0], corner[k], corner[k + 1], sequence, total < 0 ? -1 : 1);
  }

  static Wide signed_area(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c) {
    return Wide{b.x - a.x} * (c.y - a.y) - Wide{c.x - a.x} * (b.y - a.y);
  }

  /// required_sign: fragments of a cut triangle that snapping folded over are not drawn; 0 = any.
  void triangle(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, std::uint32_t sequence, int required_sign) {
    const Wide area = signed_area(a, b, c);
    if (area == 0 || (required_sign != 0 && (area < 0) != (required_sign < 0))) return;
    const bool front = area < 0;  // y points down
    const CullMode cull = input_.draws[draw_].cull;
    if ((cull == CullMode::Back && !front) || (cull == CullMode::Front && front)) return;
    std::array<ScreenVertex, 3> v = front ? std::array{a, c, b} : std::array{a, b, c};
    std::rotate(v.begin(), std::min_element(v.begin(), v.end(), [](const ScreenVertex& p, const ScreenVertex& q) {
                  return p.y != q.y ? p.y < q.y : p.x < q.x;
                }), v.end());
    rasterize(v, area < 0 ? -area : area, sequence);
  }

  /// Where a pixel is sampled, from its top left corner, in sixteenths of a pixel from the centre as the specification has it.
  struct Place {
    int x, y;
  };
  Place sample_place(int sample) const {
    static constexpr Place kFour[] = {{-2, -6}, {6, -2}, {-6, 2}, {2, 6}};
    return input_.samples == 1 ? Place{kHalfPixel, kHalfPixel} : Place{kHalfPixel + 16 * kFour[sample].x, kHalfPixel + 16 * kFour[sample].y};
  }

  static bool covers(const std::array<ScreenVertex, 3>& v, int x, int y, Place place) {
    const Wide px = Wide{x} * kSubpixels + place.x, py = Wide{y} * kSubpixels + place.y;
    for (std::size_t k = 0; k < 3; ++k) {
      const ScreenVertex &from = v[k], &to = v[(k + 1) % 3];
      const Wide dx = to.x - from.x, dy = to.y - from.y;
      const Wide edge = dx * (py - from.y) - dy * (px - from.x);
      if (edge < 0) return false;
      if (edge == 0 && !(dy < 0 || (dy == 0 && dx > 0))) return false;  // on a right or bottom edge
    }
    return true;
  }

  /// The definition in canonical.hpp, in integers wide enough not to wrap before the last step.
  static std::uint32_t depth_at(const std::array<ScreenVertex, 3>& v, Wide area, int x, int y, Place place) {
    const Wide dz1 = v[1].z4 - v[0].z4, dz2 = v[2].z4 - v[0].z4;
    const auto slope = [area](Wide numerator) { return Wide{depth_slope(static_cast<std::int64_t>(numerator), static_cast<std::int64_t>(area))}; };
    const Wide slope_x = slope(dz1 * (v[2].y - v[0].y) - dz2 * (v[1].y - v[0].y));
    const Wide slope_y = slope(dz2 * (v[1].x - v[0].x) - dz1 * (v[2].x - v[0].x));
    const Wide stamp_x_sub = Wide{x - x % kStampPx} * kSubpixels + place.x, stamp_y_sub = Wide{y - y % kStampPx} * kSubpixels + place.y;
    const Wide plane = Wide{v[0].z4} * (Wide{1} << 34) + (Wide{1} << 37) + slope_x * (stamp_x_sub - v[0].x) + slope_y * (stamp_y_sub - v[0].y);
    // Slopes of slivers may overflow 64 bits on the way; the definition is modulo 2^64, and so are the steps.
    const auto shifted = [](Wide value) { return Wide{static_cast<std::int64_t>(static_cast<std::uint64_t>(static_cast<UnsignedWide>(value)))} >> 31; };
    const Wide anchor = shifted(plane);
    const Wide step_x = shifted(slope_x * 256 + (Wide{1} << 30)), step_y = shifted(slope_y * 256 + (Wide{1} << 30));
    const Wide lanes = anchor + step_x * (x % kStampPx) + step_y * (y % kStampPx);
    const Wide z = Wide{static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<UnsignedWide>(lanes)))} >> kStampDepthBits;
    const auto corner_depth = [&](std::size_t k) { return Wide{(v[k].z4 + 8) >> 4}; };
    const Wide low = std::min({corner_depth(0), corner_depth(1), corner_depth(2)}), high = std::max({corner_depth(0), corner_depth(1), corner_depth(2)});
    return static_cast<std::uint32_t>(std::clamp(z, low, high));
  }

  std::size_t at(int x, int y, int sample) const { return at(x, y) * static_cast<std::size_t>(image_.samples) + static_cast<std::size_t>(sample); }
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) + static_cast<std::size_t>(x); }

  void rasterize(const std::array<ScreenVertex, 3>& v, Wide area, std::uint32_t sequence) {
    // Generous bounds: a pixel more on each side than could matter.
    const auto [left, right] = std::minmax({v[0].x, v[1].x, v[2].x});
    const auto [top, bottom] = std::minmax({v[0].y, v[1].y, v[2].y});
    const int x0 = std::max((left >> kSubpixelBits) - 1, 0), x1 = std::min((right >> kSubpixelBits) + 1, image_.width - 1);
    const int y0 = std::max((top >> kSubpixelBits) - 1, 0), y1 = std::min((bottom >> kSubpixelBits) + 1, image_.height - 1);
    if (x0 > x1 || y0 > y1) return;
    // Stamps in the order the console would see them: tile by tile, then by stamp number.
    for (int tile_y = y0 / kTilePx; tile_y <= y1 / kTilePx; ++tile_y)
      for (int tile_x = x0 / kTilePx; tile_x <= x1 / kTilePx; ++tile_x)
        for (int s = 0; s < kStampsPerTile; ++s) {
          const int x = tile_x * kTilePx + stamp_x(s), y = tile_y * kTilePx + stamp_y(s);
          if (x > x1 || y > y1 || x + 3 < x0 || y + 3 < y0) continue;
          stamp(v, area, sequence, x, y);
        }
  }

  struct Fragment {
    int x, y, sample;
    std::uint32_t depth;
    bool passes;
  };

  void stamp(const std::array<ScreenVertex, 3>& v, Wide area, std::uint32_t sequence, int stamp_x0, int stamp_y0) {
    std::vector<Fragment> fragments;
    for (int y = stamp_y0; y < std::min(stamp_y0 + 4, image_.height); ++y)
      for (int x = stamp_x0; x < std::min(stamp_x0 + 4, image_.width); ++x)
        for (int sample = 0; sample < image_.samples; ++sample)
          if (const Place place = sample_place(sample); covers(v, x, y, place)) {
            const std::uint32_t z = depth_at(v, area, x, y, place);
            fragments.push_back({x, y, sample, z, z < image_.depth[at(x, y, sample)]});
            ++image_.hits[at(x, y, sample)];
          }
    if (fragments.empty()) return;
    bill(fragments, stamp_x0, stamp_y0);
    // A pixel's fragments lie side by side: its shader runs once for those that pass.
    for (auto first = fragments.begin(); first != fragments.end();) {
      const auto end = std::find_if(first, fragments.end(), [&](const Fragment& f) { return f.x != first->x || f.y != first->y; });
      pixel(std::span(first, end), sequence);
      first = end;
    }
  }

  void pixel(std::span<const Fragment> fragments, std::uint32_t sequence) {
    const int x = fragments.front().x, y = fragments.front().y;
    unsigned passing = 0;
    for (const Fragment& f : fragments) passing |= static_cast<unsigned>(f.passes) << f.sample;
    if (passing == 0) return;
    const Draw& draw = input_.draws[draw_];
    const bool opaque = draw.draw_class == DrawClass::Opaque;
    if (!opaque && shade_ && !shade_(draw_, sequence, x, y, passing)) return;
    for (const Fragment& f : fragments) {
      if (!f.passes) continue;
      if (opaque) image_.visibility[at(x, y, f.sample)] = sequence;
      if (draw.depth_write) image_.depth[at(x, y, f.sample)] = f.depth;
    }
  }

  /// Whether the console's hierarchical depth drops these fragments: all those of a triangle in one square.
  bool dropped(std::span<const Fragment> fragments) const {
    const int bx = fragments.front().x / bill_.block_px * bill_.block_px, by = fragments.front().y / bill_.block_px * bill_.block_px;
    std::uint32_t farthest = 0, nearest = kDepthMax;
    for (int y = by; y < std::min(by + bill_.block_px, image_.height); ++y)
      for (int x = bx; x < std::min(bx + bill_.block_px, image_.width); ++x)
        for (int sample = 0; sample < image_.samples; ++sample) farthest = std::max(farthest, image_.depth[at(x, y, sample)]);
    for (const Fragment& f : fragments) nearest = std::min(nearest, f.depth);
    return nearest >= farthest;
  }

  void bill(const std::vector<Fragment>& fragments, int stamp_x0, int stamp_y0) {
    using Kind = BillRule::Kind;
    if (bill_.kind == Kind::Off) return;
    const bool hierarchical = bill_.kind == Kind::Hierarchical;
    if (hierarchical && bill_.block_px >= kStampPx && dropped(fragments)) return;
    for (int quad = 0; quad < 4; ++quad) {
      const int qx = stamp_x0 + (quad & 1) * 2, qy = stamp_y0 + (quad >> 1) * 2;
      std::vector<Fragment> here;
      for (const Fragment& f : fragments)
        if (f.x / 2 == qx / 2 && f.y / 2 == qy / 2 && (bill_.kind != Kind::PerPixel || f.passes)) here.push_back(f);
      if (here.empty() || (hierarchical && bill_.block_px < kStampPx && dropped(here))) continue;
      std::array<bool, 4> counted{};
      for (const Fragment& f : here) counted[static_cast<std::size_t>((f.y - qy) * 2 + (f.x - qx))] = true;
      image_.billed_per_draw[draw_] += 4;
      for (int lane = 0; lane < 4; ++lane) {
        const int x = qx + (lane & 1), y = qy + (lane >> 1);
        if (x >= image_.width || y >= image_.height) continue;  // a helper outside the picture has no pixel to stand in
        ++(counted[static_cast<std::size_t>(lane)] ? image_.covered : image_.helpers)[at(x, y)];
      }
    }
  }

  const FrameInput& input_;
  const BillRule bill_;
  const ReferenceShader& shade_;
  const ScreenMap map_;
  std::uint32_t draw_ = 0;
  ReferenceImage image_;
};

}  // namespace

ReferenceImage draw_reference(const FrameInput& input, const BillRule& bill, const ReferenceShader& shade) {
  return Reference(input, bill, shade).run();
}

}  // namespace aluminate::raster
