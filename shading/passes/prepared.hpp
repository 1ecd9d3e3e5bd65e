// A scene up to the tiles: draws, shaded vertices, triangles set up and binned. Shared by the frame and by
// the inspection of a single pixel.
#pragma once

#include <vector>

#include "rasterizer/frame.hpp"
#include "rasterizer/tile.hpp"
#include "shading/passes/draw_list.hpp"
#include "shading/passes/light_plan.hpp"

namespace aluminate::passes {

struct PreparedFrame {
  DrawList list;
  ShadowResult shadows;
  LightPlan light_plan;
  std::vector<double> x, y, z, w;  // clip space, all draws
  std::vector<double> varyings;
  std::vector<vm::Counters> vertex_counters;  // by vertex program
  raster::Frame raster_frame;  // refers to the arrays above: neither may move once it is set up

  PreparedFrame() = default;
  PreparedFrame(const PreparedFrame&) = delete;
  PreparedFrame& operator=(const PreparedFrame&) = delete;
};

/// Fills list and light_plan. Throws UserError for what cannot be drawn.
void prepare(const scenes::Scene& scene, const FrameOptions& options, PreparedFrame& prepared);
/// The stages of a frame before its tiles, in this order; each may run again for the next frame.
void draw_shadows(PreparedFrame& prepared, const FrameOptions& options);
void shade_all_vertices(PreparedFrame& prepared);
void set_up_triangles(PreparedFrame& prepared, const FrameOptions& options);

/// The console's way of rejecting hidden fragments, and the skips that are on.
raster::TileOptions tile_options(const console::GpuModel& gpu, const FrameOptions& options);

}  // namespace aluminate::passes
