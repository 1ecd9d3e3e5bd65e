// The tile stage: one 64x64 tile at a time, on one worker. In: a Frame. Out: which triangle is visible at each pixel of the
// opaque draws, D24 depth, the bill, and batches of in-order quads for the shader. Owns depth; colour belongs to the
// caller. Usage per tile: begin, draw_opaque, (shade view()'s visible quads), draw_in_order, (read depth).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "rasterizer/bill.hpp"
#include "rasterizer/frame.hpp"
#include "rasterizer/samples.hpp"
#include "rasterizer/skip.hpp"

namespace aluminate::raster {

struct TileOptions {
  BillRule bill{};
  SkipSet skips{};
};

/// A tile's samples, stamp by stamp and in a stamp sample by sample (bill.hpp gives the order of pixels). Pixels outside the
/// viewport are never covered: visibility kNoTriangle; their depth is meaningless.
struct TileView {
  TileOrigin origin{};
  int width = 0, height = 0;                   // pixels inside the viewport, 1 .. 64 (of a quarter 1 .. 32)
  int samples = 1;                             // per pixel
  std::span<const TriangleId> visibility;      // kTilePixels * samples
  std::span<const std::uint32_t> depth;        // D24, cleared to kDepthMax

  /// Of the spans; x, y tile-relative.
  constexpr int element(int x, int y, int sample) const { return (stamp_of(x, y) * samples + sample) * 16 + lane_of(x, y); }
  /// Of an array with one element a pixel: 16 stamp + lane.
  static constexpr int element(int x, int y) { return stamp_of(x, y) * 16 + lane_of(x, y); }
};

/// Up to 16 quads of one InOrder draw. Lane l of quad q is bit / element 4 q + l. A quad position may occur more than once
/// in a batch, from different triangles: their visible samples are then disjoint, so lanes never depend on one another.
struct QuadBatch {
  std::uint32_t draw = 0;
  int count = 0;                               // quads, 1 .. 16
  std::array<TriangleId, kBatchQuads> triangle{};
  std::array<std::uint16_t, kBatchQuads> x{}, y{};  // absolute pixel of lane 0, even
  std::array<std::uint64_t, kMaxSamples> visible_samples{};  // by sample: covered, inside the viewport, nearer than the
                                               // stored depth
  std::uint64_t visible = 0;                   // lanes with a visible sample: what the shader runs for
  std::uint64_t billed = 0;                    // covered lanes on the bill (0 in quads the console rejects or with the bill
                                               // off); helpers of a billed quad are its other lanes
  alignas(64) std::array<std::array<std::uint32_t, kBatchLanes>, kMaxSamples> depth{};  // D24 by sample; meaningless where not
                                               // covered
};

/// The caller's shader for InOrder draws. Runs 64 lanes, writes colour for the lanes it keeps.
class QuadShader {
 public:
  virtual ~QuadShader() = default;
  /// Returns the lanes that survive (alpha test), with all their visible samples; only visible ones count. Their depth is
  /// written when the draw says so.
  virtual std::uint64_t shade(const QuadBatch& batch) = 0;
};

class TileRasterizer {
 public:
  /// frame must outlive the rasterizer. Bill blocks other than 4, 8, 16 px (2 px with 4 samples): InternalError.
  TileRasterizer(const Frame& frame, const TileOptions& options);
  ~TileRasterizer();
  TileRasterizer(TileRasterizer&&) noexcept;

  /// task: from Frame::tile_order, or any tile. Clears depth to kDepthMax and visibility to kNoTriangle.
  void begin(int task);
  /// All Opaque draws. bill may be null (then no bill is made, as with Kind::Off); the same for draw_in_order.
  void draw_opaque(BillSink* bill);
  /// All InOrder draws, after draw_opaque. Each sample sees its triangles in submission order; quads of different triangles
  /// and of the same draw share batches as long as their samples are disjoint.
  void draw_in_order(QuadShader& shader, BillSink* bill);

  TileView view() const;
  const TileCounters& counters() const;        // since construction

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Copies the depth of each pixel's first sample into a row-major image of the frame's viewport.
void store_depth(const TileView& tile, std::span<std::uint32_t> image, int image_width);

}  // namespace aluminate::raster
