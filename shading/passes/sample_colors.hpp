// Colours of a tile's samples while it is drawn with four samples a pixel, and their resolve. In: shaded
// lanes with the samples they won. Out: linear pixels of the frame, each the mean of its samples; pixels
// nothing touched are left alone. One per worker.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "rasterizer/samples.hpp"
#include "rasterizer/tile.hpp"
#include "shading/passes/frame.hpp"

namespace aluminate::passes {

class SampleColors {
 public:
  /// samples = 1: holds nothing and must not be used.
  explicit SampleColors(int samples);

  /// Fills the samples of the tile's pixels with what the frame holds there (the background).
  void begin(const raster::TileView& tile, const Frame& frame);
  /// RGB of one sample; x, y tile-relative.
  float* at(int x, int y, int sample) {
    return colors_[static_cast<std::size_t>((y * raster::kTilePx + x) * raster::kMaxSamples + sample)].data();
  }
  /// Averages the samples of every covered pixel in linear light, rounded once (design: resolve happens in
  /// linear light).
  void resolve(const raster::TileView& tile, Frame& frame) const;

 private:
  std::vector<std::array<float, 3>> colors_;
};

}  // namespace aluminate::passes
