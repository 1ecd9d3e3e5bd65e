#include "rasterizer/chunk_setup.hpp"

#include <algorithm>

#include "platform/host/error.hpp"
#include "rasterizer/clip.hpp"

namespace aluminate::raster {
namespace {

constexpr std::int32_t smallest(std::int32_t a, std::int32_t b, std::int32_t c) { return std::min(std::min(a, b), c); }
constexpr std::int32_t largest(std::int32_t a, std::int32_t b, std::int32_t c) { return std::max(std::max(a, b), c); }

template <int kSamples>
class ChunkBuilder {
 public:
  ChunkBuilder(const ChunkInput& input, std::uint32_t chunk_number, ChunkScratch& scratch, Chunk& chunk)
      : input_(input),
        chunk_number_(chunk_number),
        scratch_(scratch),
        chunk_(chunk),
        tiles_x_(static_cast<std::uint32_t>(input.viewport.tiles_x())),
        width_(input.viewport.width),
        height_(input.viewport.height),
        skip_frustum_(input.skips.on(Skip::Frustum)),
        skip_facing_(input.skips.on(Skip::Facing)),
        skip_small_(input.skips.on(Skip::Small)) {}

  void add_draw_range(std::uint32_t draw_number, std::uint32_t begin, std::uint32_t end) {
    const Draw& draw = input_.draws[draw_number];
    if (draw.outside) {
      counters_.submitted += end - begin;
      counters_.outside += end - begin;
      return;
    }
    draw_ = draw_number;
    cull_ = draw.cull;
    const std::uint32_t* index = input_.indices.data() + draw.first_index + 3 * std::size_t{begin - input_.draw_start[draw_number]};
    const ScreenVertex* vertices = input_.vertices.data();
    const std::size_t vertex_count = input_.vertices.size();
    counters_.submitted += end - begin;
    for (std::uint32_t sequence = begin; sequence < end; ++sequence, index += 3) {
      const std::size_t ia = std::size_t{draw.first_vertex} + index[0], ib = std::size_t{draw.first_vertex} + index[1],
                        ic = std::size_t{draw.first_vertex} + index[2];
      if (std::max(std::max(ia, ib), ic) >= vertex_count) [[unlikely]]
        fail_index(draw_number, std::max(std::max(ia, ib), ic));
      const ScreenVertex &a = vertices[ia], &b = vertices[ib], &c = vertices[ic];
      const std::uint32_t any = a.flags | b.flags | c.flags;
      if (any == 0) [[likely]] {
        add_triangle(a, b, c, sequence);
        continue;
      }
      if (any & kNonFinite) {
        ++counters_.dropped_nonfinite;
      } else if (skip_frustum_ && (a.flags & b.flags & c.flags & kSides)) {
        ++counters_.frustum;
      } else if (any & kCut) {
        add_cut(ia, ib, ic, sequence);
      } else {
        add_triangle(a, b, c, sequence);
      }
    }
  }

  void finish() {
    // Counting sort by tile. Entries are in submission order and the sort is stable, so each run is as well.
    std::uint32_t begin = 0;
    for (ChunkRun& run : chunk_.runs) {
      run.begin = begin;
      begin += run.count;
      scratch_.tile_count[run.tile] = run.begin;  // from here on the next free place of the tile
    }
    if (chunk_.capacity < begin) {
      chunk_.capacity = begin + begin / 4;
      chunk_.records = std::make_unique_for_overwrite<SetupTriangle[]>(chunk_.capacity);
    }
    SetupTriangle* out = chunk_.records.get();
    for (const ChunkScratch::Entry& entry : scratch_.entries)
      out[scratch_.tile_count[entry.tile]++] = scratch_.records[entry.record];
    for (const ChunkRun& run : chunk_.runs) scratch_.tile_count[run.tile] = 0;
    counters_.bin_entries = begin;
    chunk_.counters = counters_;
  }

 private:
  [[noreturn, gnu::cold, gnu::noinline]] void fail_index(std::uint32_t draw, std::size_t index) const {
    ALU_CHECK(false, "draw {} reads vertex {} of {}", draw, index, input_.vertices.size());
    __builtin_unreachable();
  }

