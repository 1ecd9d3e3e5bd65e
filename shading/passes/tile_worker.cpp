#include "shading/passes/tile_worker.hpp"

#include <algorithm>
#include <bit>

namespace aluminate::passes {

TileWorker::TileWorker(const PreparedFrame& prepared, const FrameOptions& options, GBuffer& gbuffer,
                       Frame& frame)
    : list_(prepared.list),
      raster_frame_(prepared.raster_frame),
      options_(tile_options(prepared.list.gpu, options)),
      tile_(prepared.raster_frame, options_),
      shader_(prepared),
      bill_(prepared.list),
      light_(prepared.list, prepared.light_plan, gbuffer, frame.width, frame.height,
             !options.no_skip.contains("tile_lights")),
      samples_(prepared.raster_frame.samples()),
      background_(options.background),
      encodes_(options.tonemap == Tonemap::None),
      sample_colors_(samples_),
      gbuffer_(gbuffer),
      frame_(frame) {}

void TileWorker::run(int tile) {
  bill_.begin();
  tile_.begin(tile);
  clear_pixels(background_, pixels(), frame_);
  lit_.fill(0);
  lights_due_ = list_.gbuffer_targets > 0;
  if (samples_ > 1) sample_colors_.begin(tile_.view(), frame_);
  tile_.draw_opaque(&bill_);
  shade_visible();
  tile_.draw_in_order(*this, &bill_);
  if (lights_due_) light_up();
  if (samples_ > 1) sample_colors_.resolve(tile_.view(), frame_);
  bill_.store(tile_.view(), frame_.width, frame_.cost);
  raster::store_depth(tile_.view(), frame_.depth_d24, frame_.width);
  if (encodes_) encode_pixels(background_, pixels(), frame_);
}

PixelRect TileWorker::pixels() const {
  const raster::TileView view = tile_.view();
  return {view.origin.x, view.origin.y, view.width, view.height};
}

std::uint64_t TileWorker::shade(const raster::QuadBatch& batch) {
  const DrawState& draw = list_.draws[batch.draw];
  if (lights_due_ && draw.pass != Pass::Gbuffer) light_up();
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
  store_batch({quads.data(), count}, kept, draw, batch.visible_samples);
  return kept;
}

void TileWorker::shade_visible() {
  raster::gather_visible_quads(raster_frame_, tile_.view(), visible_);
  std::array<raster::QuadPosition, raster::kBatchQuads> quads;
  for (std::size_t first = 0; first < visible_.size();) {
    const std::uint32_t draw = visible_[first].draw;
    std::size_t count = 0;
    std::uint64_t covered = 0;
    std::array<std::uint64_t, raster::kMaxSamples> samples{};
    while (count < raster::kBatchQuads && first + count < visible_.size() &&
           visible_[first + count].draw == draw) {
      const raster::VisibleQuad& quad = visible_[first + count];
      quads[count] = {quad.triangle, quad.x, quad.y};
      covered |= std::uint64_t{quad.lanes} << 4 * count;
      for (std::size_t s = 0; s < static_cast<std::size_t>(samples_); ++s)
        samples[s] |= std::uint64_t{quad.samples >> 4 * s & 0xfu} << 4 * count;
      ++count;
    }
    shader_.run({draw, {quads.data(), count}, covered, nullptr});
    store_batch({quads.data(), count}, covered, list_.draws[draw], samples);
    first += count;
  }
}

// The G-buffer of the tile is complete: no later draw of the list writes it.
void TileWorker::light_up() {
  lights_due_ = false;
  const raster::TileView view = tile_.view();
  for (std::size_t stamp = 0; stamp < lit_.size(); ++stamp)
    for (unsigned rest = lit_[stamp]; rest != 0; rest &= rest - 1) {
      const int lane = std::countr_zero(rest);
      const int x = view.origin.x + raster::stamp_x(static_cast<int>(stamp)) + raster::lane_x(lane),
                y = view.origin.y + raster::stamp_y(static_cast<int>(stamp)) + raster::lane_y(lane);
      gbuffer_.store_depth(
          static_cast<std::size_t>(y) * static_cast<std::size_t>(frame_.width) + static_cast<std::size_t>(x),
          view.depth[16 * stamp + static_cast<std::size_t>(lane)]);
    }
  light_.bill(view, lit_, options_.bill, bill_);
  light_.run(view, lit_, frame_);
}

// What the shader has just made of these lanes. samples: by sample, the lanes that won it.
void TileWorker::store_batch(std::span<const raster::QuadPosition> quads, std::uint64_t lanes, const DrawState& draw,
                             const std::array<std::uint64_t, raster::kMaxSamples>& samples) {
  if (samples_ == 1 && draw.pass != Pass::Gbuffer && draw.surface != Surface::Blended) {
    store_quads(quads, lanes, static_cast<std::uint32_t>(draw.pixel_program) + 1, shader_.rgb(), frame_);
    return;
  }
  for (; lanes != 0; lanes &= lanes - 1) {
    const int lane = std::countr_zero(lanes);
    const raster::QuadPosition& quad = quads[static_cast<std::size_t>(lane) / 4];
    unsigned won = 0;
    for (std::size_t s = 0; s < static_cast<std::size_t>(samples_); ++s)
      won |= static_cast<unsigned>(samples[s] >> lane & 1) << s;
    store(quad.x + (lane & 1), quad.y + (lane >> 1 & 1), won, lane, draw);
  }
}

// Result of one pixel, or of those of its samples that the lane won: G-buffer texels, or colour.
void TileWorker::store(int x, int y, unsigned samples, int lane, const DrawState& draw) {
  const std::size_t at =
      static_cast<std::size_t>(y) * static_cast<std::size_t>(frame_.width) + static_cast<std::size_t>(x);
  frame_.covered[at] = 1;
  frame_.cost.path[at] = static_cast<std::uint32_t>(draw.pixel_program) + 1;
  const raster::TileOrigin origin = tile_.view().origin;
  const int tx = x - origin.x, ty = y - origin.y;
  if (draw.pass == Pass::Gbuffer) {  // one sample a pixel: draw_list.cpp refuses others
    gbuffer_.store(at, [&](std::size_t target, int channel) { return shader_.color(channel, lane, target); });
    lit_[static_cast<std::size_t>(raster::stamp_of(tx, ty))] |=
        static_cast<std::uint16_t>(1u << raster::lane_of(tx, ty));
    return;
  }
  const bool blended = draw.surface == Surface::Blended;
  if (samples_ == 1) {
    write(&frame_.linear[at * 4], lane, blended);
    return;
  }
  for (; samples != 0; samples &= samples - 1)
    write(sample_colors_.at(tx, ty, std::countr_zero(samples)), lane, blended);
}

// RGB: replaced, or blended over what is there, in linear light.
void TileWorker::write(float* rgb, int lane, bool blended) const {
  const double alpha = blended ? std::clamp(shader_.color(3, lane), 0.0, 1.0) : 1.0;
  for (int c = 0; c < 3; ++c)
    rgb[c] = static_cast<float>(blended ? shader_.color(c, lane) * alpha + rgb[c] * (1.0 - alpha)
                                        : shader_.color(c, lane));
}

// Executed cost of a batch whose program branches on data: blocks times executions, for every lane of a
// billed quad.
void TileWorker::bill_executed(const PixelProgram& program, const raster::QuadBatch& batch) {
  const raster::TileOrigin origin = tile_.view().origin;
  for (int lane = 0; lane < 4 * batch.count; ++lane) {
    if ((batch.billed >> (lane & ~3) & 0xf) == 0) continue;
    const LaneCost cost = executed_cost(program, lane_blocks_, lane);
    const auto q = static_cast<std::size_t>(lane) / 4;
    bill_.add_executed(batch.draw, batch.x[q] + (lane & 1) - origin.x,
                       batch.y[q] + (lane >> 1 & 1) - origin.y, cost);
  }
}

}  // namespace aluminate::passes
