#include "rasterizer/chunk_setup.hpp"

#include <algorithm>

#include "platform/host/error.hpp"
#include "rasterizer/clip.hpp"
#include "rasterizer/triangle_setup.hpp"

namespace aluminate::raster {
namespace {

template <int kSamples>
class ChunkBuilder {
 public:
  ChunkBuilder(const ChunkInput& input, std::uint32_t chunk_number, ChunkScratch& scratch, Chunk& chunk)
      : input_(input),
        chunk_number_(chunk_number),
        scratch_(scratch),
        chunk_(chunk),
        tiles_x_(static_cast<std::uint32_t>(input.viewport.tiles_x())) {
    rule_.frustum = input.skips.on(Skip::Frustum);
    rule_.facing = input.skips.on(Skip::Facing);
    rule_.small = input.skips.on(Skip::Small);
    rule_.width = input.viewport.width;
    rule_.height = input.viewport.height;
    rule_.samples = kSamples;
    out_ = {scratch.records.get(), scratch.bounds.get(), 0};
  }

  void add_draw_range(std::uint32_t draw_number, std::uint32_t begin, std::uint32_t end) {
    const Draw& draw = input_.draws[draw_number];
    const std::uint32_t count = end - begin;
    counters_.submitted += count;
    if (draw.outside) {
      counters_.outside += count;
      return;
    }
    rule_.mode = draw.cull;
    const std::uint32_t* index = input_.indices.data() + draw.first_index + 3 * std::size_t{begin - input_.draw_start[draw_number]};
    const std::uint32_t highest = *std::max_element(index, index + 3 * std::size_t{count});
    if (std::size_t{draw.first_vertex} + highest >= input_.vertices.size()) [[unlikely]]
      fail_index(draw_number, std::size_t{draw.first_vertex} + highest);
    const TriangleRange range{input_.vertices.data() + draw.first_vertex, index, count, begin, draw_number};
    for (std::uint32_t next = 0; next < count;) {
      next = set_up_triangles(range, next, rule_, out_, counters_);
      bin_new_records();
      if (next == count) break;
      const auto vertex = [&](std::size_t corner) { return draw.first_vertex + std::size_t{index[3 * std::size_t{next} + corner]}; };
      add_cut(draw_number, vertex(0), vertex(1), vertex(2), begin + next);
      ++next;
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

  void bin_new_records() {
    counters_.binned += out_.count - binned_;
    for (; binned_ < out_.count; ++binned_) {
      const TileBounds b = out_.bounds[binned_];
      const SetupTriangle& t = out_.records[binned_];
      if (b.x0 == b.x1 && b.y0 == b.y1) [[likely]]
        enter(binned_, t.z_min, b.y0 * tiles_x_ + b.x0);
      else
        bin(t, binned_, b.x0, b.x1, b.y0, b.y1);
    }
  }

  /// Into all tiles of the bounds that no edge excludes.
  [[gnu::noinline]] void bin(const SetupTriangle& t, std::uint32_t number, std::uint32_t tx0, std::uint32_t tx1, std::uint32_t ty0, std::uint32_t ty1) {
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

  [[gnu::noinline]] void add_cut(std::uint32_t draw, std::size_t ia, std::size_t ib, std::size_t ic, std::uint32_t sequence) {
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
    TriangleRange pieces{corner.data(), nullptr, 0, kClippedBit | chunk_number_ << kClipIndexBits | static_cast<std::uint32_t>(chunk_.clipped.size()), draw};
    std::array<std::uint32_t, 3 * kMaxClipFragments> index;
    pieces.indices = index.data();
    std::int64_t total = 0;  // at most 7 * 2^47
    for (std::size_t k = 1; k <= fragments; ++k) total += twice_area(corner[0], corner[k], corner[k + 1]);
    for (std::size_t k = 1; k <= fragments; ++k) {
      // Snapping can fold a fragment of less than a sub over; drawn, it would face the other way.
      const std::int64_t area2 = twice_area(corner[0], corner[k], corner[k + 1]);
      if ((area2 < 0) != (total < 0)) continue;
      ClippedTriangle& fragment = chunk_.clipped.emplace_back();
      fragment.sequence = sequence;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t from = i == 0 ? 0 : k + i - 1;
        index[3 * std::size_t{pieces.count} + i] = static_cast<std::uint32_t>(from);
        fragment.corner[i] = corner[from];
        fragment.w[i] = polygon.corner[from].w;
        fragment.b1[i] = polygon.corner[from].b1;
        fragment.b2[i] = polygon.corner[from].b2;
      }
      ++pieces.count;
    }
    set_up_triangles(pieces, 0, rule_, out_, counters_);
    bin_new_records();
  }

  const ChunkInput& input_;
  const std::uint32_t chunk_number_;
  ChunkScratch& scratch_;
  Chunk& chunk_;
  SetupCounters counters_;
  const std::uint32_t tiles_x_;
  SetupRule rule_;
  SetupOutput out_;
  std::uint32_t binned_ = 0;  // records of out_ already entered in bins
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
  if (!scratch.records) {
    constexpr std::size_t kMost = kChunkTriangles * kMaxClipFragments + kSetupSlack;
    scratch.records = std::make_unique_for_overwrite<SetupTriangle[]>(kMost);
    scratch.bounds = std::make_unique_for_overwrite<TileBounds[]>(kMost);
  }
  scratch.entries.clear();
  const std::size_t tiles = static_cast<std::size_t>(input.viewport.tile_count());
  if (scratch.tile_count.size() < tiles) scratch.tile_count.resize(tiles, 0);
  if (input.samples == 1) build<1>(input, chunk_number, scratch, chunk);
  else build<4>(input, chunk_number, scratch, chunk);
}

}  // namespace aluminate::raster
