// Hierarchical depth of a tile: the farthest depth of each 16x16 block and of the tile, recomputed only when enough was
// written for a record to profit from it.
#if defined(ALUMINATE_HIERARCHICAL_DEPTH) == defined(HWY_TARGET_TOGGLE)
#ifdef ALUMINATE_HIERARCHICAL_DEPTH
#undef ALUMINATE_HIERARCHICAL_DEPTH
#else
#define ALUMINATE_HIERARCHICAL_DEPTH
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "rasterizer/stamp_lanes-inl.hpp"
#include "rasterizer/tile_kernel.hpp"

HWY_BEFORE_NAMESPACE();
namespace aluminate::raster::HWY_NAMESPACE {
/// Recomputes the maxima a record could profit from. A sample the record does not lie behind proves a block visible, so one
/// sample spares most recomputations. Results never depend on when this happens, only counters would; it depends on the
/// tile's own records alone, so they do not either.
constexpr std::uint32_t kTileWorthRefreshing = 1024;  // pixels written
template <int kSamples>
HWY_INLINE void refresh_tile(TileMemory& tile, std::uint32_t z_min) {
  if (tile.tile_writes < kTileWorthRefreshing * kSamples || z_min < tile.depth[tile.middle]) return;
  std::uint32_t most = 0;
  for (int block = 0; block < 16; ++block) {
    if (tile.block_writes[block] != 0) {
      tile.block_max[block] = static_cast<std::int32_t>(max_of_depths(tile.depth + block * 256 * kSamples, 16 * kSamples));
      tile.block_writes[block] = 0;
    }
    most = std::max(most, static_cast<std::uint32_t>(tile.block_max[block]));
  }
  tile.tile_max = most;
  tile.tile_writes = 0;
}

template <int kSamples>
HWY_INLINE void refresh_block(TileMemory& tile, int block, std::uint32_t z_min) {
  constexpr std::uint32_t kWorthwhile = 128 * kSamples;  // samples
  if (tile.block_writes[block] < kWorthwhile || z_min < tile.depth[(block * 256 + 128) * kSamples]) return;
  tile.block_max[block] = static_cast<std::int32_t>(max_of_depths(tile.depth + block * 256 * kSamples, 16 * kSamples));
  tile.block_writes[block] = 0;
}

}  // namespace aluminate::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
