// Which stamps of a tile a triangle covers: exact 32-bit edges, descent from 16x16 blocks to 4x4 stamps.
#if defined(ALUMINATE_TRIANGLE_WALK) == defined(HWY_TARGET_TOGGLE)
#ifdef ALUMINATE_TRIANGLE_WALK
#undef ALUMINATE_TRIANGLE_WALK
#else
#define ALUMINATE_TRIANGLE_WALK
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "rasterizer/canonical.hpp"
#include "rasterizer/hierarchical_depth-inl.hpp"
#include "rasterizer/stamp_lanes-inl.hpp"
#include "rasterizer/tile_kernel.hpp"

HWY_BEFORE_NAMESPACE();
namespace aluminate::raster::HWY_NAMESPACE {
// i / columns for the stamps of small bounds.
struct SmallRows {
  std::uint8_t row[5][25];
};
constexpr SmallRows make_small_rows() {
  SmallRows table{};
  for (int columns = 1; columns <= 5; ++columns)
    for (int i = 0; i < 25; ++i) table.row[columns - 1][i] = static_cast<std::uint8_t>(i / columns);
  return table;
}
constexpr SmallRows kSmallRows = make_small_rows();

/// A record in a tile: everything the stamp loops need, once.
template <int kSamples>
struct Walk {
  const SetupTriangle& record;
  DepthSteps steps;
  std::int32_t dx[3], dy[3];
  std::int32_t c[3][kSamples];  // sample covered <=> c - dy i + dx j >= 0 for the three edges, i, j pixels in the tile
  int x0, y0, x1, y1;           // pixels that can hold a sample, inclusive, tile-relative, inside the viewport
};

/// False when the bounds hold no pixel of the tile.
template <int kSamples>
HWY_INLINE bool bound(const TileMemory& tile, const SetupTriangle& t, Walk<kSamples>& walk) {
  const std::int32_t left = std::min(std::min(t.x[0], t.x[1]), t.x[2]), right = std::max(std::max(t.x[0], t.x[1]), t.x[2]);
  const std::int32_t top = t.y[0], bottom = std::max(t.y[1], t.y[2]);  // canonical order starts at the top
  walk.x0 = std::max(first_pixel<kSamples>(left) - tile.origin.x, 0);
  walk.x1 = std::min(last_pixel<kSamples>(right) - tile.origin.x, tile.width - 1);
  walk.y0 = std::max(first_pixel<kSamples>(top) - tile.origin.y, 0);
  walk.y1 = std::min(last_pixel<kSamples>(bottom) - tile.origin.y, tile.height - 1);
  return walk.x0 <= walk.x1 && walk.y0 <= walk.y1;
}

template <int kSamples>
HWY_INLINE void set_edges(const TileMemory& tile, Walk<kSamples>& walk) {
  using Pattern = SamplePattern<kSamples>;
  const SetupTriangle& t = walk.record;
  for (int k = 0; k < 3; ++k) {
    const int n = k == 2 ? 0 : k + 1;
    walk.dx[k] = t.x[n] - t.x[k];
    walk.dy[k] = t.y[n] - t.y[k];
    const std::int64_t first = biased_edge(t.x, t.y, k, tile.origin.x * kSubpixels + Pattern::kX[0], tile.origin.y * kSubpixels + Pattern::kY[0]);
    for (int s = 0; s < kSamples; ++s) {
      const std::int64_t edge = first + std::int64_t{walk.dx[k]} * (Pattern::kY[s] - Pattern::kY[0]) - std::int64_t{walk.dy[k]} * (Pattern::kX[s] - Pattern::kX[0]);
      walk.c[k][s] = static_cast<std::int32_t>(std::min(std::max(edge >> kSubpixelBits, kEdgeClampLow), kEdgeClampHigh));  // floor
    }
  }
}

/// Calls emit.some(stamp, coverage, plane) for every stamp with a covered sample, emit.all(stamp, plane) for the ones known
/// to be covered whole, emit.block(block, plane, offsets) for 16 of those, plane being the depth plane at the centre of the
/// first pixel; skips blocks hidden for sure.
/// ascending: in order of stamp numbers, which a bill with blocks above 4 px depends on; otherwise any fixed order.
template <int kSamples, class Emit>
HWY_INLINE void walk_stamps(TileMemory& tile, Walk<kSamples>& walk, bool block_hiz, bool ascending, std::uint64_t& hidden_blocks, Emit& emit) {
  const SetupTriangle& t = walk.record;
  set_edges(tile, walk);
  Vector16 lanes[3];
  Vector from_first[3][kSamples];  // edge of a sample minus edge of sample 0: the same at every pixel of the tile
  for (int k = 0; k < 3; ++k) {
    lanes[k] = lane_plane(-walk.dy[k], walk.dx[k]);
    for (int s = 1; s < kSamples; ++s) from_first[k][s] = hn::Set(kTag, walk.c[k][s] - walk.c[k][0]);
  }
  const auto stamp_inside = [&](int x, int y) HWY_ATTR -> Coverage<kSamples> {
    Vector edge[3];
    for (int k = 0; k < 3; ++k) edge[k] = hn::Set(kTag, walk.c[k][0] - walk.dy[k] * x + walk.dx[k] * y);
    Coverage<kSamples> coverage;
    if constexpr (kSamples == 1) {
      cover(coverage, edge[0], edge[1], edge[2], lanes);
      return coverage;
    }
    coverage.any = 0;
    for (int s = 0; s < kSamples; ++s) {
      std::uint32_t outside = 0;
      for (std::size_t p = 0; p < kParts; ++p) {
        Vector any = hn::Zero(kTag);
        for (int k = 0; k < 3; ++k) any = hn::Or(any, hn::Add(s > 0 ? hn::Add(edge[k], from_first[k][s]) : edge[k], lanes[k].part[p]));
        coverage.outside[s][p] = any;
        outside |= sign_bits(any, p);
      }
      coverage.bits[s] = ~outside & 0xffffu;
      coverage.any |= coverage.bits[s];
    }
    return coverage;
  };

  if (walk.x1 - walk.x0 < kBlockPx && walk.y1 - walk.y0 < kBlockPx && !ascending) {
    if (block_hiz && ((walk.x0 ^ walk.x1) | (walk.y0 ^ walk.y1)) < kBlockPx) {
      const int block = stamp_at(walk.x0, walk.y0) >> 4;
      refresh_block<kSamples>(tile, block, t.z_min);
      if (static_cast<std::int32_t>(t.z_min) >= tile.block_max[block]) {
        ++hidden_blocks;
        return;
      }
    }
    // At most 5x5 stamps, in one loop: its end is the only branch that depends on the shape of the bounds.
    const int x_first = walk.x0 & ~3, y_first = walk.y0 & ~3;
    const int columns = ((walk.x1 - x_first) >> 2) + 1, count = columns * (((walk.y1 - y_first) >> 2) + 1);
    const std::uint8_t* row_of = kSmallRows.row[columns - 1];
    for (int i = 0; i < count; ++i) {
      const int row = row_of[i], x = x_first + (i - row * columns) * kStampPx, y = y_first + row * kStampPx;
      const Coverage<kSamples> covered = stamp_inside(x, y);
      if (covered.any != 0) emit.some(stamp_at(x, y), covered, centre_plane(walk.steps, x, y));
    }
    return;
  }

  // [Abrash09]: 16 blocks of 16x16 at once, then 16 stamps of a block at once; an edge function [Pineda88] rejects a square when even its best corner is
  // outside and accepts it when its worst corner is inside.
  std::int32_t best[3], worst[3];              // per pixel of extent
  std::int32_t highest[3] = {}, lowest[3] = {};  // of the samples, relative to sample 0
  for (int k = 0; k < 3; ++k) {
    best[k] = std::max(-walk.dy[k], 0) + std::max(walk.dx[k], 0);
    worst[k] = std::min(-walk.dy[k], 0) + std::min(walk.dx[k], 0);
    for (int s = 1; s < kSamples; ++s) {
      highest[k] = std::max(highest[k], walk.c[k][s] - walk.c[k][0]);
      lowest[k] = std::min(lowest[k], walk.c[k][s] - walk.c[k][0]);
    }
  }
  const auto classify = [&](const std::int32_t (&c)[3], int square_px, int shift, std::uint32_t& reject, std::uint32_t& accept) HWY_ATTR {
    std::uint32_t rejected = 0, partial = 0;
    for (std::size_t p = 0; p < kParts; ++p) {
      Vector any_best = hn::Zero(kTag), any_worst = hn::Zero(kTag);
      for (int k = 0; k < 3; ++k) {
        const Vector edge = hn::Add(hn::Set(kTag, c[k]), hn::ShiftLeftSame(lanes[k].part[p], shift));
        any_best = hn::Or(any_best, hn::Add(edge, hn::Set(kTag, best[k] * (square_px - 1) + highest[k])));
        any_worst = hn::Or(any_worst, hn::Add(edge, hn::Set(kTag, worst[k] * (square_px - 1) + lowest[k])));
      }
      rejected |= sign_bits(any_best, p);
      partial |= sign_bits(any_worst, p);
    }
    reject = rejected;
    accept = ~partial & 0xffffu;
  };

  std::uint32_t block_reject, block_accept;
  const std::int32_t tile_c[3] = {walk.c[0][0], walk.c[1][0], walk.c[2][0]};
  classify(tile_c, kBlockPx, 4, block_reject, block_accept);
  std::uint32_t blocks = ~block_reject & 0xffffu;
  std::uint32_t in_bounds = 0;
  for (int y = walk.y0 / kBlockPx; y <= walk.y1 / kBlockPx; ++y)
    for (int x = walk.x0 / kBlockPx; x <= walk.x1 / kBlockPx; ++x) in_bounds |= 1u << (stamp_at(x * kBlockPx, y * kBlockPx) >> 4);
  blocks &= in_bounds;
  alignas(64) std::uint64_t stamp_offset[16];  // of the depth plane, within a block
  for (int i = 0; i < 16; ++i)
    stamp_offset[i] = walk.steps.px_x * static_cast<std::uint64_t>(kStampPx * lane_x(i)) + walk.steps.px_y * static_cast<std::uint64_t>(kStampPx * lane_y(i));
  while (blocks != 0) {
    const int block = std::countr_zero(blocks);
    blocks &= blocks - 1;
    if (block_hiz) {
      refresh_block<kSamples>(tile, block, t.z_min);
      if (static_cast<std::int32_t>(t.z_min) >= tile.block_max[block]) {
        ++hidden_blocks;
        continue;
      }
    }
    const int block_x = stamp_x(block << 4), block_y = stamp_y(block << 4);
    const std::uint64_t plane = centre_plane(walk.steps, block_x, block_y);
    if (block_accept >> block & 1) {
      emit.block(block, plane, stamp_offset);
      continue;
    }
    std::int32_t c[3];
    for (int k = 0; k < 3; ++k) c[k] = tile_c[k] - walk.dy[k] * block_x + walk.dx[k] * block_y;
    std::uint32_t reject, full;
    classify(c, kStampPx, 2, reject, full);
    std::uint32_t stamps = ~reject & 0xffffu;
    while (stamps != 0) {
      const int inner = std::countr_zero(stamps);
      stamps &= stamps - 1;
      const int x = block_x + kStampPx * lane_x(inner), y = block_y + kStampPx * lane_y(inner);
      const std::uint64_t stamp_plane = plane + stamp_offset[inner];
      if (full >> inner & 1) {
        emit.all(block << 4 | inner, stamp_plane);
        continue;
      }
      const Coverage<kSamples> covered = stamp_inside(x, y);
      if (covered.any != 0) emit.some(block << 4 | inner, covered, stamp_plane);
    }
  }
}

}  // namespace aluminate::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
