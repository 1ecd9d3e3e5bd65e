#include "shading/passes/inspect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "platform/host/error.hpp"
#include "platform/host/text_table.hpp"
#include "rasterizer/bill.hpp"
#include "rasterizer/quads.hpp"
#include "scenes/scene.hpp"
#include "shading/passes/bill.hpp"
#include "shading/passes/pixel_fragments.hpp"
#include "shading/passes/prepared.hpp"
#include "shading/passes/resolve.hpp"
#include "shading/passes/shade.hpp"
#include "shading/passes/tile_worker.hpp"

namespace aluminate::passes {
namespace {

// Draws the pixel's tile again and writes down everything that touches the pixel.
class Microscope : public raster::QuadShader, public raster::BillSink {
 public:
  /// `drawn`: the worker that has just drawn the pixel's tile into `gbuffer`.
  Microscope(const PreparedFrame& prepared, const FrameOptions& options, const GBuffer& gbuffer,
             const TileWorker& drawn, PixelReport& report)
      : prepared_(prepared),
        options_(tile_options(prepared.list.gpu, options)),
        tile_(prepared.raster_frame, options_),
        shader_(prepared),
        samples_(static_cast<std::size_t>(prepared.raster_frame.samples())),
        light_(prepared.list, prepared.light_plan, gbuffer, options.width, options.height, true),
        drawn_(drawn),
        lights_due_(prepared.list.gbuffer_targets > 0),
        report_(report) {
    const std::array<float, 4> background = Background(options.background).linear;
    colors_.fill({background[0], background[1], background[2]});
  }

  void look(int tile_index, int x, int y) {
    tile_.begin(tile_index);
    x_ = x - tile_.view().origin.x;
    y_ = y - tile_.view().origin.y;
    tile_.draw_opaque(this);
    trace_visible();
    tile_.draw_in_order(*this, this);
    if (lights_due_) light_up();
    report_.depth_d24 = tile_.view().depth[static_cast<std::size_t>(tile_.view().element(x_, y_, 0))];
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = 0;
      for (std::size_t s = 0; s < samples_; ++s) sum += colors_[s][c];
      report_.linear[c] = sum / static_cast<double>(samples_);
    }
  }

  void billed(std::span<const raster::BilledStamp> stamps) override {
    for (const raster::BilledStamp& stamp : stamps) {
      if (stamp.stamp != raster::stamp_of(x_, y_)) continue;
      const int lane = raster::lane_of(x_, y_);
      if ((raster::shaded_lanes(stamp.covered) >> lane & 1) == 0) continue;
      if (!program_of(stamp.draw).straight_line) continue;  // billed as executed, see shade()
      const PathInfo& path = program_of(stamp.draw).path;
      add_visit(stamp.draw, (stamp.covered >> lane & 1) ? "z-failed" : "helper lane",
                {path.alu_words, path.alu_slots, path.fetches, path.fetch_cyc});
    }
  }

