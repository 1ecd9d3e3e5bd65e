#include "rasterizer/tile_kernel.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "rasterizer/canonical.hpp"

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rasterizer/tile_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace aluminate::raster::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// 16 lanes as 1, 2 or 4 vectors.
using Tag = hn::CappedTag<std::int32_t, 16>;
using Vector = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;
constexpr Tag kTag;
constexpr std::size_t kLanes = hn::MaxLanes(Tag());
constexpr std::size_t kParts = 16 / kLanes;
static_assert(kParts * kLanes == 16);

struct Vector16 {
  Vector part[kParts];
};

alignas(64) constexpr std::int32_t kLaneX[16] = {0, 1, 0, 1, 2, 3, 2, 3, 0, 1, 0, 1, 2, 3, 2, 3};
alignas(64) constexpr std::int32_t kLaneY[16] = {0, 0, 1, 1, 0, 0, 1, 1, 2, 2, 3, 3, 2, 2, 3, 3};

HWY_INLINE std::uint32_t bits_of(Mask mask, std::size_t part) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(kTag, mask, bytes);
  std::uint16_t bits;
  std::memcpy(&bits, bytes, sizeof bits);
  return static_cast<std::uint32_t>(bits) << (part * kLanes);
}

HWY_INLINE Vector16 broadcast(std::int32_t value) {
  Vector16 out;
  for (std::size_t p = 0; p < kParts; ++p) out.part[p] = hn::Set(kTag, value);
  return out;
}

/// x * lane_x + y * lane_y, modulo 2^32.
HWY_INLINE Vector16 lane_plane(std::int32_t x, std::int32_t y) {
  Vector16 out;
  for (std::size_t p = 0; p < kParts; ++p)
    out.part[p] = hn::Add(hn::Mul(hn::Set(kTag, x), hn::Load(kTag, kLaneX + p * kLanes)),
                          hn::Mul(hn::Set(kTag, y), hn::Load(kTag, kLaneY + p * kLanes)));
  return out;
}

/// Covered lanes of a stamp by sample, as masks and as bits.
template <int kSamples>
struct Coverage {
  Mask mask[kSamples][kParts];
  std::uint32_t bits[kSamples];
  std::uint32_t any;  // lanes with a covered sample
};

/// Every sample covered; only the bits, the masks are not read then.
template <int kSamples>
HWY_INLINE Coverage<kSamples> everything() {
  Coverage<kSamples> every;
  for (std::uint32_t& bits : every.bits) bits = 0xffff;
  every.any = 0xffff;
  return every;
}

/// Maximum over `count` consecutive groups of 16.
HWY_INLINE std::uint32_t max_of_depths(const std::uint32_t* depth, int count) {
  Vector most = hn::Zero(kTag);
  for (std::size_t i = 0; i < static_cast<std::size_t>(count) * kParts; ++i)
    most = hn::Max(most, hn::Load(kTag, reinterpret_cast<const std::int32_t*>(depth) + i * kLanes));
  return static_cast<std::uint32_t>(hn::GetLane(hn::MaxOfLanes(kTag, most)));
}

