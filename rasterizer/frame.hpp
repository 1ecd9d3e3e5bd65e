// A frame's triangles, set up and sorted into tiles. In: clip-space positions and draws. Out: per tile, the triangles that
// touch it in submission order, and for any triangle id what interpolation needs. The same for any number of threads:
// chunks of 1024 triangles are set up independently and a tile reads them in index order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "rasterizer/draw.hpp"
#include "rasterizer/skip.hpp"
#include "rasterizer/triangle.hpp"
#include "rasterizer/viewport.hpp"

namespace aluminate::raster {

/// How to run work on several threads: run(count, item) calls item(index, worker) once for each index in [0, count), in any
/// order; worker < workers and never twice at the same time.
struct ParallelFor {
  using Item = std::function<void(std::int64_t index, int worker)>;
  int workers = 1;
  std::function<void(std::int64_t count, const Item& item)> run;
};
/// The machine's threads (platform/host/parallel.hpp).
ParallelFor host_threads();
/// The calling thread, indices in ascending order.
ParallelFor serial();

/// Where a triangle id comes from and how it lies on the screen, corners in canonical order (triangle.hpp).
/// Clipping is hidden: barycentrics are always those of the submitted triangle.
struct TriangleInfo {
  std::uint32_t draw = 0;
  std::uint32_t primitive = 0;                 // triangle number within the draw
  std::array<std::uint32_t, 3> vertex{};       // submitted corners: positions in the vertex arrays, first_vertex added
  std::array<std::int32_t, 3> x{}, y{};        // canonical corners, s15.8 px
  std::array<double, 3> w{};                   // clip w of the canonical corners, > 0
  std::array<std::uint8_t, 3> corner{};        // canonical corner k is submitted corner[k] (when not clipped)
  bool front_facing = true;
  bool clipped = false;                        // a fragment: corner is meaningless, b1 and b2 hold instead
  std::array<double, 3> b1{}, b2{};            // submitted triangle's barycentrics 1 and 2 at the canonical corners
};

/// A run of records of one tile, contiguous in memory, never empty.
struct RecordRun {
  std::span<const SetupTriangle> records;
  std::uint32_t z_min = 0;                     // the least of their z_min: nothing in the run is nearer
};

class Frame {
 public:
  Frame();
  ~Frame();
  Frame(Frame&&) noexcept;
  Frame& operator=(Frame&&) noexcept;

  /// Replaces the frame's content; memory is reused. UserError for a viewport outside 1 .. kMaxViewportPx or more than
  /// kMaxTriangles triangles; InternalError for indices out of range, unequal spans or an Opaque draw after an InOrder one.
  void set_up(const FrameInput& input, const ParallelFor& parallel);

  const Viewport& viewport() const { return viewport_; }
  int samples() const { return samples_; }     // per pixel, 1 or 4
  std::span<const Draw> draws() const { return draws_; }
  const SetupCounters& counters() const { return counters_; }

  /// Records of a tile in submission order, as runs (at most one per chunk).
  std::span<const RecordRun> tile_runs(int tile) const;
  bool tile_is_empty(int tile) const { return tile_runs(tile).empty(); }
  /// What TileRasterizer::begin takes: all tiles (Skip::EmptyTiles off) or the ones with triangles, hot ones in quarters
  /// (viewport.hpp); costly ones first: hand them out in this order.
  std::span<const std::uint32_t> tile_order() const { return tile_order_; }
  /// Tiles that are not in tile_order().
  int empty_tiles() const { return empty_tiles_; }

  TriangleInfo triangle(TriangleId id) const;
  /// Draw of a triangle: cheaper than triangle(id).draw.
  std::uint32_t draw_of(TriangleId id) const;

 private:
  struct Storage;
  void sort_runs();
  void order_tiles(bool skip_empty);
  std::uint32_t sequence_of(TriangleId id) const;

  Viewport viewport_;
  int samples_ = 1;
  std::vector<Draw> draws_;
  std::vector<std::uint32_t> draw_start_;  // submission position of each draw's first triangle, plus the total
  ClipPositions positions_;
  std::span<const std::uint32_t> indices_;
  SetupCounters counters_;
  std::vector<RecordRun> runs_;
  std::vector<std::uint32_t> run_start_;   // per tile, into runs_, plus the total
  std::vector<std::uint32_t> tile_order_;
  int empty_tiles_ = 0;
  std::unique_ptr<Storage> storage_;
};

}  // namespace aluminate::raster
