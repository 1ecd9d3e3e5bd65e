#include "rasterizer/chunk_setup.hpp"

#include <algorithm>
#include <bit>

#include "platform/host/error.hpp"
#include "rasterizer/clip.hpp"
#include "rasterizer/triangle_cull.hpp"

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
        tiles_x_(static_cast<std::uint32_t>(input.viewport.tiles_x())),
        skip_frustum_(input.skips.on(Skip::Frustum)) {
    rule_.facing = input.skips.on(Skip::Facing);
    rule_.small = input.skips.on(Skip::Small);
    rule_.width = input.viewport.width;
    rule_.height = input.viewport.height;
    rule_.samples = kSamples;
  }

  void add_draw_range(std::uint32_t draw_number, std::uint32_t begin, std::uint32_t end) {
    const Draw& draw = input_.draws[draw_number];
    if (draw.outside) {
      counters_.submitted += end - begin;
      counters_.outside += end - begin;
      return;
    }
    draw_ = draw_number;
    rule_.mode = draw.cull;
    const std::uint32_t* index = input_.indices.data() + draw.first_index + 3 * std::size_t{begin - input_.draw_start[draw_number]};
    counters_.submitted += end - begin;
    for (std::uint32_t first = begin; first < end; first += kCullGroup, index += 3 * kCullGroup)
      add_group(draw, index, first, static_cast<int>(std::min<std::uint32_t>(kCullGroup, end - first)));
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

  void add_group(const Draw& draw, const std::uint32_t* index, std::uint32_t first, int count) {
    const ScreenVertex* vertices = input_.vertices.data();
    const std::size_t vertex_count = input_.vertices.size();
    const ScreenVertex* corner[kCullGroup][3];
    std::uint32_t gone = 0, cut = 0;
    for (int i = 0; i < count; ++i) {
      const std::size_t ia = std::size_t{draw.first_vertex} + index[3 * i], ib = std::size_t{draw.first_vertex} + index[3 * i + 1],
                        ic = std::size_t{draw.first_vertex} + index[3 * i + 2];
      if (std::max(std::max(ia, ib), ic) >= vertex_count) [[unlikely]]
        fail_index(draw_, std::max(std::max(ia, ib), ic));
      const ScreenVertex &a = vertices[ia], &b = vertices[ib], &c = vertices[ic];
      corner[i][0] = &a, corner[i][1] = &b, corner[i][2] = &c;
      group_.x[0][i] = a.x, group_.x[1][i] = b.x, group_.x[2][i] = c.x;
      group_.y[0][i] = a.y, group_.y[1][i] = b.y, group_.y[2][i] = c.y;
      const std::uint32_t any = a.flags | b.flags | c.flags;
      if (any == 0) [[likely]]
        continue;
      if (any & kNonFinite) {
        ++counters_.dropped_nonfinite;
        gone |= 1u << i;
      } else if (skip_frustum_ && (a.flags & b.flags & c.flags & kSides)) {
        ++counters_.frustum;
        gone |= 1u << i;
      } else if (any & kCut) {
        cut |= 1u << i;
      }
    }
    cull_triangles(group_, count, rule_, culled_);
    count_culled(~(gone | cut));
    for (std::uint32_t left = (culled_.kept & ~gone) | cut; left != 0; left &= left - 1) {
      const int i = std::countr_zero(left);
      if (cut >> i & 1) {
        const CullResult others = culled_;  // the fragments are culled in its place
        add_cut(draw.first_vertex + std::size_t{index[3 * i]}, draw.first_vertex + std::size_t{index[3 * i + 1]},
                draw.first_vertex + std::size_t{index[3 * i + 2]}, first + static_cast<std::uint32_t>(i));
        culled_ = others;
      } else {
        add_triangle(*corner[i][0], *corner[i][1], *corner[i][2], first + static_cast<std::uint32_t>(i), i);
      }
    }
  }

  void count_culled(std::uint32_t meant) {
    const auto count = [meant](std::uint32_t mask) { return static_cast<std::uint64_t>(std::popcount(mask & meant)); };
    counters_.degenerate += count(culled_.degenerate);
    counters_.facing += count(culled_.facing);
    counters_.small += count(culled_.small);
    counters_.frustum += count(culled_.outside);
  }

  /// place: of the triangle in culled_, which kept it.
  void add_triangle(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, TriangleId id, int place) {
    const CanonicalOrder order = canonical_order(a, b, c);
    const ScreenVertex* corner[3] = {&a, &b, &c};
    const std::uint32_t number = scratch_.record_count++;
    SetupTriangle& record = scratch_.records[number];
    fill_corners(*corner[order.corner[0]], *corner[order.corner[1]], *corner[order.corner[2]], record);
    record.id = id;
    record.draw_and_culled = draw_ | ((culled_.culled >> place & 1) != 0 ? SetupTriangle::kCulled : 0);
    const auto tile = [](std::int32_t px) { return static_cast<std::uint32_t>(px) / kTilePx; };
    bin(record, number, tile(culled_.x0[place]), tile(culled_.x1[place]), tile(culled_.y0[place]), tile(culled_.y1[place]));
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
    CornerGroup pieces{};
    std::array<std::array<std::size_t, 3>, kMaxClipFragments> piece;
    std::size_t pieces_count = 0;
    std::int64_t total = 0;  // at most 7 * 2^47
    for (std::size_t k = 1; k <= fragments; ++k) total += twice_area(corner[0], corner[k], corner[k + 1]);
    for (std::size_t k = 1; k <= fragments; ++k) {
      // Snapping can fold a fragment of less than a sub over; drawn, it would face the other way.
      const std::int64_t area2 = twice_area(corner[0], corner[k], corner[k + 1]);
      if ((area2 < 0) != (total < 0)) continue;
      piece[pieces_count] = {0, k, k + 1};
      for (std::size_t i = 0; i < 3; ++i) {
        pieces.x[i][pieces_count] = corner[piece[pieces_count][i]].x;
        pieces.y[i][pieces_count] = corner[piece[pieces_count][i]].y;
      }
      ++pieces_count;
    }
    cull_triangles(pieces, static_cast<int>(pieces_count), rule_, culled_);
    count_culled(~0u);
    for (std::uint32_t left = culled_.kept; left != 0; left &= left - 1) {
      const int place = std::countr_zero(left);
      const std::array<std::size_t, 3>& from = piece[static_cast<std::size_t>(place)];
      ClippedTriangle fragment;
      fragment.sequence = sequence;
      for (std::size_t i = 0; i < 3; ++i) {
        fragment.corner[i] = corner[from[i]];
        fragment.w[i] = polygon.corner[from[i]].w;
        fragment.b1[i] = polygon.corner[from[i]].b1;
        fragment.b2[i] = polygon.corner[from[i]].b2;
      }
      const TriangleId id = kClippedBit | chunk_number_ << kClipIndexBits | static_cast<std::uint32_t>(chunk_.clipped.size());
      chunk_.clipped.push_back(fragment);
      add_triangle(fragment.corner[0], fragment.corner[1], fragment.corner[2], id, place);
    }
  }

  const ChunkInput& input_;
  const std::uint32_t chunk_number_;
  ChunkScratch& scratch_;
  Chunk& chunk_;
  SetupCounters counters_;
  const std::uint32_t tiles_x_;
  const bool skip_frustum_;
  CullRule rule_;
  CornerGroup group_{};
  CullResult culled_;
  std::uint32_t draw_ = 0;
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
