// The hot loops of the tile stage, compiled for every vector unit and picked at run time: 16 int32 lanes are one 4x4 stamp.
// In: records of one tile. Out: depth, visibility and billed stamps, or the fragments of one triangle. Integers, and binary64
// quotients of exact integers (depth slopes): every vector unit gives the same bits. Used by tile.cpp alone.
// The idea of each part is in a file of its own: stamp_lanes (16 pixels as vectors), hierarchical_depth, triangle_walk (any
// triangle to stamps), small_triangles (the same, eight prepared at once), opaque_stamps (depth test, visibility, bill).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "rasterizer/bill.hpp"
#include "rasterizer/limits.hpp"
#include "rasterizer/samples.hpp"
#include "rasterizer/triangle.hpp"

namespace aluminate::raster {

/// Billed stamps on their way to the sink.
struct BillBuffer {
  static constexpr std::size_t kCapacity = 1024;
  static_assert(kCapacity >= 2 * kStampsPerTile, "a triangle's stamps always fit after a flush");
  BillSink* sink = nullptr;
  std::size_t count = 0;
  BilledStamp stamps[kCapacity];

  void flush() {
    if (count != 0 && sink != nullptr) sink->billed({stamps, count});
    count = 0;
  }
};

/// One worker's tile. Stamp-major: element 16 (samples stamp + sample) + lane, so a 16x16 block is 256 samples consecutive
/// elements. With one sample a pixel only the first quarter of the arrays is touched: 32 KiB, with four 128 KiB.
struct alignas(64) TileMemory {
  std::uint32_t depth[kTilePixels * kMaxSamples];  // 0 outside the viewport: nothing passes there, maxima are the inside's
  std::uint32_t visibility[kTilePixels * kMaxSamples];
  std::uint16_t inside[kStampsPerTile];    // lanes inside the viewport
  std::int32_t block_max[16];              // >= every depth of the block, exact after refresh
  std::uint32_t block_writes[16];          // samples written since the last refresh of the block
  std::uint32_t tile_max = 0;              // >= every block_max
  std::uint32_t tile_writes = 0;           // since tile_max was computed
  TileOrigin origin;
  int width = 0, height = 0;               // pixels inside the viewport
  int middle = 0;                          // element whose depth stands for the tile's when a refresh is considered
};

struct KernelOptions {
  BillRule bill;
  int samples = 1;
  bool occluded = true, tile_hiz = true, block_hiz = true;  // false also where the bill needs the coverage of hidden triangles
};

struct HizCounters {
  std::uint64_t tile = 0, block = 0;
};

/// Depth to kDepthMax, visibility to kNoTriangle.
void clear_tile(TileMemory& tile, int samples);

/// Whether nothing as far as z_min can be seen in the tile.
bool tile_hides(TileMemory& tile, std::uint32_t z_min, int samples);

/// Depth-tests and draws Opaque records in order.
void draw_opaque_records(TileMemory& tile, const SetupTriangle* records, std::size_t count, const KernelOptions& options,
                         BillBuffer& bill, HizCounters& counters);

/// A triangle's covered stamps in a tile, not depth-tested. Sample s of entry i is element samples i + s.
struct StampFragments {
  int count = 0;
  std::uint8_t stamp[kStampsPerTile];
  std::uint16_t covered[kStampsPerTile * kMaxSamples];  // lanes inside the viewport; of an entry not all 0
  alignas(64) std::uint32_t depth[kStampsPerTile * kMaxSamples][16];
};
/// Stamps hidden for sure are left out when hierarchical depth is on.
void find_fragments(TileMemory& tile, const SetupTriangle& record, const KernelOptions& options, StampFragments& fragments,
                    HizCounters& counters);

}  // namespace aluminate::raster
