// Work the rasterizer can leave out, by name. Image and bill are the same with any of them off; the counters say what each
// one saved. Counters are sums over triangles, tiles or quads and therefore do not depend on threads or order.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace aluminate::raster {

enum class Skip : std::uint8_t {
  Frustum,     // triangles wholly beyond one side of the view volume are not set up
  Facing,      // culled faces are not binned
  Small,       // triangles that contain no sample are not binned
  TileHiz,     // a triangle behind everything in a tile is not walked there
  BlockHiz,    // ... in a 16x16 block
  EarlyZ,      // in-order quads with no pixel in front are not given to the shader
  EmptyTiles,  // tiles no triangle touches are not rasterized
  Occluded,    // runs of a tile's triangles that lie behind everything in it are not even read
};
inline constexpr std::array<std::string_view, 8> kSkipNames = {"frustum",   "facing",  "small",       "tile_hiz",
                                                               "block_hiz", "early_z", "empty_tiles", "occluded"};

struct SkipSet {
  std::uint8_t off = 0;  // bit per Skip
  constexpr bool on(Skip skip) const { return (off >> static_cast<int>(skip) & 1) == 0; }
  constexpr void disable(Skip skip) { off |= static_cast<std::uint8_t>(1 << static_cast<int>(skip)); }
  static constexpr SkipSet none() { return {0xff}; }
};

/// What set-up did with the triangles of a frame.
struct SetupCounters {
  std::uint64_t submitted = 0;          // triangles
  std::uint64_t dropped_nonfinite = 0;  // a corner holds NaN or infinity, or does not divide: dropped whole
  std::uint64_t frustum = 0, facing = 0, small = 0;  // skipped triangles or fragments, by name
  std::uint64_t outside = 0;            // triangles of draws said to be outside (Draw::outside)
  std::uint64_t degenerate = 0;         // zero area after snapping
  std::uint64_t clipped = 0;            // triangles cut by the near or far plane or the guard band
  std::uint64_t binned = 0;             // triangles or fragments that reached at least one tile
  std::uint64_t bin_entries = 0;        // (triangle, tile) pairs
  SetupCounters& operator+=(const SetupCounters& other);
  bool operator==(const SetupCounters&) const = default;
};

/// What the tile stage did.
struct TileCounters {
  std::uint64_t tile_hiz = 0;   // (triangle, tile) pairs not walked
  std::uint64_t occluded = 0;   // (triangle, tile) pairs not even read
  std::uint64_t block_hiz = 0;  // (triangle, 16x16 block) pairs not walked
  std::uint64_t early_z = 0;    // in-order quads not given to the shader
  std::uint64_t quads_shaded = 0;  // in-order quads given to the shader
  TileCounters& operator+=(const TileCounters& other);
  bool operator==(const TileCounters&) const = default;
};

}  // namespace aluminate::raster
