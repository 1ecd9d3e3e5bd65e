#include "shading/passes/sample_colors.hpp"

#include <algorithm>

namespace aluminate::passes {
namespace {

template <class Visit>
void for_each_pixel(const raster::TileView& tile, const Frame& frame, Visit&& visit) {
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < tile.width; ++x) {
      const auto px = static_cast<std::size_t>(tile.origin.x + x),
                 py = static_cast<std::size_t>(tile.origin.y + y);
      visit(static_cast<std::size_t>((y * raster::kTilePx + x) * raster::kMaxSamples),
            py * static_cast<std::size_t>(frame.width) + px);
    }
}

}  // namespace

SampleColors::SampleColors(int samples) {
  if (samples > 1) colors_.resize(static_cast<std::size_t>(raster::kTilePixels * raster::kMaxSamples));
}

void SampleColors::begin(const raster::TileView& tile, const Frame& frame) {
  for_each_pixel(tile, frame, [&](std::size_t first, std::size_t pixel) {
    const float* from = &frame.linear[pixel * 4];
    std::fill_n(colors_.begin() + static_cast<std::ptrdiff_t>(first), raster::kMaxSamples,
                std::array<float, 3>{from[0], from[1], from[2]});
  });
}

void SampleColors::resolve(const raster::TileView& tile, Frame& frame) const {
  for_each_pixel(tile, frame, [&](std::size_t first, std::size_t pixel) {
    if (!frame.covered[pixel]) return;
    for (std::size_t c = 0; c < 3; ++c) {
      // In this order, in binary64: sums of four binary32 of similar size are exact, so that equal samples
      // keep their colour.
      const double sum = (double{colors_[first][c]} + double{colors_[first + 1][c]}) +
                         (double{colors_[first + 2][c]} + double{colors_[first + 3][c]});
      frame.linear[pixel * 4 + c] = static_cast<float>(sum * 0.25);
    }
  });
}

}  // namespace aluminate::passes