  std::uint64_t shade(const raster::QuadBatch& batch) override {
    if (lights_due_ && prepared_.list.draws[batch.draw].pass != Pass::Gbuffer) light_up();
    std::array<raster::QuadPosition, raster::kBatchQuads> quads;
    const auto count = static_cast<std::size_t>(batch.count);
    const int px = x_ + tile_.view().origin.x, py = y_ + tile_.view().origin.y;
    const int lane_in_quad = (py & 1) * 2 + (px & 1);
    const PixelProgram& program = program_of(batch.draw);
    std::vector<int> here;     // lanes of this batch at the pixel
    std::vector<int> visible;  // those that are visible: of one triangle, or with several samples of more
    for (std::size_t q = 0; q < count; ++q) {
      quads[q] = {batch.triangle[q], batch.x[q], batch.y[q]};
      if (batch.x[q] != (px & ~1) || batch.y[q] != (py & ~1)) continue;
      here.push_back(static_cast<int>(4 * q) + lane_in_quad);
      if (batch.visible >> here.back() & 1) visible.push_back(here.back());
    }
    ShadingJob job{batch.draw, {quads.data(), count}, batch.visible, nullptr};
    if (!program.straight_line && !here.empty()) {
      std::vector<std::uint32_t> lane_blocks(program.executable.block_count() * vm::kLanes);
      job.covered |= batch.billed;
      job.lane_blocks = lane_blocks.data();
      shader_.run(job);
      for (const int lane : here)
        if (batch.billed >> (lane & ~3) & 0xf)
          add_visit(batch.draw, (batch.billed >> lane & 1) ? "z-failed" : "helper lane",
                    executed_cost(program, lane_blocks, lane));
      job.covered = batch.visible;
      job.lane_blocks = nullptr;
    }
    if (visible.empty()) return shader_.run(job);
    const bool kept = trace(job, visible.back());
    const bool blended = prepared_.list.draws[batch.draw].surface == Surface::Blended;
    if (!report_.visits.empty() && report_.visits.back().draw == batch.draw)
      report_.visits.back().outcome = !kept ? "discarded" : blended ? "blended" : "drawn";
    if (prepared_.list.draws[batch.draw].pass == Pass::Gbuffer) return survivors_;
    for (const int lane : visible)
      for (std::size_t s = 0; s < samples_; ++s)
        if ((survivors_ & batch.visible_samples[s]) >> lane & 1) compose(s, lane, blended);
    return survivors_;
  }

 private:
  // A draw of the list, or one over the G-buffer.
  const ScreenDraw* screen_draw(std::uint32_t draw) const {
    const std::size_t first = prepared_.list.draws.size();
    return draw < first ? nullptr : &prepared_.list.screen_draws[draw - first];
  }
  const PixelProgram& program_of(std::uint32_t draw) const {
    const ScreenDraw* over = screen_draw(draw);
    return prepared_.list.pixel_programs[static_cast<std::size_t>(
        over ? over->pixel_program : prepared_.list.draws[draw].pixel_program)];
  }
  const std::string& name_of(std::uint32_t draw) const {
    const ScreenDraw* over = screen_draw(draw);
    return over ? over->name : prepared_.list.draws[draw].mesh->name;
  }

  // The light passes, as billed; where a lit surface is seen here, traced.
  void light_up() {
    lights_due_ = false;
    light_.bill(drawn_.view(), drawn_.lit(), options_.bill, *this);
    const bool lit =
        drawn_.lit()[static_cast<std::size_t>(raster::stamp_of(x_, y_))] >> raster::lane_of(x_, y_) & 1;
    for (PixelVisit& visit : report_.visits)
      if (screen_draw(visit.draw) && visit.outcome == "z-failed") visit.outcome = lit ? "lit" : "not lit";
    if (!lit) return;
    glm::dvec3 radiance(0.0);
    const auto groups = light_.trace(x_ + tile_.view().origin.x, y_ + tile_.view().origin.y, radiance);
    for (int c = 0; c < 3; ++c) colors_[0][static_cast<std::size_t>(c)] = radiance[c];
    for (const LightStage::TracedGroup& group : groups)
      record(group.trace, prepared_.light_plan.programs[static_cast<std::size_t>(group.program)], false);
  }

  void record(const vm::Trace& recorded, const PixelProgram& program, bool anew) {
    if (anew) {
      report_.traced_program = program.path.program;
      report_.trace.clear();
    } else {
      report_.traced_program += " > " + program.path.program;
    }
    for (const vm::TraceEntry& entry : recorded.entries) {
      const vm::Instruction& instruction = program.program.code[entry.instruction];
      const std::string file = instruction.line.file < program.program.files.size()
                                   ? program.program.files[instruction.line.file]
                                   : "";
      report_.trace.push_back(
          {vm::disassemble(program.program, instruction),
           SourcePlace{file, static_cast<int>(instruction.line.line), instruction.line.column}.text(),
           entry.result, entry.mask, entry.saturated != 0});
    }
  }

