// Quads through a pixel program: interpolates its inputs, runs the VM on 64 lanes, gives back colour. One per
// worker.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "platform/host/workers.hpp"
#include "rasterizer/frame.hpp"
#include "rasterizer/interpolate.hpp"
#include "shading/passes/prepared.hpp"
#include "shading/vm/executable.hpp"
#include "shading/vm/reference_interpreter.hpp"

namespace aluminate::passes {

/// Up to 16 quads of one draw. Lane 4 q + l is pixel l of quad q.
struct ShadingJob {
  std::uint32_t draw = 0;
  std::span<const raster::QuadPosition> quads;
  std::uint64_t covered = 0;             // lanes whose colour is wanted
  std::uint32_t* lane_blocks = nullptr;  // [blocks][64], executions are added; may be null
};

class Shader {
 public:
  explicit Shader(const PreparedFrame& prepared);

  /// Runs the job; color() then holds its result. Returns the covered lanes that were not discarded.
  std::uint64_t run(const ShadingJob& job);
  /// The same through the reference interpreter, recording every instruction of one lane. Slow.
  std::uint64_t run_traced(const ShadingJob& job, vm::Trace& trace);
  /// RGBA rows of 64 lanes: linear radiance and alpha, or what a target of the G-buffer receives.
  double color(int channel, int lane, std::size_t target = 0) const {
    return color_[target][static_cast<std::size_t>(channel)][lane];
  }
  /// Red, green and blue of the first target: rows of 64 lanes.
  std::array<const double*, 3> rgb() const { return {color_[0][0], color_[0][1], color_[0][2]}; }
  /// Input rows of the last job, in the order of PixelProgram::inputs: for inspection and tests.
  const double* input_row(std::size_t row) const { return inputs_.row(row); }

  /// Counters by pixel program.
  const std::vector<vm::Counters>& counters() const { return counters_; }

 private:
  vm::Batch make_batch(const ShadingJob& job);
  template <class Output>
  void find_color(const PixelProgram& program, Output output);
  double fill_inputs(const PixelProgram& program, const DrawState& draw,
                     std::span<const raster::QuadPosition> quads);

  const DrawList& list_;
  const raster::Frame& frame_;
  std::span<const double> varyings_;
  double greatest_on_grid_ = -1;  // inputs up to here are the VM's numbers as they are; -1: none is
  std::vector<vm::Counters> counters_;
  vm::Scratch scratch_;
  host::AlignedRows inputs_, outputs_;  // outputs_: of a traced run; others leave theirs in the scratch rows
  host::AlignedRows ones_;              // what is read of a channel the program does not write
  raster::BarycentricRows barycentrics_;
  std::array<raster::TriangleInfo, raster::kBatchQuads> triangles_{};
  std::array<std::array<const double*, 4>, kMaxTargets> color_{};
};

}  // namespace aluminate::passes
