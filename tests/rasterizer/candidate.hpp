// Draws a frame with the tile rasterizer the way the passes layer does, and returns the planes the oracle returns, so that
// the two can be compared byte by byte.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rasterizer/frame.hpp"
#include "rasterizer/reference_raster.hpp"
#include "rasterizer/tile.hpp"

namespace aluminate::raster::test {

/// A frame that owns its arrays.
struct Geometry {
  Viewport viewport{64, 64};
  std::vector<double> x, y, z, w;
  std::vector<std::uint32_t> indices;
  std::vector<Draw> draws;
  int samples = 1;

  std::uint32_t add_vertex(double vx, double vy, double vz, double vw);
  /// Vertex at pixel (px, py) and depth z in [0, 1], w as given.
  std::uint32_t add_pixel_vertex(double px, double py, double depth, double vw = 1);
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// Closes the triangles added since the last call into a draw. Opaque draws must come first.
  Draw& end_draw(CullMode cull = CullMode::None, DrawClass draw_class = DrawClass::Opaque, bool depth_write = true);
  FrameInput input(SkipSet skips = {}) const;
};

struct CandidateOptions {
  BillRule bill{};
  SkipSet skips{};
  ParallelFor threads = serial();     // for set-up and tiles
  std::uint32_t tile_order_seed = 0;  // 0 = as the frame suggests, otherwise shuffled
  bool with_bill = true;
};

/// What both sides produce: the oracle's planes plus an order-dependent colour of in-order survivors.
struct Picture {
  ReferenceImage planes;
  std::vector<std::uint32_t> colour;  // by sample
  SetupCounters setup;
  TileCounters tiles;
};

/// The alpha test of the test shader: a fixed hash, so both sides agree without sharing state.
bool survives(std::uint32_t sequence, int x, int y);

Picture draw_candidate(const Geometry& geometry, const CandidateOptions& options);
Picture draw_expected(const Geometry& geometry, const BillRule& bill);

/// Empty when visibility, depth, bill and colour are the same bytes; otherwise the first difference in words.
std::string difference(const Picture& candidate, const Picture& expected);

}  // namespace aluminate::raster::test
