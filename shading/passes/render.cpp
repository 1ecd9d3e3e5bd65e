// From a scene to a frame: vertices, set-up, then tile by tile visibility, shading and the bill.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "platform/host/parallel.hpp"
#include "platform/host/progress.hpp"
#include "platform/host/workers.hpp"
#include "rasterizer/frame.hpp"
#include "shading/passes/frame.hpp"
#include "shading/passes/pass_totals.hpp"
#include "shading/passes/renderer.hpp"
#include "shading/passes/resolve.hpp"
#include "shading/passes/tile_pixels.hpp"
#include "shading/passes/tile_worker.hpp"

namespace aluminate::passes {
namespace {

class PhaseClock {
 public:
  explicit PhaseClock(Timing& timing) : timing_(timing) {}
  void end(const char* phase) {
    const auto now = std::chrono::steady_clock::now();
    timing_.phases_ms[phase] += std::chrono::duration<double, std::milli>(now - start_).count();
    start_ = now;
  }

 private:
  Timing& timing_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Tiles that are drawn write all of their pixels.
void blank_empty_tiles(const raster::Frame& raster_frame, const Background& background, Frame& frame) {
  host::parallel_for(raster_frame.viewport().tile_count(), [&](std::int64_t index) {
    const int tile = static_cast<int>(index);
    if (!raster_frame.tile_is_empty(tile)) return;
    const raster::TileOrigin origin = raster::tile_origin(raster_frame.viewport(), tile);
    blank_pixels(background,
                 {origin.x, origin.y, std::min(raster::kTilePx, frame.width - origin.x),
                  std::min(raster::kTilePx, frame.height - origin.y)},
                 frame);
  });
}

void add_saturations(const vm::Program& program, const vm::Counters& counters, bool checked, Frame& frame) {
  for (std::size_t i = 0; i < counters.saturations.size(); ++i) {
    if (counters.saturations[i] == 0) continue;
    frame.saturations += counters.saturations[i];
    if (!checked) continue;
    const vm::SourceLine& line = program.code[i].line;
    const std::string file = line.file < program.files.size() ? program.files[line.file] : program.name;
    frame.saturated_instructions.push_back({fmt::format("{}:{}:{}", file, line.line, line.column),
                                            vm::disassemble(program, program.code[i]),
                                            counters.saturations[i]});
  }
}

}  // namespace

Frame blank_frame(const FrameOptions& options, Frame recycled) {
  Frame frame;
  frame.width = options.width;
  frame.height = options.height;
  frame.samples = options.msaa;
  const std::size_t pixels = frame.pixel_count();
  frame.rgba8 = std::move(recycled.rgba8);
  frame.linear = std::move(recycled.linear);
  frame.covered = std::move(recycled.covered);
  frame.depth_d24 = std::move(recycled.depth_d24);
  frame.cost = std::move(recycled.cost);
  frame.rgba8.resize(pixels * 4);
  frame.linear.resize(pixels * 4);
  frame.covered.resize(pixels);
  frame.depth_d24.resize(pixels);
  CostPlanes& cost = frame.cost;
  for (auto* plane : {&cost.alu_words, &cost.alu_slots, &cost.fetches, &cost.fetch_cyc, &cost.overdraw,
                      &cost.helpers, &cost.path})
    plane->resize(pixels);
  return frame;
}

Renderer::Renderer(const scenes::Scene& scene, const FrameOptions& options)
    : scene_(scene), options_(options) {
  Timing timing;
  PhaseClock clock(timing);
  prepare(scene, options, prepared_);
  clock.end("prepare");
  prepare_ms_ = timing.phases_ms["prepare"];
}

Frame Renderer::draw(Frame recycled) {
  const auto started = std::chrono::steady_clock::now();
  Frame frame = blank_frame(options_, std::move(recycled));
  PhaseClock clock(frame.timing);
  const DrawList& list = prepared_.list;
  frame.warnings = list.warnings;
  frame.lights = list.lights.description;
  frame.light_count = static_cast<int>(list.lights.lights.size());
  for (const PixelProgram& program : list.pixel_programs) frame.paths.push_back(program.path);

  draw_shadows(prepared_, options_);
  clock.end("shadows");
  shade_all_vertices(prepared_);
  clock.end("vertex");
  set_up_triangles(prepared_, options_);
  clock.end("setup");
  blank_empty_tiles(prepared_.raster_frame, Background(options_.background), frame);
  clock.end("clear");

  GBuffer gbuffer(options_.width, options_.height, list.gbuffer_targets);
  host::PerWorker<TileWorker> workers([&] { return TileWorker(prepared_, options_, gbuffer, frame); });
  const auto order = prepared_.raster_frame.tile_order();
  host::Progress progress("tiles", static_cast<std::int64_t>(order.size()));
  host::parallel_for_workers(static_cast<std::int64_t>(order.size()), [&](std::int64_t i, int worker) {
    workers[worker].run(static_cast<int>(order[static_cast<std::size_t>(i)]));
    progress.advance();
  });
  clock.end("tiles");

  std::array<TileBill::Totals, kPassCount> bill;
  raster::TileCounters tile_counters;
  std::uint64_t tile_lights = 0;
  std::vector<vm::Counters> pixel_counters, light_counters;
  for (const PixelProgram& program : list.pixel_programs) pixel_counters.emplace_back(program.executable);
  for (const PixelProgram& program : prepared_.light_plan.programs)
    light_counters.emplace_back(program.executable);
  workers.for_each([&](const TileWorker& worker) {
    for (std::size_t pass = 0; pass < kPassCount; ++pass)
      bill[pass] += worker.bill().totals(static_cast<Pass>(pass));
    tile_counters += worker.tile_counters();
    tile_lights += worker.light_stage().stage_counters().tile_lights;
    for (std::size_t p = 0; p < pixel_counters.size(); ++p)
      pixel_counters[p] += worker.shader().counters()[p];
    for (std::size_t p = 0; p < light_counters.size(); ++p)
      light_counters[p] += worker.light_stage().counters()[p];
  });
  for (std::size_t p = 0; p < pixel_counters.size(); ++p) {
    vm::raise_loop_overrun(list.pixel_programs[p].program, pixel_counters[p]);
    add_saturations(list.pixel_programs[p].program, pixel_counters[p], options_.checked, frame);
  }
  for (std::size_t p = 0; p < light_counters.size(); ++p)
    add_saturations(prepared_.light_plan.programs[p].program, light_counters[p], options_.checked, frame);
  for (std::size_t p = 0; p < prepared_.vertex_counters.size(); ++p)
    add_saturations(list.vertex_programs[p].program, prepared_.vertex_counters[p], options_.checked, frame);
  frame.saturations += list.sanitised_constants;

  const raster::Frame& raster_frame = prepared_.raster_frame;
  const raster::SetupCounters& setup = raster_frame.counters();
  frame.passes = pass_totals(prepared_, bill, options_.width, options_.height);
  frame.texel_share = list.textures.share();
  frame.skipped = {
      {"frustum", setup.frustum},
      {"facing", setup.facing},
      {"small", setup.small},
      {"tile_hiz", tile_counters.tile_hiz},
      {"block_hiz", tile_counters.block_hiz},
      {"occluded", tile_counters.occluded},
      {"mesh_bounds", setup.outside},
      {"early_z", tile_counters.early_z},
      {"empty_tiles", static_cast<std::uint64_t>(raster_frame.empty_tiles())},
      {"textures", scene_.images.size() - std::min(scene_.images.size(), list.textures.decoded())},
      {"tile_lights", tile_lights},
      {"shadow_casters", prepared_.shadows.skipped_casters}};
  frame.dropped = {{"not a finite position", setup.dropped_nonfinite}};
  resolve(options_, list, frame);
  clock.end("resolve");
  frame.timing.frame_ms = {
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - started).count()};
  frame.timing.phases_ms["prepare"] = prepare_ms_;
  return frame;
}

Frame render_frame(const scenes::Scene& scene, const FrameOptions& options) {
  return Renderer(scene, options).draw();
}

}  // namespace aluminate::passes
