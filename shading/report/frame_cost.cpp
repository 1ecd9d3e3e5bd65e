#include "shading/report/frame_cost.hpp"

namespace aluminate::report {

std::vector<console::PassWork> pass_work(const passes::Frame& frame, const console::GpuModel& gpu) {
  std::vector<console::PassWork> works;
  for (const passes::PassTotals& pass : frame.passes) {
    console::PassWork work;
    work.name = pass.name;
    work.pixels = static_cast<double>(pass.pixels);
    work.quads = static_cast<double>(pass.quads);
    work.helper_lanes = static_cast<double>(pass.helper_lanes);
    work.alu_words = static_cast<double>(pass.alu_words);
    work.alu_slots = static_cast<double>(pass.alu_slots);
    work.fetches = static_cast<double>(pass.fetches);
    work.fetch_cyc = static_cast<double>(pass.fetch_cyc);
    // Helper lanes read texels their quad's covered pixels read anyway.
    const double lanes = work.pixels + work.helper_lanes;
    work.texel_cyc =
        lanes > 0 ? (work.fetch_cyc - static_cast<double>(pass.streamed_cyc)) * work.pixels / lanes : 0;
    work.texel_share = frame.texel_share;
    work.vertices = static_cast<double>(pass.vertices);
    work.vertex_words = static_cast<double>(pass.vertex_words);
    work.triangles = static_cast<double>(pass.triangles);
    work.tiling_passes = pass.tiling_passes;
    work.resolve_pixels = static_cast<double>(pass.resolve_pixels);
    work.rop.push_back({.pixels = static_cast<double>(pass.rop_pixels),
                        .blend = false,
                        .samples = frame.samples,
                        .targets = pass.color_targets});
    if (pass.rop_blended > 0)
      work.rop.push_back(
          {.pixels = static_cast<double>(pass.rop_blended), .blend = true, .samples = frame.samples});
    if (pass.rop_depth_only > 0)
      work.rop.push_back({.pixels = static_cast<double>(pass.rop_depth_only),
                          .format = console::ColorFormat::None,
                          .samples = frame.samples});
    work.bytes.push_back({"geometry", static_cast<double>(pass.bytes)});
    // Without eDRAM every colour and depth access goes to memory: 4 bytes a sample each, read and written
    // where blended. No compression of samples is assumed.
    if (!gpu.has_edram()) {
      const double samples = frame.samples;
      work.bytes.push_back(
          {"colour", samples * (4.0 * pass.color_targets * static_cast<double>(pass.rop_pixels) +
                                8.0 * static_cast<double>(pass.rop_blended))});
      work.bytes.push_back({"depth", samples * (4.0 * static_cast<double>(pass.pixels + pass.rop_depth_only) +
                                                4.0 * static_cast<double>(pass.rop_pixels))});
    } else if (pass.resolve_pixels > 0) {
      work.bytes.push_back({"resolve", 4.0 * static_cast<double>(pass.resolve_pixels)});
    }
    works.push_back(std::move(work));
  }
  if (gpu.has_edram() && !works.empty()) {  // the picture itself
    works.back().resolve_pixels += static_cast<double>(frame.pixel_count());
    works.back().bytes.push_back({"resolve", 4.0 * static_cast<double>(frame.pixel_count())});
  } else if (frame.samples > 1 && !works.empty()) {
    // A full-screen pass reads every sample and writes the pixel.
    works.back().bytes.push_back(
        {"resolve", 4.0 * (frame.samples + 1) * static_cast<double>(frame.pixel_count())});
  }
  return works;
}

console::FrameBudget frame_budget(const passes::Frame& frame, const console::GpuModel& gpu,
                                  double budget_ms) {
  const std::vector<console::PassWork> works = pass_work(frame, gpu);
  return console::price_frame(gpu, works, budget_ms);
}

}  // namespace aluminate::report
