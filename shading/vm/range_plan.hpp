// What is known about the values of a decoded program before it runs, so that compiled code need not check them.
//   in   operations in their order, and what to assume of inputs and uniforms
//   out  per operation: the interval of its first operand, how far its result reaches, and whether that can leave the
//        range of its grid
// Sound for the lanes that execute: an interval holds every value the interpreter can produce there. Never looks at data.
#pragma once

#include <vector>

#include "shading/vm/decoded.hpp"

namespace aluminate::vm {

struct Interval {
  double least = 0, greatest = 0;
  bool within(double low, double high) const { return least >= low && greatest <= high; }
};

/// What the caller will check for every batch before it runs code made from the plan.
enum class Assume : std::uint8_t {
  Typical,  // |input| <= kTypicalInput and |uniform| <= kTypicalUniform: scenes of radius 1..2, unit vectors, colours
  Nothing,  // anything the number format holds
};
inline constexpr double kTypicalInput = 64, kTypicalUniform = 64;

struct OperationRange {
  Interval operand;       // of src[0], after its modifiers
  Interval result;        // before saturation and clamping
  bool never_minus_zero = false;  // the same
  double reach = 0;       // greatest magnitude of the result before it is bounded, and of the sums it is made of
  bool in_range = false;  // the result never leaves the grid's range: it needs no clamp and counts no saturation
};

struct RangePlan {
  Assume assume = Assume::Nothing;
  std::vector<OperationRange> operations;  // by index into Decoded::operations
};

/// Whether dp3(v, v) may have left its range (and was counted) where v rsq(dp3(v, v)) is bounded. A proof needs MaySaturate;
/// InRange says what holds as long as nothing saturated.
enum class SquaredLength : std::uint8_t { MaySaturate, InRange };

RangePlan plan_ranges(const Decoded& decoded, Assume assume, SquaredLength lengths = SquaredLength::MaySaturate);

}  // namespace aluminate::vm
