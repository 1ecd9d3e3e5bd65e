// One worker: rasterizes a tile, shades what is seen of it, bills it. The same for every pipeline: draws of
// the G-buffer pass store texels, light runs once they are done, everything else stores colour.
#pragma once

#include <cstdint>
#include <vector>

#include "rasterizer/quads.hpp"
#include "rasterizer/tile.hpp"
#include "shading/passes/bill.hpp"
#include "shading/passes/frame.hpp"
#include "shading/passes/gbuffer.hpp"
#include "shading/passes/light_stage.hpp"
#include "shading/passes/prepared.hpp"
#include "shading/passes/sample_colors.hpp"
#include "shading/passes/shade.hpp"
#include "shading/passes/tile_pixels.hpp"

namespace aluminate::passes {

class TileWorker : public raster::QuadShader {
 public:
  /// Tiles of one frame may run on several workers at the same time. Everything must outlive the worker.
  TileWorker(const PreparedFrame& prepared, const FrameOptions& options, GBuffer& gbuffer, Frame& frame);

  void run(int tile);

  // InOrder quads: alpha-tested, blended, or shaders that branch on data.
  std::uint64_t shade(const raster::QuadBatch& batch) override;

  const Shader& shader() const { return shader_; }
  const TileBill& bill() const { return bill_; }
  const LightStage& light_stage() const { return light_; }
  const raster::TileCounters& tile_counters() const { return tile_.counters(); }
  /// Of the last tile: its rasterized state, and the pixels a G-buffer draw left visible.
  raster::TileView view() const { return tile_.view(); }
  const StampMask& lit() const { return lit_; }

 private:
  void shade_visible();
  void light_up();
  PixelRect pixels() const;
  void store_batch(std::span<const raster::QuadPosition> quads, std::uint64_t lanes, const DrawState& draw,
                   const std::array<std::uint64_t, raster::kMaxSamples>& samples);
  void store(int x, int y, unsigned samples, int lane, const DrawState& draw);
  void write(float* rgb, int lane, bool blended) const;
  void bill_executed(const PixelProgram& program, const raster::QuadBatch& batch);

  const DrawList& list_;
  const raster::Frame& raster_frame_;
  raster::TileOptions options_;
  raster::TileRasterizer tile_;
  Shader shader_;
  TileBill bill_;
  LightStage light_;
  const int samples_;  // a pixel
  const Background background_;
  const bool encodes_;  // without a tone map a tile's light is final
  SampleColors sample_colors_;
  GBuffer& gbuffer_;
  Frame& frame_;
  StampMask lit_{};
  bool lights_due_ = false;
  std::vector<raster::VisibleQuad> visible_;
  std::vector<std::uint32_t> lane_blocks_;
};

}  // namespace aluminate::passes
