#include "shading/passes/shade.hpp"

#include <algorithm>
#include <cmath>

namespace aluminate::passes {

Shader::Shader(const PreparedFrame& prepared)
    : list_(prepared.list), frame_(prepared.raster_frame), varyings_(prepared.varyings) {
  // Interpolated values, halves and ones are multiples of 2^-31.
  const number::Grid grid = list_.format.default_grid();
  if (list_.format.kind == number::Kind::Fixed && grid.step <= raster::kAttributeStep)
    greatest_on_grid_ = grid.greatest;
  std::size_t inputs = 0, outputs = 0;
  for (const PixelProgram& program : list_.pixel_programs) {
    counters_.emplace_back(program.executable);
    scratch_.fit(program.executable);
    inputs = std::max(inputs, program.inputs.size());
    outputs = std::max(outputs, program.executable.outputs().size());
  }
  inputs_ = host::AlignedRows(inputs);
  outputs_ = host::AlignedRows(outputs);
  ones_ = host::AlignedRows(1);
  std::fill_n(ones_.row(0), raster::kBatchLanes, 1.0);
}

// Rows of the lanes of `quads`, 0 beyond them. Returns the greatest magnitude in them.
double Shader::fill_inputs(const PixelProgram& program, const DrawState& draw,
                           std::span<const raster::QuadPosition> quads) {
  raster::interpolate_barycentrics(frame_, quads, barycentrics_, triangles_);
  const std::size_t stride = program.varyings.size();
  std::array<raster::AttributeCorners, raster::kBatchQuads> corners;
  for (std::size_t q = 0; q < quads.size(); ++q)
    for (std::size_t k = 0; k < 3; ++k)
      corners[q][k] = &varyings_[draw.first_varying + (triangles_[q].vertex[k] - draw.first_vertex) * stride];
  double bound = raster::interpolate_attributes(barycentrics_, {corners.data(), quads.size()},
                                                program.attributes, inputs_.data());
  if (program.attributes.size() == program.inputs.size()) return bound;
  for (std::size_t row = 0; row < program.inputs.size(); ++row) {
    const InputRow& input = program.inputs[row];
    double* out = inputs_.row(row);
    if (input.kind == InputRow::Kind::Varying) continue;
    std::fill_n(out, raster::kBatchLanes, 0.0);
    for (std::size_t q = 0; q < quads.size(); ++q)
      for (std::size_t l = 0; l < 4; ++l) switch (input.kind) {
          case InputRow::Kind::Varying:
          case InputRow::Kind::Zero:
            break;
          case InputRow::Kind::Face:
            out[4 * q + l] = triangles_[q].front_facing ? 1.0 : -1.0;
            break;
          case InputRow::Kind::PixelX:
            out[4 * q + l] = quads[q].x + static_cast<double>(l & 1) + 0.5;
            break;
          case InputRow::Kind::PixelY:
            out[4 * q + l] = quads[q].y + static_cast<double>(l >> 1) + 0.5;
            break;
          case InputRow::Kind::One:
            out[4 * q + l] = 1.0;
            break;
        }
    for (std::size_t lane = 0; lane < raster::kBatchLanes; ++lane) bound = std::max(bound, std::fabs(out[lane]));
  }
  return bound;
}

vm::Batch Shader::make_batch(const ShadingJob& job) {
  const DrawState& draw = list_.draws[job.draw];
  const PixelProgram& program = list_.pixel_programs[static_cast<std::size_t>(draw.pixel_program)];
  vm::Batch batch;
  batch.input_bound = fill_inputs(program, draw, job.quads);
  batch.inputs_on_grid = batch.input_bound <= greatest_on_grid_;
  batch.inputs = inputs_.data();
  batch.constants = draw.constants.data();
  batch.constant_bound = draw.constant_bound;
  batch.samplers = draw.samplers;
  batch.active = job.quads.size() == raster::kBatchQuads ? ~std::uint64_t{0}
                                                         : (std::uint64_t{1} << 4 * job.quads.size()) - 1;
  batch.covered = job.covered;
  batch.lane_blocks = job.lane_blocks;
  return batch;
}

// output(row): where the program's output row stands.
template <class Output>
void Shader::find_color(const PixelProgram& program, Output output) {
  for (std::size_t target = 0; target < kMaxTargets; ++target)
    for (std::size_t c = 0; c < 4; ++c) {
      const int row = program.color_row[target][c];
      color_[target][c] = row < 0 ? ones_.row(0) : output(static_cast<std::size_t>(row));
    }
}

std::uint64_t Shader::run(const ShadingJob& job) {
  const auto index = static_cast<std::size_t>(list_.draws[job.draw].pixel_program);
  const PixelProgram& program = list_.pixel_programs[index];
  vm::Batch batch = make_batch(job);
  vm::run(program.executable, batch, scratch_, counters_[index]);
  find_color(program, [&](std::size_t row) { return scratch_.rows() + program.executable.output_row(row); });
  return job.covered & ~batch.killed;
}

std::uint64_t Shader::run_traced(const ShadingJob& job, vm::Trace& trace) {
  const auto index = static_cast<std::size_t>(list_.draws[job.draw].pixel_program);
  const PixelProgram& program = list_.pixel_programs[index];
  vm::Batch batch = make_batch(job);
  batch.outputs = outputs_.data();
  vm::run_reference(program.program, program.executable, batch, counters_[index], &trace);
  find_color(program, [&](std::size_t row) { return outputs_.row(row); });
  return job.covered & ~batch.killed;
}

}  // namespace aluminate::passes
