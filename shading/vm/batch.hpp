// One unit of shading work: 64 lanes of one program.
//   lanes  quad-major: lanes 4q .. 4q+3 are pixels (0,0) (1,0) (0,1) (1,1) of quad q; vertices in any order
//   rows   one register component for all lanes: 64 doubles, 512 bytes, 64-byte aligned
// The caller owns every array; a batch holds pointers only. Reads no clock, keeps no state between calls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "platform/number/format.hpp"
#include "shading/vm/texture.hpp"

namespace aluminate::vm {

inline constexpr int kLanes = 64;
inline constexpr std::size_t kRowAlignment = 64;

struct Batch {
  /// Executable::inputs().size() rows in that order; any doubles, sanitised and rounded to the grid on entry. Lanes that
  /// are not active may hold anything.
  const double* inputs = nullptr;
  /// Executable::outputs().size() rows in that order. Written for active lanes that were not discarded; other lanes
  /// keep what they had. Lanes whose path never writes a component receive 0. nullptr: results stay in the scratch rows
  /// (Executable::output_row), where only those lanes have a meaning.
  double* outputs = nullptr;
  /// ConstantBank::values.data(): uniform_count x 4, already on the grid. May be nullptr when the program has none.
  const double* constants = nullptr;
  /// One per Program::samplers.
  std::span<const SamplerBinding> samplers;
  /// Covered and helper lanes. Whole quads wherever the program takes derivatives or samples with implicit detail.
  std::uint64_t active = 0;
  /// Lanes whose result is wanted, a subset of active. Only these are billed.
  std::uint64_t covered = 0;
  /// Input rows are finite and on the format's grid already (all 64 lanes): used in place, not sanitised.
  bool inputs_on_grid = false;
  /// No |input| (with inputs_on_grid) or |constant| is greater; infinity: not known, and looked at.
  double input_bound = std::numeric_limits<double>::infinity();
  double constant_bound = std::numeric_limits<double>::infinity();
  /// Optional [blocks][64]: how often each active lane ran each block is added here. Slower; for pixel inspection.
  std::uint32_t* lane_blocks = nullptr;
  /// Out: active lanes that were discarded.
  std::uint64_t killed = 0;
};

/// Uniform registers on the grid of a format, made once per draw.
struct ConstantBank {
  std::vector<double> values;      // as many as given
  std::uint64_t sanitised = 0;     // values that were NaN, infinite or out of range
};
ConstantBank quantise_constants(const number::NumberFormat& format, std::span<const double> values);

}  // namespace aluminate::vm
