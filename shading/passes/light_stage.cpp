#include "shading/passes/light_stage.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace aluminate::passes {
namespace {

/// Calls visit(stamp, lane, element) for each pixel of a mask, in stamp order.
template <class Visit>
void for_each_pixel(const StampMask& mask, Visit&& visit) {
  for (std::size_t stamp = 0; stamp < mask.size(); ++stamp)
    for (unsigned rest = mask[stamp]; rest != 0; rest &= rest - 1)
      visit(static_cast<int>(stamp), std::countr_zero(rest));
}

/// Pixels of a stamp inside the picture.
std::uint16_t inside(const raster::TileView& tile, int stamp) {
  unsigned lanes = 0;
  for (int lane = 0; lane < 16; ++lane)
    if (raster::stamp_x(stamp) + raster::lane_x(lane) < tile.width &&
        raster::stamp_y(stamp) + raster::lane_y(lane) < tile.height)
      lanes |= 1u << lane;
  return static_cast<std::uint16_t>(lanes);
}

}  // namespace

LightStage::LightStage(const DrawList& list, const LightPlan& plan, const GBuffer& gbuffer, int width,
                       int height, bool skip)
    : list_(list), plan_(plan), rays_(list.view), width_(width), height_(height), skip_(skip) {
  std::size_t inputs = 0, outputs = 0;
  for (const PixelProgram& program : plan.programs) {
    std::vector<vm::SamplerBinding>& bindings = samplers_.emplace_back();
    for (const vm::SamplerSymbol& symbol : program.program.samplers)
      bindings.push_back(frame_sampler(list, symbol.name).value_or(gbuffer.binding(symbol.name)));
    scratch_.fit(program.executable);
    vm_counters_.emplace_back(program.executable);
    inputs = std::max(inputs, program.inputs.size());
    outputs = std::max(outputs, program.executable.outputs().size());
  }
  inputs_ = host::AlignedRows(inputs);
  outputs_ = host::AlignedRows(outputs);
  below_ = host::AlignedRows(3);
}

void LightStage::find_positions(const raster::TileView& tile, const StampMask& lit) {
  positions_.clear();
  low_ = glm::dvec3(HUGE_VAL);
  high_ = glm::dvec3(-HUGE_VAL);
  for_each_pixel(lit, [&](int stamp, int lane) {
    const int x = tile.origin.x + raster::stamp_x(stamp) + raster::lane_x(lane),
              y = tile.origin.y + raster::stamp_y(stamp) + raster::lane_y(lane);
    const glm::dvec2 ndc(pixel_ndc(x, width_), -pixel_ndc(y, height_));
    const auto element = static_cast<std::size_t>(16 * stamp + lane);
    positions_.push_back(rays_.position(ndc, rays_.distance(tile.depth[element])));
    low_ = glm::min(low_, positions_.back());
    high_ = glm::max(high_, positions_.back());
  });
}

void LightStage::choose_lights() {
  reaching_.clear();
  for (std::uint32_t i = 0; i < plan_.bounded.size(); ++i) {
    const BoundedLight& light = plan_.bounded[i];
    const glm::dvec3 beyond =
        glm::max(glm::max(low_ - light.position, light.position - high_), glm::dvec3(0.0));
    const double reach = light.range + plan_.reach_margin;
    if (skip_ && glm::dot(beyond, beyond) > reach * reach)
      ++counters_.tile_lights;
    else
      reaching_.push_back(i);
  }
  counters_.tile_lights_kept += reaching_.size();
}

void LightStage::bill(const raster::TileView& tile, const StampMask& lit, const raster::BillRule& rule,
                      raster::BillSink& sink) {
  stamps_.clear();
  const auto add = [&](std::uint32_t draw, std::size_t stamp, std::uint16_t pass) {
    if (pass == 0) return;
    const bool whole = rule.kind == raster::BillRule::Kind::Hierarchical;
    const std::uint16_t covered = whole ? inside(tile, static_cast<int>(stamp)) : pass;
    stamps_.push_back({draw, covered, static_cast<std::uint8_t>(stamp)});
  };
  for (std::size_t group = 0; group < plan_.everywhere.size(); ++group)
    for (std::size_t stamp = 0; stamp < lit.size(); ++stamp)
      add(plan_.first_screen_stamp + static_cast<std::uint32_t>(group), stamp, lit[stamp]);
  reaching_.clear();
  if (!plan_.bounded.empty()) {
    find_positions(tile, lit);
    if (!positions_.empty()) choose_lights();
    for (const std::uint32_t i : reaching_) {
      StampMask touched{};
      std::size_t at = 0;
      for_each_pixel(lit, [&](int stamp, int lane) {
        if (plan_.bounded[i].contains(positions_[at++]))
          touched[static_cast<std::size_t>(stamp)] |= static_cast<std::uint16_t>(1u << lane);
      });
      for (std::size_t stamp = 0; stamp < touched.size(); ++stamp)
        add(plan_.bounded[i].stamp_draw, stamp, touched[stamp]);
    }
  }
  sink.billed(stamps_);
}