  void add_visit(std::uint32_t draw, const char* outcome, const LaneCost& cost) {
    report_.visits.push_back({draw, name_of(draw), program_of(draw).path.program, outcome, cost.alu_words,
                              cost.alu_slots, cost.fetches, cost.fetch_cyc});
    report_.alu_words += cost.alu_words;
    report_.alu_slots += cost.alu_slots;
    report_.fetches += cost.fetches;
    report_.fetch_cyc += cost.fetch_cyc;
  }

  void trace_visible() {
    std::vector<raster::VisibleQuad> quads;
    raster::gather_visible_quads(prepared_.raster_frame, tile_.view(), quads);
    const int px = x_ + tile_.view().origin.x, py = y_ + tile_.view().origin.y;
    for (const raster::VisibleQuad& quad : quads) {
      const int lane = (py & 1) * 2 + (px & 1);
      if (quad.x != (px & ~1) || quad.y != (py & ~1) || (quad.lanes >> lane & 1) == 0) continue;
      const raster::QuadPosition position{quad.triangle, quad.x, quad.y};
      trace({quad.draw, {&position, 1}, quad.lanes, nullptr}, lane);
      if (prepared_.list.draws[quad.draw].pass != Pass::Gbuffer)
        for (std::size_t s = 0; s < samples_; ++s)
          if (quad.samples >> (4 * s + static_cast<std::size_t>(lane)) & 1) compose(s, lane, false);
      for (auto visit = report_.visits.rbegin(); visit != report_.visits.rend(); ++visit) {
        if (visit->draw != quad.draw || visit->outcome != "z-failed") continue;
        visit->outcome = "drawn";
        break;
      }
    }
  }

  bool trace(const ShadingJob& job, int lane) {
    vm::Trace recorded;
    recorded.lane = lane;
    survivors_ = shader_.run_traced(job, recorded);
    record(recorded, program_of(job.draw), true);
    return survivors_ >> lane & 1;
  }

  void compose(std::size_t sample, int lane, bool blended) {
    const double alpha = blended ? std::clamp(shader_.color(3, lane), 0.0, 1.0) : 1.0;
    for (std::size_t c = 0; c < 3; ++c)
      colors_[sample][c] =
          shader_.color(static_cast<int>(c), lane) * alpha + colors_[sample][c] * (1.0 - alpha);
  }

  const PreparedFrame& prepared_;
  raster::TileOptions options_;
  raster::TileRasterizer tile_;
  Shader shader_;
  const std::size_t samples_;  // a pixel
  std::array<std::array<double, 3>, raster::kMaxSamples> colors_{};
  LightStage light_;
  const TileWorker& drawn_;
  bool lights_due_;
  PixelReport& report_;
  int x_ = 0, y_ = 0;  // tile-relative
  std::uint64_t survivors_ = 0;
};

// Fragments of one draw stand together in submission order and cost the same, so which of them passed is a
// matter of how many did: the first ones are taken to have failed.
void name_fragments(const PreparedFrame& prepared, int tile, int x, int y, PixelReport& report) {
  const auto counted = [&](raster::BillRule::Kind rule) {
    std::map<std::uint32_t, int> count;
    for (const std::uint32_t draw : fragments_at(prepared, tile, x, y, rule)) ++count[draw];
    return count;
  };
  const std::map<std::uint32_t, int> covering = counted(raster::BillRule::Kind::Everything);
  std::map<std::uint32_t, int> passing = counted(raster::BillRule::Kind::PerPixel);
  for (auto visit = report.visits.rbegin(); visit != report.visits.rend(); ++visit) {
    if (visit->draw >= prepared.list.draws.size() || visit->outcome == "helper lane") continue;
    const bool opaque = prepared.raster_frame.draws()[visit->draw].draw_class == raster::DrawClass::Opaque;
    if (passing[visit->draw]-- > 0 && visit->outcome == "z-failed" && opaque) visit->outcome = "overdrawn";
  }
  for (const auto& [draw, fragments] : covering) {
    const auto shaded = std::count_if(
        report.visits.begin(), report.visits.end(),
        [&, draw = draw](const PixelVisit& v) { return v.draw == draw && v.outcome != "helper lane"; });
    auto behind = report.visits.begin();  // the last visit of this or an earlier draw
    for (auto visit = report.visits.begin(); visit != report.visits.end(); ++visit)
      if (visit->draw <= draw) behind = visit + 1;
    const PixelProgram& program =
        prepared.list.pixel_programs[static_cast<std::size_t>(prepared.list.draws[draw].pixel_program)];
    const PixelVisit rejected{draw, prepared.list.draws[draw].mesh->name, program.path.program,
                              "z-failed early"};
    if (fragments > shaded)
      report.visits.insert(behind, static_cast<std::size_t>(fragments - shaded), rejected);
  }
}

std::string value_text(const TracedInstruction& row) {
  std::string text;
  for (std::size_t c = 0; c < 4; ++c)
    if (row.mask >> c & 1)
      text += fmt::format("{}{}={:.9g}", text.empty() ? "" : " ", "xyzw"[c], row.value[c]);
  return text + (row.saturated ? "  SATURATED" : "");
}

}  // namespace

