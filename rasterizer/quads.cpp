#include "rasterizer/quads.hpp"

#include <algorithm>

namespace aluminate::raster {

void gather_visible_quads(const Frame& frame, const TileView& tile, std::vector<VisibleQuad>& quads) {
  quads.clear();
  TriangleId last = kNoTriangle;
  std::uint32_t last_draw = 0;
  bool sorted = true;
  for (int quad = 0; quad < kTilePixels / 4; ++quad) {
    const TriangleId* id = tile.visibility.data() + 4 * quad;
    unsigned left = 0;
    for (unsigned l = 0; l < 4; ++l) left |= static_cast<unsigned>(id[l] != kNoTriangle) << l;
    while (left != 0) {
      const TriangleId triangle = id[std::countr_zero(left)];
      unsigned lanes = 0;
      for (unsigned l = 0; l < 4; ++l) lanes |= static_cast<unsigned>(id[l] == triangle) << l;
      left &= ~lanes;
      if (triangle != last) {
        last = triangle;
        last_draw = frame.draw_of(triangle);
      }
      sorted = sorted && (quads.empty() || quads.back().draw <= last_draw);
      quads.push_back({triangle, last_draw, static_cast<std::uint16_t>(tile.origin.x + stamp_x(quad >> 2) + (quad & 1) * 2),
                       static_cast<std::uint16_t>(tile.origin.y + stamp_y(quad >> 2) + (quad >> 1 & 1) * 2),
                       static_cast<std::uint8_t>(lanes)});
    }
  }
  if (!sorted)
    std::stable_sort(quads.begin(), quads.end(), [](const VisibleQuad& a, const VisibleQuad& b) { return a.draw < b.draw; });
}

}  // namespace aluminate::raster
