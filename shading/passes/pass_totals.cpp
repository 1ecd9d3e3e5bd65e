#include "shading/passes/pass_totals.hpp"

#include <cmath>

#include "platform/console/edram.hpp"

namespace aluminate::passes {
namespace {

constexpr std::uint64_t kTexelBytes = 4;  // of a 32-bit target

// Times geometry is sent for this many 32-bit colour targets beside depth; 1 where targets live in memory.
int tiling_passes(const console::GpuModel& gpu, int targets, int width, int height, int samples) {
  if (!gpu.has_edram()) return 1;
  const std::vector<console::SurfaceShape> surfaces(
      static_cast<std::size_t>(targets) + 1, {.width_px = width, .height_px = height, .samples = samples});
  return console::tiling_passes(gpu, surfaces);
}

class Totals {
 public:
  Totals(const PreparedFrame& prepared, const std::array<TileBill::Totals, kPassCount>& bill, int width,
         int height)
      : prepared_(prepared), list_(prepared.list), bill_(bill), width_(width), height_(height) {}

  std::vector<PassTotals> make() {
    const std::uint64_t pixels = static_cast<std::uint64_t>(width_) * static_cast<std::uint64_t>(height_);
    if (list_.shadow_atlas) passes_.push_back(prepared_.shadows.totals);
    const bool deferred = list_.gbuffer_targets > 0;
    if (deferred) {
      PassTotals pass = geometry_pass(Pass::Gbuffer, list_.gbuffer_targets);
      // Every target and depth are fetched by a later pass: nothing can be read from eDRAM.
      pass.resolve_pixels =
          list_.gpu.has_edram() ? pixels * (static_cast<std::uint64_t>(list_.gbuffer_targets) + 1) : 0;
      depth_lost_ = pass.tiling_passes > 1;
      passes_.push_back(std::move(pass));
    }
    for (const Pass pass : {Pass::Sun, Pass::Lights})
      if (at(pass).pixels > 0) passes_.push_back(light_pass(pass));
    if (list_.dome) passes_.push_back(geometry_pass(Pass::Dome, 1));
    bool any = false;
    for (const DrawState& draw : list_.draws) any |= draw.pass == Pass::Forward;
    if (any || !deferred) passes_.push_back(geometry_pass(Pass::Forward, 1));
    return std::move(passes_);
  }

 private:
  const TileBill::Totals& at(Pass pass) const { return bill_[static_cast<std::size_t>(pass)]; }

  PassTotals pixel_work(Pass kind) {
    const TileBill::Totals& bill = at(kind);
    PassTotals pass;
    pass.name = to_string(kind);
    pass.pixels = bill.pixels;
    pass.quads = bill.quads;
    pass.helper_lanes = bill.helper_lanes;
    pass.alu_words = bill.alu_words;
    pass.alu_slots = bill.alu_slots;
    pass.fetches = bill.fetches;
    pass.fetch_cyc = bill.fetch_cyc;
    pass.rop_pixels = bill.pixels - bill.blended_pixels;
    pass.rop_blended = bill.blended_pixels;
    // A G-buffer larger than eDRAM is drawn in parts; the first pass after it writes depth and stencil back
    // for all.
    if (depth_lost_ && kind != Pass::Gbuffer) {
      pass.rop_depth_only += static_cast<std::uint64_t>(width_) * static_cast<std::uint64_t>(height_);
      depth_lost_ = false;
    }
    return pass;
  }

  PassTotals geometry_pass(Pass kind, int targets) {
    PassTotals pass = pixel_work(kind);
    pass.color_targets = targets;
    pass.tiling_passes = tiling_passes(list_.gpu, targets, width_, height_, prepared_.raster_frame.samples());
    std::uint64_t indices = 0;
    for (std::size_t i = 0; i < list_.draws.size(); ++i) {
      if (list_.draws[i].pass != kind) continue;
      indices += 3 * std::uint64_t{list_.raster_draws[i].triangle_count};
    }
    pass.triangles = indices / 3;
    for (std::size_t i = 0; i < list_.vertex_programs.size(); ++i) {
      if (list_.vertex_passes[i] != kind) continue;
      const vm::Counters& counters = prepared_.vertex_counters[i];
      const std::uint64_t vertices = counters.blocks.empty() ? 0 : counters.blocks.front().covered_lanes;
      pass.vertices += vertices;
      pass.vertex_words += vertices * static_cast<std::uint64_t>(std::ceil(list_.vertex_costs[i].alu_words));
      // Attributes as 32-bit floats, what the vertex program reads of them.
      pass.bytes += vertices * 4 * list_.vertex_programs[i].executable.inputs().size();
    }
    pass.bytes += indices * (list_.vertex_count < 65536 ? 2 : 4);
    return pass;
  }

  PassTotals light_pass(Pass kind) {
    PassTotals pass = pixel_work(kind);
    // G-buffer texels: fetched by their own pixel, never again in a draw, so not the texture cache's business.
    pass.bytes += pass.fetches * kTexelBytes;
    pass.streamed_cyc = pass.fetch_cyc;
    if (kind == Pass::Lights)
      for (const BoundedLight& light : prepared_.light_plan.bounded)
        pass.rop_depth_only += 2 * light.rectangle_pixels;  // both faces of the volume mark the stencil
    return pass;
  }

  const PreparedFrame& prepared_;
  const DrawList& list_;
  const std::array<TileBill::Totals, kPassCount>& bill_;
  int width_, height_;
  bool depth_lost_ = false;
  std::vector<PassTotals> passes_;
};

}  // namespace

std::vector<PassTotals> pass_totals(const PreparedFrame& prepared,
                                    const std::array<TileBill::Totals, kPassCount>& bill, int width,
                                    int height) {
  return Totals(prepared, bill, width, height).make();
}

}  // namespace aluminate::passes
