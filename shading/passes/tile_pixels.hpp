// Pixels of one tile in the planes of a frame: cleared where the tile begins, stored quad by quad, encoded when it is done,
// so that each plane passes through the cache once. In: shaded rows of 64 lanes. Out: linear, covered, path and, without a
// tone map, stored display values.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

#include "rasterizer/interpolate.hpp"
#include "shading/passes/frame.hpp"

namespace aluminate::passes {

/// Pixels [x, x + width) x [y, y + height) of a frame.
struct PixelRect {
  int x = 0, y = 0, width = 0, height = 0;
};

/// What a picture is cleared to.
struct Background {
  /// stored: display values in [0, 1].
  explicit Background(const glm::dvec3& stored);
  std::array<float, 4> linear;         // so that blending over it is right
  std::array<std::uint8_t, 4> stored;  // what is kept where nothing was drawn
};

/// Where a tile's draws begin: linear the background's, covered and path 0.
void clear_pixels(const Background& background, const PixelRect& rect, Frame& frame);

/// All planes of a tile in which nothing is drawn.
void blank_pixels(const Background& background, const PixelRect& rect, Frame& frame);

/// Writes linear, covered and path of the pixels in `lanes` (lane 4 q + l is pixel l of quad q). rgb: rows of 64 doubles.
void store_quads(std::span<const raster::QuadPosition> quads, std::uint64_t lanes, std::uint32_t path,
                 const std::array<const double*, 3>& rgb, Frame& frame);

/// rgba8 from linear where anything was drawn, else the background.
void encode_pixels(const Background& background, const PixelRect& rect, Frame& frame);

}  // namespace aluminate::passes