  void add_triangle(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, TriangleId id) {
    const std::int64_t area2 = twice_area(a, b, c);
    if (area2 == 0) {
      ++counters_.degenerate;
      return;
    }
    const bool front = area2 < 0;
    const bool culled = cull_ == CullMode::None ? false : (cull_ == CullMode::Back) != front;
    if (culled && skip_facing_) {
      ++counters_.facing;
      return;
    }
    const std::int32_t left = smallest(a.x, b.x, c.x), right = largest(a.x, b.x, c.x);
    const std::int32_t top = smallest(a.y, b.y, c.y), bottom = largest(a.y, b.y, c.y);
    std::int32_t x0 = first_pixel<kSamples>(left), x1 = last_pixel<kSamples>(right);
    std::int32_t y0 = first_pixel<kSamples>(top), y1 = last_pixel<kSamples>(bottom);
    if (x0 > x1 || y0 > y1) {
      if (skip_small_) {
        ++counters_.small;
        return;
      }
      x1 = std::max(x0, x1);  // some tile near it, for the proof that it covers nothing there
      y1 = std::max(y0, y1);
    }
    x0 = std::max(x0, 0), y0 = std::max(y0, 0);
    x1 = std::min(x1, width_ - 1), y1 = std::min(y1, height_ - 1);
    if (x0 > x1 || y0 > y1) {
      ++counters_.frustum;
      return;
    }
    const CanonicalOrder order = canonical_order(a, b, c);
    const ScreenVertex* corner[3] = {&a, &b, &c};
    SetupTriangle& record = scratch_.records[scratch_.record_count];
    fill_corners(*corner[order.corner[0]], *corner[order.corner[1]], *corner[order.corner[2]], record);
    // One pixel in the bounds: often the triangle misses its samples. Cheaper to know now than to carry it to a tile.
    if (x0 == x1 && y0 == y1 && skip_small_ && !covers_pixel<kSamples>(record, x0, y0)) {
      ++counters_.small;
      return;
    }
    record.id = id;
    record.draw_and_culled = draw_ | (culled ? SetupTriangle::kCulled : 0);
    const std::uint32_t number = scratch_.record_count++;
    bin(record, number, static_cast<std::uint32_t>(x0) / kTilePx, static_cast<std::uint32_t>(x1) / kTilePx,
        static_cast<std::uint32_t>(y0) / kTilePx, static_cast<std::uint32_t>(y1) / kTilePx);
  }

  void enter(std::uint32_t number, std::uint32_t z_min, std::uint32_t tile) {
    std::uint32_t& slot = scratch_.tile_count[tile];  // run number + 1
    if (slot == 0) {
      chunk_.runs.push_back({.tile = tile});
      slot = static_cast<std::uint32_t>(chunk_.runs.size());
    }
    ChunkRun& run = chunk_.runs[slot - 1];
    ++run.count;
    run.z_min = std::min(run.z_min, z_min);
    scratch_.entries.push_back({number, tile});
  }

  void bin(const SetupTriangle& t, std::uint32_t number, std::uint32_t tx0, std::uint32_t tx1, std::uint32_t ty0, std::uint32_t ty1) {
    ++counters_.binned;
    if (tx0 == tx1 || ty0 == ty1) {
      for (std::uint32_t ty = ty0; ty <= ty1; ++ty)
        for (std::uint32_t tx = tx0; tx <= tx1; ++tx) enter(number, t.z_min, ty * tiles_x_ + tx);
      return;
    }
    // Edge values at the tile corner where each edge is largest: negative = the tile lies outside.
    std::int64_t row[3], step_x[3], step_y[3];
    for (int k = 0; k < 3; ++k) {
      const int n = k == 2 ? 0 : k + 1;
      const std::int64_t dx = t.x[n] - t.x[k], dy = t.y[n] - t.y[k];
      constexpr std::int64_t kFirst = SamplePattern<kSamples>::kLow, kLast = (kTilePx - 1) * kSubpixels + SamplePattern<kSamples>::kHigh;
      const std::int64_t x = std::int64_t{tx0} * kTilePx * kSubpixels + (dy < 0 ? kLast : kFirst);
      const std::int64_t y = std::int64_t{ty0} * kTilePx * kSubpixels + (dx > 0 ? kLast : kFirst);
      row[k] = dx * (y - t.y[k]) - dy * (x - t.x[k]);
      step_x[k] = -dy * kTilePx * kSubpixels;
      step_y[k] = dx * kTilePx * kSubpixels;
    }
    for (std::uint32_t ty = ty0; ty <= ty1; ++ty) {
      std::int64_t edge[3] = {row[0], row[1], row[2]};
      for (std::uint32_t tx = tx0; tx <= tx1; ++tx) {
        if ((edge[0] | edge[1] | edge[2]) >= 0) enter(number, t.z_min, ty * tiles_x_ + tx);
        for (int k = 0; k < 3; ++k) edge[k] += step_x[k];
      }
      for (int k = 0; k < 3; ++k) row[k] += step_y[k];
    }
  }

