// The oracle: the same picture, depth and bill by the slowest obvious road. One triangle after the other, pixel by pixel, in
// 128-bit integers, no tiles, no threads, no skips. Tests hold the tile rasterizer to it bit for bit.
// It shares with it only definitions: project_vertex, clip_triangle and depth_slope.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "rasterizer/bill.hpp"
#include "rasterizer/draw.hpp"

namespace aluminate::raster {

/// One shader invocation of an InOrder draw at a pixel with visible samples (bit per sample): returns whether it survives.
using ReferenceShader = std::function<bool(std::uint32_t draw, std::uint32_t sequence, int x, int y, unsigned samples)>;

struct ReferenceImage {
  int width = 0, height = 0;                // all images row-major, a pixel's samples side by side
  int samples = 1;
  std::vector<std::uint32_t> visibility;    // by sample: submission position of the visible opaque triangle, or kNoTriangle
  std::vector<std::uint32_t> depth;         // by sample: D24 at the end of the frame
  std::vector<std::uint32_t> hits;          // by sample: triangles that cover it, before any depth test
  std::vector<std::uint32_t> covered;       // by pixel: billed invocations on covered pixels
  std::vector<std::uint32_t> helpers;       // by pixel: billed helper invocations
  std::vector<std::uint64_t> billed_per_draw;  // covered + helper invocations
};

/// Draws the frame. `shade` sees InOrder fragments in front of the stored depth, in submission order; empty = all survive.
ReferenceImage draw_reference(const FrameInput& input, const BillRule& bill, const ReferenceShader& shade = {});

}  // namespace aluminate::raster
