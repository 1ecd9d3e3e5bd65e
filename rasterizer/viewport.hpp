// The pixel rectangle drawn into and its grid of 64x64 tiles (row-major, the last column and row may be partial).
#pragma once

#include "rasterizer/limits.hpp"

namespace aluminate::raster {

struct Viewport {
  int width = 0, height = 0;  // px, 1 .. kMaxViewportPx; NDC (-1, +1) is the top left corner of pixel (0, 0)

  constexpr int tiles_x() const { return (width + kTilePx - 1) / kTilePx; }
  constexpr int tiles_y() const { return (height + kTilePx - 1) / kTilePx; }
  constexpr int tile_count() const { return tiles_x() * tiles_y(); }
  bool operator==(const Viewport&) const = default;
};

/// Absolute pixel of a tile's top left corner.
struct TileOrigin {
  int x = 0, y = 0;
};
constexpr TileOrigin tile_origin(const Viewport& viewport, int tile) {
  return {tile % viewport.tiles_x() * kTilePx, tile / viewport.tiles_x() * kTilePx};
}

}  // namespace aluminate::raster