void LightStage::plan_groups() {
  groups_.clear();
  for (const LightPlan::Group& group : plan_.everywhere) groups_.push_back({group.program, &group.constants});
  shared_.clear();
  for (const std::uint32_t light : reaching_) {
    const int own = plan_.bounded[light].own_group;
    if (own < 0) {
      shared_.push_back(light);
      continue;
    }
    const LightPlan::Group& group = plan_.own[static_cast<std::size_t>(own)];
    groups_.push_back({group.program, &group.constants});
  }
  std::vector<std::pair<std::size_t, std::size_t>> cuts;  // size index, first light
  for (std::size_t first = 0; first < shared_.size();) {
    std::size_t size = 0;
    while (static_cast<std::size_t>(LightPlan::kSizes[size]) > shared_.size() - first) ++size;
    cuts.emplace_back(size, first);
    first += static_cast<std::size_t>(LightPlan::kSizes[size]);
  }
  if (tile_constants_.size() < cuts.size()) tile_constants_.resize(cuts.size());
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const auto [size, first] = cuts[i];
    const std::span<const std::uint32_t> lights(shared_);
    plan_.fill_constants(size, lights.subspan(first, static_cast<std::size_t>(LightPlan::kSizes[size])),
                         tile_constants_[i]);
    groups_.push_back({plan_.sized[size].program, &tile_constants_[i]});
  }
}

void LightStage::fill_inputs(const PixelProgram& program, const std::uint16_t* x, const std::uint16_t* y,
                             int count) {
  for (std::size_t row = 0; row < program.inputs.size(); ++row) {
    const Varying& varying = program.varyings[static_cast<std::size_t>(program.inputs[row].varying)];
    double* out = inputs_.row(row);
    if (varying.semantic == "TEXCOORD1") {
      std::copy_n(below_.row(static_cast<std::size_t>(varying.component)), count, out);
      continue;
    }
    for (int i = 0; i < count; ++i) switch (varying.component) {
        case 0:
          out[i] = (x[i] + 0.5) / width_;
          break;
        case 1:
          out[i] = (y[i] + 0.5) / height_;
          break;
        case 2:
          out[i] = pixel_ndc(x[i], width_);
          break;
        default:
          out[i] = -pixel_ndc(y[i], height_);
      }
  }
}

vm::Batch LightStage::batch_for(const GroupRun& group, int count) {
  vm::Batch batch;
  batch.inputs = inputs_.data();
  batch.outputs = outputs_.data();
  batch.constants = group.constants->data();
  batch.samplers = samplers_[static_cast<std::size_t>(group.program)];
  batch.active = batch.covered = count == vm::kLanes ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
  return batch;
}

void LightStage::take_output(const PixelProgram& program) {
  for (std::size_t c = 0; c < 3; ++c)
    std::copy_n(outputs_.row(static_cast<std::size_t>(program.color_row[0][c])), vm::kLanes, below_.row(c));
}

void LightStage::run(const raster::TileView& tile, const StampMask& lit, Frame& frame) {
  plan_groups();
  std::array<std::uint16_t, vm::kLanes> x{}, y{};
  int count = 0;
  const auto flush = [&] {
    for (std::size_t c = 0; c < 3; ++c) std::fill_n(below_.row(c), vm::kLanes, 0.0);
    for (const GroupRun& group : groups_) {
      const PixelProgram& program = plan_.programs[static_cast<std::size_t>(group.program)];
      fill_inputs(program, x.data(), y.data(), count);
      vm::Batch batch = batch_for(group, count);
      vm::run(program.executable, batch, scratch_, vm_counters_[static_cast<std::size_t>(group.program)]);
      take_output(program);
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      const std::size_t at = std::size_t{y[i]} * static_cast<std::size_t>(width_) + x[i];
      for (std::size_t c = 0; c < 3; ++c) frame.linear[at * 4 + c] = static_cast<float>(below_.row(c)[i]);
    }
    count = 0;
  };
  for_each_pixel(lit, [&](int stamp, int lane) {
    const auto i = static_cast<std::size_t>(count++);
    x[i] = static_cast<std::uint16_t>(tile.origin.x + raster::stamp_x(stamp) + raster::lane_x(lane));
    y[i] = static_cast<std::uint16_t>(tile.origin.y + raster::stamp_y(stamp) + raster::lane_y(lane));
    if (count == vm::kLanes) flush();
  });
  if (count > 0) flush();
}

std::vector<LightStage::TracedGroup> LightStage::trace(int px, int py, glm::dvec3& radiance) {
  plan_groups();
  const auto x = static_cast<std::uint16_t>(px), y = static_cast<std::uint16_t>(py);
  for (std::size_t c = 0; c < 3; ++c) below_.row(c)[0] = 0.0;
  std::vector<TracedGroup> traced;
  for (const GroupRun& group : groups_) {
    const PixelProgram& program = plan_.programs[static_cast<std::size_t>(group.program)];
    fill_inputs(program, &x, &y, 1);
    vm::Batch batch = batch_for(group, 1);
    TracedGroup entry{group.program, {}};
    vm::run_reference(program.program, program.executable, batch,
                      vm_counters_[static_cast<std::size_t>(group.program)], &entry.trace);
    take_output(program);
    traced.push_back(std::move(entry));
  }
  for (std::size_t c = 0; c < 3; ++c) radiance[static_cast<int>(c)] = below_.row(c)[0];
  return traced;
}

}  // namespace aluminate::passes
