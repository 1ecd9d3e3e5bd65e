// From a tile's visibility to work for the shader. In: TileView after draw_opaque. Out: every visible 2x2 quad once per
// triangle in it, grouped by draw, so that full batches of one shader can be made across triangles.
#pragma once

#include <cstdint>
#include <vector>

#include "rasterizer/tile.hpp"

namespace aluminate::raster {

struct VisibleQuad {
  TriangleId triangle = kNoTriangle;
  std::uint32_t draw = 0;
  std::uint16_t x = 0, y = 0;  // absolute pixel of lane 0, even
  std::uint8_t lanes = 0;      // pixels of the quad with a sample where this triangle is visible; the others are helper lanes
  std::uint16_t samples = 0;   // those samples: bit 4 sample + lane; with one sample a pixel the same as lanes
};

/// Replaces `quads`. Sorted by draw; within a draw by position (stamp order), then by first sample and lane. The samples of
/// all entries are exactly the tile's visible samples, each once.
void gather_visible_quads(const Frame& frame, const TileView& tile, std::vector<VisibleQuad>& quads);

}  // namespace aluminate::raster
