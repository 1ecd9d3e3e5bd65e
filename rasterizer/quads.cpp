#include "rasterizer/quads.hpp"

#include <algorithm>

namespace aluminate::raster {

void gather_visible_quads(const Frame& frame, const TileView& tile, std::vector<VisibleQuad>& quads) {
  quads.clear();
  TriangleId last = kNoTriangle;
  std::uint32_t last_draw = 0;
  bool sorted = true;
  const int samples = tile.samples;
  const auto all = static_cast<unsigned>(4 * samples);
  for (int quad = 0; quad < kTilePixels / 4; ++quad) {
    // The quad's ids, sample by sample: groups of four, 16 apart.
    const TriangleId* first = tile.visibility.data() + (quad >> 2) * samples * 16 + (quad & 3) * 4;
    const auto id = [first](unsigned bit) { return first[(bit >> 2) * 16 + (bit & 3)]; };
    unsigned left = 0;
    for (unsigned bit = 0; bit < all; ++bit) left |= static_cast<unsigned>(id(bit) != kNoTriangle) << bit;
    while (left != 0) {
      const TriangleId triangle = id(static_cast<unsigned>(std::countr_zero(left)));
      unsigned seen = 0;
      for (unsigned bit = 0; bit < all; ++bit) seen |= static_cast<unsigned>(id(bit) == triangle) << bit;
      left &= ~seen;
      if (triangle != last) {
        last = triangle;
        last_draw = frame.draw_of(triangle);
      }
      sorted = sorted && (quads.empty() || quads.back().draw <= last_draw);
      quads.push_back({triangle, last_draw, static_cast<std::uint16_t>(tile.origin.x + stamp_x(quad >> 2) + (quad & 1) * 2),
                       static_cast<std::uint16_t>(tile.origin.y + stamp_y(quad >> 2) + (quad >> 1 & 1) * 2),
                       static_cast<std::uint8_t>((seen | seen >> 4 | seen >> 8 | seen >> 12) & 0xf), static_cast<std::uint16_t>(seen)});
    }
  }
  if (!sorted)
    std::stable_sort(quads.begin(), quads.end(), [](const VisibleQuad& a, const VisibleQuad& b) { return a.draw < b.draw; });
}

}  // namespace aluminate::raster
