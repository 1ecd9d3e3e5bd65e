// The forward pipeline, from a scene to a frame: vertices, set-up, then tile by tile visibility, shading and
// the bill.
#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>

#include "platform/host/log.hpp"
#include "platform/host/parallel.hpp"
#include "platform/host/progress.hpp"
#include "platform/host/workers.hpp"
#include "rasterizer/frame.hpp"
#include "rasterizer/quads.hpp"
#include "rasterizer/tile.hpp"
#include "shading/passes/bill.hpp"
#include "shading/passes/draw_list.hpp"
#include "shading/passes/frame.hpp"
#include "shading/passes/prepared.hpp"
#include "shading/passes/resolve.hpp"
#include "shading/passes/sample_colors.hpp"
#include "shading/passes/shade.hpp"

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

// One worker: rasterizes a tile, shades it, bills it.
class TileWorker : public raster::QuadShader {
 public:
  TileWorker(const PreparedFrame& prepared, const raster::TileOptions& options, Frame& frame)
      : list_(prepared.list),
        raster_frame_(prepared.raster_frame),
        tile_(prepared.raster_frame, options),
        shader_(prepared),
        bill_(prepared.list),
        samples_(prepared.raster_frame.samples()),
        sample_colors_(samples_),
        frame_(frame) {}

  void run(int tile) {
    bill_.begin();
    tile_.begin(tile);
    if (samples_ > 1) sample_colors_.begin(tile_.view(), frame_);
    tile_.draw_opaque(&bill_);
    shade_visible();
    tile_.draw_in_order(*this, &bill_);
    if (samples_ > 1) sample_colors_.resolve(tile_.view(), frame_);
    bill_.store(tile_.view(), frame_.width, frame_.cost);
    raster::store_depth(tile_.view(), frame_.depth_d24, frame_.width);
  }

  // InOrder quads: alpha-tested, blended, or shaders that branch on data.
  std::uint64_t shade(const raster::QuadBatch& batch) override {
    const DrawState& draw = list_.draws[batch.draw];
    const PixelProgram& program = list_.pixel_programs[static_cast<std::size_t>(draw.pixel_program)];
    std::array<raster::QuadPosition, raster::kBatchQuads> quads;
    const auto count = static_cast<std::size_t>(batch.count);
    for (std::size_t q = 0; q < count; ++q) quads[q] = {batch.triangle[q], batch.x[q], batch.y[q]};
    std::uint32_t* lane_blocks = nullptr;
    if (!program.straight_line) {
      lane_blocks_.assign(program.executable.block_count() * vm::kLanes, 0);
      lane_blocks = lane_blocks_.data();
    }
    const std::uint64_t wanted = batch.visible | (program.straight_line ? 0 : batch.billed);
    const std::uint64_t kept =
        shader_.run({batch.draw, {quads.data(), count}, wanted, lane_blocks}) & batch.visible;
    if (lane_blocks) bill_executed(program, batch);
    for (std::uint64_t lanes = kept; lanes; lanes &= lanes - 1) {
      const int lane = std::countr_zero(lanes);
      const std::size_t q = static_cast<std::size_t>(lane) / 4;
      unsigned samples = 0;
      for (std::size_t s = 0; s < static_cast<std::size_t>(samples_); ++s)
        samples |= static_cast<unsigned>(batch.visible_samples[s] >> lane & 1) << s;
      store(batch.x[q] + (lane & 1), batch.y[q] + (lane >> 1 & 1), samples, lane, draw);
    }
    return kept;
  }

  const Shader& shader() const { return shader_; }
  const TileBill& bill() const { return bill_; }
  const raster::TileCounters& tile_counters() const { return tile_.counters(); }

