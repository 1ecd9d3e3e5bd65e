// The light passes of one tile. In: its G-buffer, depth and which pixels hold a lit surface. Out: linear
// radiance of those pixels, and the console's bill. One per worker.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "platform/host/workers.hpp"
#include "rasterizer/tile.hpp"
#include "shading/passes/frame.hpp"
#include "shading/passes/gbuffer.hpp"
#include "shading/passes/light_plan.hpp"
#include "shading/passes/view_rays.hpp"
#include "shading/vm/executable.hpp"
#include "shading/vm/reference_interpreter.hpp"

namespace aluminate::passes {

/// The 16 pixels of each stamp of a tile: bit = lane (rasterizer/bill.hpp).
using StampMask = std::array<std::uint16_t, raster::kStampsPerTile>;

struct LightStageCounters {
  std::uint64_t tile_lights = 0;       // (tile, bounded light) pairs left out
  std::uint64_t tile_lights_kept = 0;  // pairs that ran
};

class LightStage {
 public:
  /// skip: leave out bounded lights that do not reach a tile. Both lists must outlive the stage.
  LightStage(const DrawList& list, const LightPlan& plan, const GBuffer& gbuffer, int width, int height,
             bool skip);

  /// What the console pays. A full-screen draw is stencilled to lit pixels, a volume to lit pixels inside its
  /// bound (BoundedLight::contains); where the console rejects 4x4 pixels at a time, all of a stamp with such
  /// a pixel is shaded.
  void bill(const raster::TileView& tile, const StampMask& lit, const raster::BillRule& rule,
            raster::BillSink& sink);
  /// Lights every lit pixel of the tile, after bill(). Writes frame.linear.
  void run(const raster::TileView& tile, const StampMask& lit, Frame& frame);
  /// One pixel again, after bill(), through the reference interpreter: its radiance and each instruction of
  /// the draws that lit it, with the program's place in LightPlan::programs.
  struct TracedGroup {
    int program = 0;
    vm::Trace trace;
  };
  std::vector<TracedGroup> trace(int x, int y, glm::dvec3& radiance);

  const std::vector<vm::Counters>& counters() const { return vm_counters_; }  // by LightPlan::programs
  const LightStageCounters& stage_counters() const { return counters_; }

 private:
  struct GroupRun {
    int program = 0;
    const std::vector<double>* constants = nullptr;
  };
  void find_positions(const raster::TileView& tile, const StampMask& lit);
  void choose_lights();
  void plan_groups();
  void fill_inputs(const PixelProgram& program, const std::uint16_t* x, const std::uint16_t* y, int count);
  vm::Batch batch_for(const GroupRun& group, int count);
  void take_output(const PixelProgram& program);

  const DrawList& list_;
  const LightPlan& plan_;
  ViewRays rays_;
  int width_, height_;
  bool skip_;
  std::vector<std::vector<vm::SamplerBinding>> samplers_;  // by program
  vm::Scratch scratch_;
  host::AlignedRows inputs_, outputs_, below_;
  std::vector<vm::Counters> vm_counters_;
  LightStageCounters counters_;

  std::vector<glm::dvec3> positions_;  // of the tile's lit pixels, stamp order
  glm::dvec3 low_{0}, high_{0};        // their bounds
  std::vector<std::uint32_t> reaching_,
      shared_;  // bounded lights of the tile; those of them without a shadow
  std::vector<GroupRun> groups_;
  std::vector<std::vector<double>> tile_constants_;
  std::vector<raster::BilledStamp> stamps_;
};

}  // namespace aluminate::passes
