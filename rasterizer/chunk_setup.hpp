// Set-up of one chunk of 1024 triangles: cull, clip, canonical order, depth plane, and the chunk's own bins.
// In: snapped vertices and draws. Out: records sorted by tile, by value, contiguous per tile (a tile then streams through
// memory instead of chasing indices). Runs on any worker; the result depends on the chunk's number alone.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "rasterizer/canonical.hpp"
#include "rasterizer/draw.hpp"
#include "rasterizer/screen_vertex.hpp"
#include "rasterizer/skip.hpp"
#include "rasterizer/triangle.hpp"
#include "rasterizer/triangle_setup.hpp"

namespace aluminate::raster {

struct ChunkInput {
  const Viewport& viewport;
  const ScreenMap& map;
  std::span<const Draw> draws;
  std::span<const std::uint32_t> draw_start;  // draws.size() + 1
  std::span<const std::uint32_t> indices;
  const ClipPositions& positions;
  std::span<const ScreenVertex> vertices;
  SkipSet skips;
  int samples;
};

/// A fragment of a cut triangle, corners in fan order.
struct ClippedTriangle {
  std::uint32_t sequence = 0;  // submission position of the triangle it comes from
  std::array<ScreenVertex, 3> corner{};
  std::array<double, 3> w{}, b1{}, b2{};
};

struct ChunkRun {
  std::uint32_t tile = 0, begin = 0, count = 0;
  std::uint32_t z_min = kDepthMax;         // the least of the records'
};

struct Chunk {
  std::unique_ptr<SetupTriangle[]> records;
  std::size_t capacity = 0;
  std::vector<ChunkRun> runs;              // one per touched tile, in order of first touch
  std::vector<ClippedTriangle> clipped;
  SetupCounters counters;
};

/// Per worker: holds a chunk before it is sorted.
struct ChunkScratch {
  struct Entry {
    std::uint32_t record = 0, tile = 0;
  };
  std::unique_ptr<SetupTriangle[]> records;  // kChunkTriangles * kMaxClipFragments + kSetupSlack
  std::unique_ptr<TileBounds[]> bounds;      // as many
  std::vector<Entry> entries;
  std::vector<std::uint32_t> tile_count;   // zero between chunks
};

void set_up_chunk(const ChunkInput& input, std::uint32_t chunk_number, ChunkScratch& scratch, Chunk& chunk);

}  // namespace aluminate::raster
