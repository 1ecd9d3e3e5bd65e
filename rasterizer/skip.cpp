#include "rasterizer/skip.hpp"

namespace aluminate::raster {

SetupCounters& SetupCounters::operator+=(const SetupCounters& other) {
  submitted += other.submitted;
  dropped_nonfinite += other.dropped_nonfinite;
  frustum += other.frustum;
  outside += other.outside;
  facing += other.facing;
  small += other.small;
  degenerate += other.degenerate;
  clipped += other.clipped;
  binned += other.binned;
  bin_entries += other.bin_entries;
  return *this;
}

TileCounters& TileCounters::operator+=(const TileCounters& other) {
  tile_hiz += other.tile_hiz;
  occluded += other.occluded;
  block_hiz += other.block_hiz;
  early_z += other.early_z;
  quads_shaded += other.quads_shaded;
  return *this;
}

}  // namespace aluminate::raster