/// Recomputes the maxima a record could profit from. A sample the record does not lie behind proves a block visible, so one
/// sample spares most recomputations. Results never depend on when this happens, only counters would; it depends on the
/// tile's own records alone, so they do not either.
template <int kSamples>
HWY_INLINE void refresh_tile(TileMemory& tile, std::uint32_t z_min) {
  constexpr std::uint32_t kWorthwhile = 1024 * kSamples;  // samples
  if (tile.tile_writes < kWorthwhile || z_min < tile.depth[kTilePixels * kSamples / 2]) return;
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

// Stamp number from the stamp's column and row in the tile: one or of two table entries.
struct StampNumbers {
  std::uint8_t column[16], row[16];
};
constexpr StampNumbers make_stamp_numbers() {
  StampNumbers numbers{};
  for (int i = 0; i < 16; ++i) {
    numbers.column[i] = static_cast<std::uint8_t>(stamp_of(i * kStampPx, 0));
    numbers.row[i] = static_cast<std::uint8_t>(stamp_of(0, i * kStampPx));
  }
  return numbers;
}
constexpr StampNumbers kStampNumbers = make_stamp_numbers();
HWY_INLINE int stamp_at(int x, int y) { return kStampNumbers.column[x >> 2] | kStampNumbers.row[y >> 2]; }

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
  // Lanes where none of the three edges is negative, from the edges of sample 0.
  const auto inside = [&](const Vector16 (&edge)[3]) HWY_ATTR -> Coverage<kSamples> {
    Coverage<kSamples> coverage;
    coverage.any = 0;
    for (int s = 0; s < kSamples; ++s) {
      coverage.bits[s] = 0;
      for (std::size_t p = 0; p < kParts; ++p) {
        Vector a = edge[0].part[p], b = edge[1].part[p], c = edge[2].part[p];
        if (s > 0) {
          a = hn::Add(a, from_first[0][s]);
          b = hn::Add(b, from_first[1][s]);
          c = hn::Add(c, from_first[2][s]);
        }
        coverage.mask[s][p] = hn::Gt(hn::Or(hn::Or(a, b), c), hn::Set(kTag, -1));
        coverage.bits[s] |= bits_of(coverage.mask[s][p], p);
      }
      coverage.any |= coverage.bits[s];
    }
    return coverage;
  };
  const auto stamp_inside = [&](int x, int y) HWY_ATTR -> Coverage<kSamples> {
    Vector16 edge[3];
    for (int k = 0; k < 3; ++k) {
      const Vector16 base = broadcast(walk.c[k][0] - walk.dy[k] * x + walk.dx[k] * y);
      for (std::size_t p = 0; p < kParts; ++p) edge[k].part[p] = hn::Add(base.part[p], lanes[k].part[p]);
    }
    return inside(edge);
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
      rejected |= bits_of(hn::Lt(any_best, hn::Zero(kTag)), p);
      partial |= bits_of(hn::Lt(any_worst, hn::Zero(kTag)), p);
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

/// Depth of 16 lanes (canonical.hpp).
template <int kSamples>
struct StampDepth {
  Vector16 offset;      // i gx + j gy
  Vector low, high;
  std::uint64_t to_sample[kSamples];
  HWY_INLINE explicit StampDepth(const DepthSteps& steps)
      : offset(lane_plane(static_cast<std::int32_t>(steps.lane_x), static_cast<std::int32_t>(steps.lane_y))),
        low(hn::Set(kTag, steps.z_min)),
        high(hn::Set(kTag, steps.z_max)) {
    for (int s = 0; s < kSamples; ++s) to_sample[s] = sample_plane<kSamples>(steps, s);
  }
  HWY_INLINE std::uint32_t anchor(std::uint64_t plane, int sample) const { return anchor_of(plane + to_sample[sample]); }
  HWY_INLINE Vector at(std::uint32_t anchor, std::size_t p) const {
    const Vector z = hn::ShiftRight<kStampDepthBits>(hn::Add(hn::Set(kTag, static_cast<std::int32_t>(anchor)), offset.part[p]));
    return hn::Min(hn::Max(z, low), high);
  }
};

/// Depth at the centre of one lane, the same definition.
HWY_INLINE std::uint32_t pixel_depth(const Walk<1>& walk, int stamp, int lane) {
  const std::uint32_t anchor = anchor_of(centre_plane(walk.steps, stamp_x(stamp), stamp_y(stamp)));
  const std::uint32_t lanes = anchor + walk.steps.lane_x * static_cast<std::uint32_t>(lane_x(lane)) + walk.steps.lane_y * static_cast<std::uint32_t>(lane_y(lane));
  const std::int32_t z = static_cast<std::int32_t>(lanes) >> kStampDepthBits;
  return static_cast<std::uint32_t>(std::clamp(z, walk.steps.z_min, walk.steps.z_max));
}

/// Whether depth `nearest` lies before the stored maximum of the bill's block: decides a stamp none of whose samples passes.
template <int kSamples>
HWY_INLINE bool passes_block(const TileMemory& tile, const BillRule& rule, int stamp, std::uint32_t nearest) {
  const int log2_stamps = rule.block_px == 4 ? 0 : rule.block_px == 8 ? 2 : 4;
  const int first = stamp >> log2_stamps << log2_stamps;
  return nearest < max_of_depths(tile.depth + first * 16 * kSamples, kSamples << log2_stamps);
}

/// Draws the stamps of one opaque record.
template <int kSamples, BillRule::Kind kBill>
struct OpaqueStamps {
  using Kind = BillRule::Kind;
  using Covered = Coverage<kSamples>;
  TileMemory& tile;
  const SetupTriangle& record;
  const KernelOptions& options;
  BillBuffer& bill;
  StampDepth<kSamples> depth;
  Vector id;

  HWY_INLINE OpaqueStamps(TileMemory& t, const Walk<kSamples>& w, const KernelOptions& o, BillBuffer& b)
      : tile(t), record(w.record), options(o), bill(b), depth(w.steps), id(hn::Set(kTag, static_cast<std::int32_t>(w.record.id))) {}

  HWY_INLINE void record_bill(int stamp, std::uint32_t lanes) {
    bill.stamps[bill.count++] = {record.draw(), static_cast<std::uint16_t>(lanes), static_cast<std::uint8_t>(stamp)};
  }
  HWY_INLINE void count_writes(int stamp, std::uint32_t samples) {
    tile.block_writes[stamp >> 4] += samples;
    tile.tile_writes += samples;
  }

  HWY_INLINE void all(int stamp, std::uint64_t plane) { count_writes(stamp, draw<true>(stamp, everything<kSamples>(), plane)); }
  HWY_INLINE void some(int stamp, const Covered& covered, std::uint64_t plane) { count_writes(stamp, draw<false>(stamp, covered, plane)); }
  HWY_INLINE void block(int number, std::uint64_t plane, const std::uint64_t* offsets) {
    const Covered every = everything<kSamples>();
    std::uint32_t written = 0;
    for (int i = 0; i < 16; ++i) written += draw<true>(number << 4 | i, every, plane + offsets[i]);
    count_writes(number << 4, written);
  }

  /// Returns the number of samples written.
  template <bool kAll>
  HWY_INLINE std::uint32_t draw(int stamp, const Covered& covered, std::uint64_t plane) {
    auto* stored = reinterpret_cast<std::int32_t*>(tile.depth) + stamp * 16 * kSamples;
    auto* visible = reinterpret_cast<std::int32_t*>(tile.visibility) + stamp * 16 * kSamples;
    std::uint32_t pass[kSamples], any_pass = 0;
    Vector16 z[kSamples], old[kSamples];
    Mask nearer[kSamples][kParts];
    for (int s = 0; s < kSamples; ++s) {
      pass[s] = 0;
      const std::uint32_t anchor = depth.anchor(plane, s);
      for (std::size_t p = 0; p < kParts; ++p) {
        z[s].part[p] = depth.at(anchor, p);
        old[s].part[p] = hn::Load(kTag, stored + s * 16 + p * kLanes);
        nearer[s][p] = hn::Lt(z[s].part[p], old[s].part[p]);
        if constexpr (!kAll) nearer[s][p] = hn::And(covered.mask[s][p], nearer[s][p]);
        pass[s] |= bits_of(nearer[s][p], p);
      }
      any_pass |= pass[s];
    }
    if constexpr (kBill == Kind::Everything) {
      const std::uint32_t lanes = covered.any & tile.inside[stamp];
      if (lanes != 0) record_bill(stamp, lanes);
    } else if constexpr (kBill == Kind::PerPixel) {
      if (any_pass != 0) record_bill(stamp, any_pass);
    } else if constexpr (kBill == Kind::Hierarchical) {
      std::uint32_t lanes = covered.any & tile.inside[stamp];
      if constexpr (kSamples > 1) {
        if (options.bill.block_px == 2) lanes = quads_that_reach(stamp, z, covered, lanes, any_pass);
        else if (any_pass == 0 && lanes != 0 && !reaches_block(stamp, z, covered, lanes)) lanes = 0;
        if (lanes != 0) record_bill(stamp, lanes);
      } else {
        // A pixel that passes is nearer than the block's maximum; otherwise the maximum has to be known.
        if (any_pass != 0 || (lanes != 0 && reaches_block(stamp, z, covered, lanes))) record_bill(stamp, lanes);
      }
    }
    if (any_pass == 0) return 0;
    std::uint32_t written = 0;
    for (int s = 0; s < kSamples; ++s) {
      if (kSamples > 1 && pass[s] == 0) continue;
      if (pass[s] == 0xffff) {
        for (std::size_t p = 0; p < kParts; ++p) {
          hn::Store(z[s].part[p], kTag, stored + s * 16 + p * kLanes);
          hn::Store(id, kTag, visible + s * 16 + p * kLanes);
        }
        written += 16;
        continue;
      }
      for (std::size_t p = 0; p < kParts; ++p) {
        // Whole stores: the next triangle's load can be forwarded from them, from masked ones it cannot.
        hn::Store(hn::IfThenElse(nearer[s][p], z[s].part[p], old[s].part[p]), kTag, stored + s * 16 + p * kLanes);
        hn::Store(hn::IfThenElse(nearer[s][p], id, hn::Load(kTag, visible + s * 16 + p * kLanes)), kTag, visible + s * 16 + p * kLanes);
      }
      written += static_cast<std::uint32_t>(std::popcount(pass[s]));
    }
    return written;
  }

  /// The nearest covered sample of `lanes`.
  HWY_INLINE std::uint32_t nearest_of(const Vector16 (&z)[kSamples], const Covered& covered, std::uint32_t lanes) const {
    alignas(64) std::uint32_t lane_depth[16];
    std::uint32_t nearest = kDepthMax;
    for (int s = 0; s < kSamples; ++s) {
      for (std::size_t p = 0; p < kParts; ++p) hn::Store(z[s].part[p], kTag, reinterpret_cast<std::int32_t*>(lane_depth) + p * kLanes);
      for (std::uint32_t left = lanes & covered.bits[s]; left != 0; left &= left - 1) nearest = std::min(nearest, lane_depth[std::countr_zero(left)]);
    }
    return nearest;
  }

  HWY_INLINE bool reaches_block(int stamp, const Vector16 (&z)[kSamples], const Covered& covered, std::uint32_t lanes) const {
    return passes_block<kSamples>(tile, options.bill, stamp, nearest_of(z, covered, lanes));
  }

  /// With a block for each quad: the lanes of the quads that are not dropped.
  HWY_INLINE std::uint32_t quads_that_reach(int stamp, const Vector16 (&z)[kSamples], const Covered& covered, std::uint32_t lanes, std::uint32_t passing) const {
    std::uint32_t kept = 0;
    for (std::uint32_t quad = 0xf; quad <= 0xf000; quad <<= 4) {
      if ((lanes & quad) == 0) continue;
      if ((passing & quad) == 0) {
        std::uint32_t farthest = 0;
        for (int s = 0; s < kSamples; ++s)
          for (std::uint32_t left = quad; left != 0; left &= left - 1)
            farthest = std::max(farthest, tile.depth[(stamp * kSamples + s) * 16 + std::countr_zero(left)]);
        if (nearest_of(z, covered, lanes & quad) >= farthest) continue;
      }
      kept |= lanes & quad;
    }
    return kept;
  }
};

/// The same for a record of one covered pixel with one sample.
template <BillRule::Kind kBill>
HWY_INLINE void draw_single_pixel(TileMemory& tile, const Walk<1>& walk, const KernelOptions& options, BillBuffer& bill) {
  using Kind = BillRule::Kind;
  const int stamp = stamp_at(walk.x0, walk.y0), lane = lane_of(walk.x0, walk.y0);
  const std::uint32_t z = pixel_depth(walk, stamp, lane), element = static_cast<std::uint32_t>(stamp * 16 + lane);
  const bool nearer = z < tile.depth[element];
  const bool billed = kBill == Kind::Everything || (kBill == Kind::PerPixel && nearer) ||
                      (kBill == Kind::Hierarchical && (nearer || passes_block<1>(tile, options.bill, stamp, z)));
  if (billed)
    bill.stamps[bill.count++] = {walk.record.draw(), static_cast<std::uint16_t>(1u << lane), static_cast<std::uint8_t>(stamp)};
  if (!nearer) return;
  tile.depth[element] = z;
  tile.visibility[element] = walk.record.id;
  ++tile.block_writes[stamp >> 4];
  ++tile.tile_writes;
}

template <int kSamples, BillRule::Kind kBill>
void draw_records(TileMemory& tile, const SetupTriangle* records, std::size_t count, const KernelOptions& options,
                  BillBuffer& bill, HizCounters& counters) {
  const bool ascending = options.bill.block_px > kStampPx;
  for (const SetupTriangle* t = records; t != records + count; ++t) {
    if (t->culled()) continue;
    if (options.tile_hiz) {
      refresh_tile<kSamples>(tile, t->z_min);
      if (t->z_min >= tile.tile_max) {
        ++counters.tile;
        continue;
      }
    }
    Walk<kSamples> walk{*t, {}, {}, {}, {}, 0, 0, 0, 0};
    if (!bound(tile, *t, walk)) continue;
    if constexpr (kBill != BillRule::Kind::Off)
      if (bill.count > BillBuffer::kCapacity - kStampsPerTile) bill.flush();
    const bool single = walk.x0 == walk.x1 && walk.y0 == walk.y1;
    if (single && !covers_pixel<kSamples>(*t, tile.origin.x + walk.x0, tile.origin.y + walk.y0)) continue;
    walk.steps = depth_steps(*t, tile.origin);
    if constexpr (kSamples == 1) {
      if (single) {
        draw_single_pixel<kBill>(tile, walk, options, bill);
        continue;
      }
    }
    OpaqueStamps<kSamples, kBill> emit(tile, walk, options, bill);
    walk_stamps(tile, walk, options.block_hiz, ascending, counters.block, emit);
  }
}

/// Collects the stamps of one in-order record.
template <int kSamples>
struct CollectStamps {
  const TileMemory& tile;
  StampFragments& fragments;
  StampDepth<kSamples> depth;

  HWY_INLINE CollectStamps(const TileMemory& t, const Walk<kSamples>& w, StampFragments& f) : tile(t), fragments(f), depth(w.steps) {}
  HWY_INLINE void all(int stamp, std::uint64_t plane) { add(stamp, everything<kSamples>(), plane); }
  HWY_INLINE void some(int stamp, const Coverage<kSamples>& covered, std::uint64_t plane) { add(stamp, covered, plane); }
  HWY_INLINE void block(int number, std::uint64_t plane, const std::uint64_t* offsets) {
    for (int i = 0; i < 16; ++i) add(number << 4 | i, everything<kSamples>(), plane + offsets[i]);
  }
  HWY_INLINE void add(int stamp, const Coverage<kSamples>& covered, std::uint64_t plane) {
    if ((covered.any & tile.inside[stamp]) == 0) return;
    const int n = fragments.count++;
    fragments.stamp[n] = static_cast<std::uint8_t>(stamp);
    for (int s = 0; s < kSamples; ++s) {
      fragments.covered[n * kSamples + s] = static_cast<std::uint16_t>(covered.bits[s] & tile.inside[stamp]);
      const std::uint32_t anchor = depth.anchor(plane, s);
      for (std::size_t p = 0; p < kParts; ++p)
        hn::Store(depth.at(anchor, p), kTag, reinterpret_cast<std::int32_t*>(fragments.depth[n * kSamples + s]) + p * kLanes);
    }
  }
};

void Clear(TileMemory& tile, std::size_t elements) {
  const Vector depth = hn::Set(kTag, static_cast<std::int32_t>(kDepthMax)), none = hn::Set(kTag, static_cast<std::int32_t>(kNoTriangle));
  for (std::size_t i = 0; i < elements; i += kLanes) {
    hn::Store(depth, kTag, reinterpret_cast<std::int32_t*>(tile.depth) + i);
    hn::Store(none, kTag, reinterpret_cast<std::int32_t*>(tile.visibility) + i);
  }
}

template <int kSamples>
void draw_opaque(TileMemory& tile, const SetupTriangle* records, std::size_t count, const KernelOptions& options,
                 BillBuffer& bill, HizCounters& counters) {
  using Kind = BillRule::Kind;
  switch (options.bill.kind) {
    case Kind::Off: return draw_records<kSamples, Kind::Off>(tile, records, count, options, bill, counters);
    case Kind::Everything: return draw_records<kSamples, Kind::Everything>(tile, records, count, options, bill, counters);
    case Kind::Hierarchical: return draw_records<kSamples, Kind::Hierarchical>(tile, records, count, options, bill, counters);
    case Kind::PerPixel: return draw_records<kSamples, Kind::PerPixel>(tile, records, count, options, bill, counters);
  }
}

bool Hides(TileMemory& tile, std::uint32_t z_min, int samples) {
  if (samples == 1) refresh_tile<1>(tile, z_min);
  else refresh_tile<4>(tile, z_min);
  return z_min >= tile.tile_max;
}

void DrawOpaque(TileMemory& tile, const SetupTriangle* records, std::size_t count, const KernelOptions& options,
                BillBuffer& bill, HizCounters& counters) {
  (options.samples == 1 ? draw_opaque<1> : draw_opaque<4>)(tile, records, count, options, bill, counters);
}

template <int kSamples>
void find(TileMemory& tile, const SetupTriangle& record, const KernelOptions& options, StampFragments& fragments,
          HizCounters& counters) {
  fragments.count = 0;
  if (record.culled()) return;
  if (options.tile_hiz) {
    refresh_tile<kSamples>(tile, record.z_min);
    if (record.z_min >= tile.tile_max) {
      ++counters.tile;
      return;
    }
  }
  Walk<kSamples> walk{record, {}, {}, {}, {}, 0, 0, 0, 0};
  if (!bound(tile, record, walk)) return;
  walk.steps = depth_steps(record, tile.origin);
  CollectStamps<kSamples> emit(tile, walk, fragments);
  walk_stamps(tile, walk, options.block_hiz, options.bill.block_px > kStampPx, counters.block, emit);
}

void FindFragments(TileMemory& tile, const SetupTriangle& record, const KernelOptions& options, StampFragments& fragments,
                   HizCounters& counters) {
  (options.samples == 1 ? find<1> : find<4>)(tile, record, options, fragments, counters);
}

}  // namespace aluminate::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace aluminate::raster {

HWY_EXPORT(Clear);
HWY_EXPORT(DrawOpaque);
HWY_EXPORT(Hides);
HWY_EXPORT(FindFragments);

void clear_tile(TileMemory& tile, int samples) {
  HWY_DYNAMIC_DISPATCH(Clear)(tile, static_cast<std::size_t>(samples) * kTilePixels);
}

bool tile_hides(TileMemory& tile, std::uint32_t z_min, int samples) { return HWY_DYNAMIC_DISPATCH(Hides)(tile, z_min, samples); }

void draw_opaque_records(TileMemory& tile, const SetupTriangle* records, std::size_t count, const KernelOptions& options,
                         BillBuffer& bill, HizCounters& counters) {
  HWY_DYNAMIC_DISPATCH(DrawOpaque)(tile, records, count, options, bill, counters);
}

void find_fragments(TileMemory& tile, const SetupTriangle& record, const KernelOptions& options, StampFragments& fragments,
                    HizCounters& counters) {
  HWY_DYNAMIC_DISPATCH(FindFragments)(tile, record, options, fragments, counters);
}

}  // namespace aluminate::raster
#endif