 private:
  void shade_visible() {
    raster::gather_visible_quads(raster_frame_, tile_.view(), visible_);
    std::array<raster::QuadPosition, raster::kBatchQuads> quads;
    std::array<std::uint16_t, raster::kBatchQuads> quad_samples;
    for (std::size_t first = 0; first < visible_.size();) {
      const std::uint32_t draw = visible_[first].draw;
      std::size_t count = 0;
      std::uint64_t covered = 0;
      while (count < raster::kBatchQuads && first + count < visible_.size() &&
             visible_[first + count].draw == draw) {
        const raster::VisibleQuad& quad = visible_[first + count];
        quads[count] = {quad.triangle, quad.x, quad.y};
        quad_samples[count] = quad.samples;
        covered |= std::uint64_t{quad.lanes} << 4 * count;
        ++count;
      }
      shader_.run({draw, {quads.data(), count}, covered, nullptr});
      for (std::uint64_t lanes = covered; lanes; lanes &= lanes - 1) {
        const int lane = std::countr_zero(lanes);
        const std::size_t q = static_cast<std::size_t>(lane) / 4;
        // One bit of every nibble: the lane's samples.
        const unsigned bits = quad_samples[q] >> (lane & 3) & 0x1111u;
        const unsigned samples = (bits | bits >> 3 | bits >> 6 | bits >> 9) & 0xfu;
        store(quads[q].x + (lane & 1), quads[q].y + (lane >> 1 & 1), samples, lane, list_.draws[draw]);
      }
      first += count;
    }
  }

  // Colour of one pixel, or of those of its samples that the lane won, into the frame.
  void store(int x, int y, unsigned samples, int lane, const DrawState& draw) {
    const std::size_t at =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(frame_.width) + static_cast<std::size_t>(x);
    const bool blended = draw.surface == Surface::Blended;
    if (samples_ == 1) {
      write(&frame_.linear[at * 4], lane, blended);
    } else {
      const raster::TileOrigin origin = tile_.view().origin;
      for (; samples != 0; samples &= samples - 1)
        write(sample_colors_.at(x - origin.x, y - origin.y, std::countr_zero(samples)), lane, blended);
    }
    frame_.linear[at * 4 + 3] = 1.0f;
    frame_.covered[at] = 1;
    frame_.cost.path[at] = static_cast<std::uint32_t>(draw.pixel_program) + 1;
  }

  // RGB: replaced, or blended over what is there, in linear light.
  void write(float* rgb, int lane, bool blended) const {
    const double alpha = blended ? std::clamp(shader_.color(3, lane), 0.0, 1.0) : 1.0;
    for (int c = 0; c < 3; ++c)
      rgb[c] = static_cast<float>(blended ? shader_.color(c, lane) * alpha + rgb[c] * (1.0 - alpha)
                                          : shader_.color(c, lane));
  }

  // Executed cost of a batch whose program branches on data: blocks times executions, for every lane of a
  // billed quad.
  void bill_executed(const PixelProgram& program, const raster::QuadBatch& batch) {
    const raster::TileOrigin origin = tile_.view().origin;
    for (int lane = 0; lane < 4 * batch.count; ++lane) {
      if ((batch.billed >> (lane & ~3) & 0xf) == 0) continue;
      const LaneCost cost = executed_cost(program, lane_blocks_, lane);
      const auto q = static_cast<std::size_t>(lane) / 4;
      bill_.add_executed(batch.x[q] + (lane & 1) - origin.x, batch.y[q] + (lane >> 1 & 1) - origin.y, cost);
    }
  }

  const DrawList& list_;
  const raster::Frame& raster_frame_;
  raster::TileRasterizer tile_;
  Shader shader_;
  TileBill bill_;
  const int samples_;  // a pixel
  SampleColors sample_colors_;
  Frame& frame_;
  std::vector<raster::VisibleQuad> visible_;
  std::vector<std::uint32_t> lane_blocks_;
};

Frame blank_frame(const FrameOptions& options) {
  Frame frame;
  frame.width = options.width;
  frame.height = options.height;
  frame.samples = options.msaa;
  const std::size_t pixels = frame.pixel_count();
  frame.linear.resize(pixels * 4);
  frame.covered.resize(pixels);
  frame.depth_d24.assign(pixels, raster::kDepthMax);
  CostPlanes& cost = frame.cost;
  for (auto* plane : {&cost.alu_words, &cost.alu_slots, &cost.fetches, &cost.fetch_cyc, &cost.overdraw,
                      &cost.helpers, &cost.path})
    plane->resize(pixels);
  return frame;
}

