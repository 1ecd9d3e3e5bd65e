#include "shading/passes/shade.hpp"

#include <algorithm>

namespace aluminate::passes {

Shader::Shader(const PreparedFrame& prepared)
    : list_(prepared.list), frame_(prepared.raster_frame), varyings_(prepared.varyings) {
  std::size_t inputs = 0, outputs = 0;
  for (const PixelProgram& program : list_.pixel_programs) {
    counters_.emplace_back(program.executable);
    scratch_.fit(program.executable);
    inputs = std::max(inputs, program.inputs.size());
    outputs = std::max(outputs, program.executable.outputs().size());
  }
  inputs_ = host::AlignedRows(inputs);
  outputs_ = host::AlignedRows(outputs);
}

void Shader::fill_inputs(const PixelProgram& program, const DrawState& draw,
                         std::span<const raster::QuadPosition> quads) {
  raster::interpolate_barycentrics(frame_, quads, barycentrics_, triangles_);
  const std::size_t stride = program.varyings.size();
  std::array<double, raster::kBatchQuads> a0{}, d1{}, d2{};
  const double* corners[raster::kBatchQuads][3];
  for (std::size_t q = 0; q < quads.size(); ++q)
    for (std::size_t k = 0; k < 3; ++k)
      corners[q][k] = &varyings_[draw.first_varying + (triangles_[q].vertex[k] - draw.first_vertex) * stride];
  for (std::size_t row = 0; row < program.inputs.size(); ++row) {
    const InputRow& input = program.inputs[row];
    double* out = inputs_.row(row);
    switch (input.kind) {
      case InputRow::Kind::Varying:
        for (std::size_t q = 0; q < quads.size(); ++q) {
          const double base = corners[q][0][input.varying];
          a0[q] = base;
          d1[q] = corners[q][1][input.varying] - base;
          d2[q] = corners[q][2][input.varying] - base;
        }
        raster::interpolate_attribute(barycentrics_, a0, d1, d2,
                                      std::span<double, raster::kBatchLanes>(out, raster::kBatchLanes));
        break;
      case InputRow::Kind::Face:
        for (std::size_t q = 0; q < quads.size(); ++q)
          std::fill_n(out + 4 * q, 4, triangles_[q].front_facing ? 1.0 : -1.0);
        break;
      case InputRow::Kind::PixelX:
        for (std::size_t q = 0; q < quads.size(); ++q)
          for (std::size_t l = 0; l < 4; ++l) out[4 * q + l] = quads[q].x + static_cast<double>(l & 1) + 0.5;
        break;
      case InputRow::Kind::PixelY:
        for (std::size_t q = 0; q < quads.size(); ++q)
          for (std::size_t l = 0; l < 4; ++l) out[4 * q + l] = quads[q].y + static_cast<double>(l >> 1) + 0.5;
        break;
      case InputRow::Kind::Zero:
        std::fill_n(out, raster::kBatchLanes, 0.0);
        break;
      case InputRow::Kind::One:
        std::fill_n(out, raster::kBatchLanes, 1.0);
        break;
    }
  }
}

vm::Batch Shader::make_batch(const ShadingJob& job) {
  const DrawState& draw = list_.draws[job.draw];
  fill_inputs(list_.pixel_programs[static_cast<std::size_t>(draw.pixel_program)], draw, job.quads);
  vm::Batch batch;
  batch.inputs = inputs_.data();
  batch.outputs = outputs_.data();
  batch.constants = draw.constants.data();
  batch.samplers = draw.samplers;
  batch.active = job.quads.size() == raster::kBatchQuads ? ~std::uint64_t{0}
                                                         : (std::uint64_t{1} << 4 * job.quads.size()) - 1;
  batch.covered = job.covered;
  batch.lane_blocks = job.lane_blocks;
  return batch;
}

void Shader::find_color(const PixelProgram& program) {
  for (std::size_t target = 0; target < kMaxTargets; ++target)
    for (std::size_t c = 0; c < 4; ++c) {
      const int row = program.color_row[target][c];
      color_[target][c] = row < 0 ? nullptr : outputs_.row(static_cast<std::size_t>(row));
    }
}

std::uint64_t Shader::run(const ShadingJob& job) {
  const auto index = static_cast<std::size_t>(list_.draws[job.draw].pixel_program);
  vm::Batch batch = make_batch(job);
  vm::run(list_.pixel_programs[index].executable, batch, scratch_, counters_[index]);
  find_color(list_.pixel_programs[index]);
  return job.covered & ~batch.killed;
}

std::uint64_t Shader::run_traced(const ShadingJob& job, vm::Trace& trace) {
  const auto index = static_cast<std::size_t>(list_.draws[job.draw].pixel_program);
  const PixelProgram& program = list_.pixel_programs[index];
  vm::Batch batch = make_batch(job);
  vm::run_reference(program.program, program.executable, batch, counters_[index], &trace);
  find_color(program);
  return job.covered & ~batch.killed;
}

}  // namespace aluminate::passes