  [[gnu::noinline]] void add_cut(std::size_t ia, std::size_t ib, std::size_t ic, std::uint32_t sequence) {
    const ClipPositions& p = input_.positions;
    const ClipPolygon polygon = clip_triangle(input_.map, {p.x[ia], p.y[ia], p.z[ia], p.w[ia], 0, 0},
                                              {p.x[ib], p.y[ib], p.z[ib], p.w[ib], 1, 0}, {p.x[ic], p.y[ic], p.z[ic], p.w[ic], 0, 1});
    if (polygon.count == 0) {
      ++counters_.frustum;
      return;
    }
    std::array<ScreenVertex, kMaxClipCorners> corner;
    for (std::size_t i = 0; i < static_cast<std::size_t>(polygon.count); ++i) {
      const ClipCorner& v = polygon.corner[i];
      if (!snap_vertex(input_.map, v.x, v.y, v.z, v.w, corner[i])) {
        ++counters_.dropped_nonfinite;
        return;
      }
    }
    ++counters_.clipped;
    const std::size_t fragments = static_cast<std::size_t>(polygon.count) - 2;
    std::int64_t total = 0;  // at most 7 * 2^47
    for (std::size_t k = 1; k <= fragments; ++k) total += twice_area(corner[0], corner[k], corner[k + 1]);
    for (std::size_t k = 1; k <= fragments; ++k) {
      // Snapping can fold a fragment of less than a sub over; drawn, it would face the other way.
      const std::int64_t area2 = twice_area(corner[0], corner[k], corner[k + 1]);
      if ((area2 < 0) != (total < 0)) continue;
      ClippedTriangle fragment;
      fragment.sequence = sequence;
      const std::size_t from[3] = {0, k, k + 1};
      for (std::size_t i = 0; i < 3; ++i) {
        fragment.corner[i] = corner[from[i]];
        fragment.w[i] = polygon.corner[from[i]].w;
        fragment.b1[i] = polygon.corner[from[i]].b1;
        fragment.b2[i] = polygon.corner[from[i]].b2;
      }
      const TriangleId id = kClippedBit | chunk_number_ << kClipIndexBits | static_cast<std::uint32_t>(chunk_.clipped.size());
      chunk_.clipped.push_back(fragment);
      add_triangle(fragment.corner[0], fragment.corner[1], fragment.corner[2], id);
    }
  }

  const ChunkInput& input_;
  const std::uint32_t chunk_number_;
  ChunkScratch& scratch_;
  Chunk& chunk_;
  SetupCounters counters_;
  const std::uint32_t tiles_x_;
  const std::int32_t width_, height_;
  const bool skip_frustum_, skip_facing_, skip_small_;
  std::uint32_t draw_ = 0;
  CullMode cull_ = CullMode::None;
};

template <int kSamples>
void build(const ChunkInput& input, std::uint32_t chunk_number, ChunkScratch& scratch, Chunk& chunk) {
  ChunkBuilder<kSamples> builder(input, chunk_number, scratch, chunk);
  const std::uint32_t begin = chunk_number * kChunkTriangles;
  const std::uint32_t end = std::min(begin + kChunkTriangles, input.draw_start.back());
  const auto first = std::upper_bound(input.draw_start.begin(), input.draw_start.end(), begin) - 1;
  for (auto draw = static_cast<std::uint32_t>(first - input.draw_start.begin()); draw < input.draws.size(); ++draw) {
    const std::uint32_t from = std::max(begin, input.draw_start[draw]), to = std::min(end, input.draw_start[draw + 1]);
    if (from >= end) break;
    if (from < to) builder.add_draw_range(draw, from, to);
  }
  builder.finish();
}

}  // namespace

void set_up_chunk(const ChunkInput& input, std::uint32_t chunk_number, ChunkScratch& scratch, Chunk& chunk) {
  chunk.runs.clear();
  chunk.clipped.clear();
  if (!scratch.records) scratch.records = std::make_unique_for_overwrite<SetupTriangle[]>(kChunkTriangles * kMaxClipFragments);
  scratch.record_count = 0;
  scratch.entries.clear();
  const std::size_t tiles = static_cast<std::size_t>(input.viewport.tile_count());
  if (scratch.tile_count.size() < tiles) scratch.tile_count.resize(tiles, 0);
  if (input.samples == 1) build<1>(input, chunk_number, scratch, chunk);
  else build<4>(input, chunk_number, scratch, chunk);
}

}  // namespace aluminate::raster