PassTotals forward_totals(const DrawList& list, const std::vector<vm::Counters>& vertex_counters,
                          const TileBill::Totals& bill, const raster::SetupCounters& setup) {
  PassTotals pass;
  pass.name = "forward";
  pass.pixels = bill.pixels;
  pass.quads = bill.quads;
  pass.helper_lanes = bill.helper_lanes;
  pass.alu_words = bill.alu_words;
  pass.alu_slots = bill.alu_slots;
  pass.fetches = bill.fetches;
  pass.fetch_cyc = bill.fetch_cyc;
  pass.rop_pixels = bill.pixels - bill.blended_pixels;
  pass.rop_blended = bill.blended_pixels;
  pass.triangles = setup.submitted;
  for (std::size_t i = 0; i < vertex_counters.size(); ++i) {
    const std::uint64_t vertices =
        vertex_counters[i].blocks.empty() ? 0 : vertex_counters[i].blocks.front().covered_lanes;
    pass.vertices += vertices;
    pass.vertex_words += vertices * static_cast<std::uint64_t>(std::ceil(list.vertex_costs[i].alu_words));
    // Attributes as 32-bit floats, what the vertex program reads of them.
    pass.bytes += vertices * 4 * list.vertex_programs[i].executable.inputs().size();
  }
  pass.bytes += list.indices.size() * (list.vertex_count < 65536 ? 2 : 4) + list.textures.texel_bytes();
  return pass;
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

Frame render_frame(const scenes::Scene& scene, const FrameOptions& options) {
  Frame frame = blank_frame(options);
  PhaseClock clock(frame.timing);
  const auto started = std::chrono::steady_clock::now();
  PreparedFrame prepared;
  prepared.list = make_draw_list(scene, options);
  const DrawList& list = prepared.list;
  frame.warnings = list.warnings;
  frame.lights = list.lights.description;
  frame.light_count = static_cast<int>(list.lights.lights.size());
  for (const PixelProgram& program : list.pixel_programs) frame.paths.push_back(program.path);
  clock.end("prepare");

  shade_all_vertices(prepared);
  clock.end("vertex");
  set_up_triangles(prepared, options);
  clock.end("setup");
  const raster::Frame& raster_frame = prepared.raster_frame;
  const std::vector<vm::Counters>& vertex_counters = prepared.vertex_counters;

  clear_to_background(options.background, frame);
  host::PerWorker<TileWorker> workers(
      [&] { return TileWorker(prepared, tile_options(list.gpu, options), frame); });
  const auto order = raster_frame.tile_order();
  host::Progress progress("tiles", static_cast<std::int64_t>(order.size()));
  host::parallel_for_workers(static_cast<std::int64_t>(order.size()), [&](std::int64_t i, int worker) {
    workers[worker].run(static_cast<int>(order[static_cast<std::size_t>(i)]));
    progress.advance();
  });
  clock.end("tiles");

  TileBill::Totals bill;
  raster::TileCounters tile_counters;
  std::vector<vm::Counters> pixel_counters;
  for (const PixelProgram& program : list.pixel_programs) pixel_counters.emplace_back(program.executable);
  workers.for_each([&](const TileWorker& worker) {
    bill += worker.bill().totals();
    tile_counters += worker.tile_counters();
    for (std::size_t p = 0; p < pixel_counters.size(); ++p)
      pixel_counters[p] += worker.shader().counters()[p];
  });
  for (std::size_t p = 0; p < pixel_counters.size(); ++p) {
    vm::raise_loop_overrun(list.pixel_programs[p].program, pixel_counters[p]);
    add_saturations(list.pixel_programs[p].program, pixel_counters[p], options.checked, frame);
  }
  for (std::size_t p = 0; p < vertex_counters.size(); ++p)
    add_saturations(list.vertex_programs[p].program, vertex_counters[p], options.checked, frame);
  frame.saturations += list.sanitised_constants;

  const raster::SetupCounters& setup = raster_frame.counters();
  frame.passes.push_back(forward_totals(list, vertex_counters, bill, setup));
  frame.skipped = {
      {"frustum", setup.frustum},
      {"facing", setup.facing},
      {"small", setup.small},
      {"tile_hiz", tile_counters.tile_hiz},
      {"block_hiz", tile_counters.block_hiz},
      {"occluded", tile_counters.occluded},
      {"mesh_bounds", setup.outside},
      {"early_z", tile_counters.early_z},
      {"empty_tiles", static_cast<std::uint64_t>(raster_frame.viewport().tile_count()) - order.size()},
      {"textures", scene.images.size() - std::min(scene.images.size(), list.textures.decoded())}};
  frame.dropped = {{"not a finite position", setup.dropped_nonfinite}};
  resolve(options, list, frame);
  clock.end("resolve");
  frame.timing.frame_ms = {
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - started).count()};
  return frame;
}

}  // namespace aluminate::passes
