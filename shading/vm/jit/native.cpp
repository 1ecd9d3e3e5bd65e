#include "shading/vm/jit/native.hpp"

#include <bit>

#include "shading/vm/range_plan.hpp"

namespace aluminate::vm::jit {
namespace {

void call_operation(NativeFrame& frame, std::uint32_t index) noexcept {
  const Operation& op = frame.operations[index];
  op.function(op, frame.frame);
}

void count_lanes(NativeFrame& frame, std::uint32_t block) noexcept {
  std::uint32_t* lanes = frame.lane_blocks + std::size_t{block} * kLanes;
  for (std::uint64_t exec = frame.frame.exec; exec != 0; exec &= exec - 1) ++lanes[std::countr_zero(exec)];
}

// What Assume::Typical took for granted. Sanitising moves no value away from 0: a bound given for a batch holds after it.
bool is_typical(const Decoded& d, const Batch& batch, const Frame& frame) {
  return (batch.input_bound <= kTypicalInput ||
          all_within(frame.base[static_cast<int>(Space::Input)], d.inputs.size() * kLanes, kTypicalInput)) &&
         (batch.constant_bound <= kTypicalUniform ||
          all_within(frame.base[static_cast<int>(Space::Uniform)], d.uniform_values, kTypicalUniform));
}

// A straight program costs the same whatever its data: nothing is counted while it runs.
void count_straight(const Decoded& d, const Batch& batch, Counters& counters) {
  const auto covered = static_cast<std::uint64_t>(std::popcount(batch.active & batch.covered));
  const auto helpers = static_cast<std::uint64_t>(std::popcount(batch.active & ~batch.covered));
  for (std::size_t b = 0; b < d.straight_trips.size(); ++b) {
    const std::uint64_t trips = d.straight_trips[b];
    counters.blocks[b].executions += trips;
    counters.blocks[b].covered_lanes += trips * covered;
    counters.blocks[b].helper_lanes += trips * helpers;
    if (batch.lane_blocks == nullptr) continue;
    for (std::uint64_t lanes = batch.active; lanes != 0; lanes &= lanes - 1)
      batch.lane_blocks[b * kLanes + static_cast<std::size_t>(std::countr_zero(lanes))] += static_cast<std::uint32_t>(trips);
  }
}

}  // namespace

Outcome run_native(const Native& native, const Decoded& d, const Batch& batch, Frame& frame, Counters& counters) noexcept {
  if (native.description().typical_only && !is_typical(d, batch, frame)) return Outcome::Atypical;
  NativeFrame n;
  n.frame = frame;
  n.blocks = counters.blocks.data();
  n.lane_blocks = batch.lane_blocks;
  n.covered = batch.covered;
  const std::uint64_t width = native.description().width;
  const auto last = static_cast<std::uint64_t>(std::bit_width(batch.active));
  n.lanes = (last + width - 1) / width * width;
  n.operations = d.operations.data();
  n.call = call_operation;
  n.count_lanes = count_lanes;
  const std::uint64_t fetches = counters.fetches, fetch_cycles = counters.fetch_cycles;
  native.function()(&n);
  if (n.gave_up != 0) {
    counters.fetches = fetches;
    counters.fetch_cycles = fetch_cycles;
    return Outcome::GaveUp;
  }
  frame.killed = n.frame.killed;
  if (n.overrun_loop >= 0 && (counters.overrun_loop < 0 || n.overrun_loop < counters.overrun_loop))
    counters.overrun_loop = n.overrun_loop;
  count_straight(d, batch, counters);
  return Outcome::Done;
}

}  // namespace aluminate::vm::jit