PixelReport inspect_pixel(const scenes::Scene& scene, const FrameOptions& options, int x, int y) {
  if (x < 0 || y < 0 || x >= options.width || y >= options.height)
    throw UserError(
        fmt::format("pixel ({}, {}) lies outside the {}x{} picture", x, y, options.width, options.height),
        "pixels count from 0,0 at the top left");
  PixelReport report;
  report.x = x;
  report.y = y;
  PreparedFrame prepared;
  prepare(scene, options, prepared);
  draw_shadows(prepared, options);
  shade_all_vertices(prepared);
  set_up_triangles(prepared, options);
  const raster::Viewport& viewport = prepared.raster_frame.viewport();
  const int tile = y / raster::kTilePx * viewport.tiles_x() + x / raster::kTilePx;
  Frame scratch = blank_frame(options);
  GBuffer gbuffer(options.width, options.height, prepared.list.gbuffer_targets);
  TileWorker worker(prepared, options, gbuffer, scratch);
  worker.run(tile);
  Microscope(prepared, options, gbuffer, worker, report).look(tile, x, y);
  name_fragments(prepared, tile, x % raster::kTilePx, y % raster::kTilePx, report);
  return report;
}

std::string pixel_text(const PixelReport& report) {
  using host::Align;
  std::string text =
      fmt::format("pixel ({}, {})  linear {:.6g} {:.6g} {:.6g}  depth {} of 16777215\n\n", report.x, report.y,
                  report.linear[0], report.linear[1], report.linear[2], report.depth_d24);
  if (report.visits.empty()) return text + "no draw covers this pixel\n";
  host::TextTable visits({{"draw", Align::Right},
                          {"mesh"},
                          {"program"},
                          {"outcome"},
                          {"ALU words", Align::Right},
                          {"slots", Align::Right},
                          {"fetches", Align::Right},
                          {"fetch cyc", Align::Right}});
  for (const PixelVisit& visit : report.visits)
    visits.add_row({fmt::format("{}", visit.draw), visit.mesh, visit.program, visit.outcome,
                    fmt::format("{}", visit.alu_words), fmt::format("{}", visit.alu_slots),
                    fmt::format("{}", visit.fetches), fmt::format("{}", visit.fetch_cyc)});
  visits.add_rule();
  visits.add_row({"", "total", "", "", fmt::format("{}", report.alu_words),
                  fmt::format("{}", report.alu_slots), fmt::format("{}", report.fetches),
                  fmt::format("{}", report.fetch_cyc)});
  text += visits.text();
  if (report.trace.empty()) return text;
  host::TextTable trace({{"#", Align::Right}, {"instruction"}, {"value"}, {"source"}});
  for (std::size_t i = 0; i < report.trace.size(); ++i)
    trace.add_row(
        {fmt::format("{}", i), report.trace[i].text, value_text(report.trace[i]), report.trace[i].place});
  return text + fmt::format("\n{}\n", report.traced_program) + trace.text();
}

}  // namespace aluminate::passes
