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

/// A unit of work: a tile (its number), or one of the four quarters of a tile that holds much of the frame. A quarter is drawn
/// as a tile of 32x32 pixels of its own: stamps, blocks and quads lie in it as they lie in the tile.
struct TileTask {
  int tile = 0;
  TileOrigin origin{};
  int size_px = kTilePx;
};
/// Number of quarter 0 .. 3 (bit 0 right, bit 1 below) of a tile; numbers below tile_count() are whole tiles.
constexpr int quarter_task(const Viewport& viewport, int tile, int quarter) { return tile + (quarter + 1) * viewport.tile_count(); }
constexpr TileTask tile_task(const Viewport& viewport, int number) {
  const int tile = number % viewport.tile_count(), quarter = number / viewport.tile_count() - 1;
  TileTask task{tile, tile_origin(viewport, tile), kTilePx};
  if (quarter < 0) return task;
  task.size_px = kTilePx / 2;
  task.origin.x += (quarter & 1) * task.size_px;
  task.origin.y += (quarter >> 1) * task.size_px;
  return task;
}

}  // namespace aluminate::raster
