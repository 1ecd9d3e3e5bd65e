// The fast interpreter: one indirect call per operation on 64 lanes, structured control flow with lane masks.
#include <algorithm>
#include <bit>
#include <utility>

#include "shading/vm/decoded.hpp"
#include "shading/vm/jit/slot.hpp"
#include "shading/vm/jit/tier.hpp"

namespace aluminate::vm {
namespace {

// Counts a block's lanes; the popcounts are taken again only when the mask has changed.
class LaneCount {
 public:
  LaneCount(std::uint64_t covered, std::uint64_t exec) : covered_mask_(covered) { take(exec); }
  void add(BlockCount& block, std::uint64_t exec) {
    if (exec != exec_) take(exec);
    ++block.executions;
    block.covered_lanes += covered_;
    block.helper_lanes += helpers_;
  }

 private:
  void take(std::uint64_t exec) {
    exec_ = exec;
    covered_ = static_cast<std::uint64_t>(std::popcount(exec & covered_mask_));
    helpers_ = static_cast<std::uint64_t>(std::popcount(exec & ~covered_mask_));
  }
  std::uint64_t covered_mask_, exec_ = 0, covered_ = 0, helpers_ = 0;
};

void count_lanes(std::uint32_t* lanes, std::uint64_t exec) {
  for (; exec != 0; exec &= exec - 1) ++lanes[std::countr_zero(exec)];
}

void execute(const Decoded& d, Batch& batch, Frame& frame, Scratch::Level* levels, Counters& counters) noexcept {
  LaneCount lanes(batch.covered, frame.exec);
  const auto blocks = static_cast<std::uint32_t>(d.blocks.size());
  std::uint32_t b = 0;
  bool run_operations = true;  // false: arriving at the end of block b with no lane left in it
  while (b < blocks) {
    const DecodedBlock& block = d.blocks[b];
    if (run_operations) {
      lanes.add(counters.blocks[b], frame.exec);
      if (batch.lane_blocks != nullptr) count_lanes(batch.lane_blocks + std::size_t{b} * kLanes, frame.exec);
      const Operation* const last = d.operations.data() + block.last;
      for (const Operation* op = d.operations.data() + block.first; op != last; ++op) op->function(*op, frame);
    }

    // Each case leaves the next block in b; lanes_left decides whether that block's operations run.
    Scratch::Level& level = levels[block.level];
    std::uint32_t next = b + 1, when_empty = block.target;
    switch (block.flow) {
      case Flow::None: break;
      case Flow::If:
        level.outer = frame.exec;
        level.waiting = frame.exec & ~frame.condition;
        frame.exec &= frame.condition;
        break;
      case Flow::Else: std::swap(frame.exec, level.waiting); break;
      case Flow::EndIf: frame.exec |= level.waiting; break;
      case Flow::Loop:
        level = {frame.exec, 0, 0};
        frame.iterations[block.loop] = 0;
        frame.loop_values[block.loop] = 0.0;
        if (block.trip_count == 0) next = block.target + 1;
        break;
      case Flow::EndLoop: {
        frame.exec |= level.waiting;
        level.waiting = 0;
        const std::int32_t done = ++level.iteration;
        const std::int32_t limit = block.trip_count < 0 ? kLoopLimit : block.trip_count;
        if (frame.exec != 0 && done < limit) {
          next = block.target;
          frame.iterations[block.loop] = done;
          frame.loop_values[block.loop] = done < d.loop_value_limit ? done : d.loop_value_limit;
        } else {
          if (frame.exec != 0 && block.trip_count < 0) {
            const auto loop = static_cast<std::int32_t>(block.instruction);
            if (counters.overrun_loop < 0 || loop < counters.overrun_loop) counters.overrun_loop = loop;
          }
          frame.exec = level.outer;
        }
        break;
      }
      case Flow::Break: frame.exec &= ~frame.condition; break;
      case Flow::Continue:
        level.waiting |= frame.exec & frame.condition;
        frame.exec &= ~frame.condition;
        break;
    }
    run_operations = frame.exec != 0;
    b = run_operations ? next : when_empty;
  }
}

// False: the interpreter has to.
bool run_compiled(const Executable& executable, const Batch& batch, Frame& frame, Counters& counters) noexcept {
  using jit::Outcome;
  jit::Slot& slot = executable.slot();
  Assume missing = Assume::Typical;
  if (const jit::Native* native = slot.find(Assume::Typical)) {
    const Outcome outcome = jit::run_native(*native, executable.decoded(), batch, frame, counters);
    if (outcome != Outcome::Atypical) return outcome == Outcome::Done;
    missing = Assume::Nothing;
  }
  if (const jit::Native* native = slot.find(Assume::Nothing))
    return jit::run_native(*native, executable.decoded(), batch, frame, counters) == Outcome::Done;
  if (slot.interpreted(missing)) jit::compile_later(executable, missing);
  return false;
}

}  // namespace

void run(const Executable& executable, Batch& batch, Scratch& scratch, Counters& counters) noexcept {
  const Decoded& d = executable.decoded();
  batch.killed = 0;
  if (batch.active == 0) return;

  Frame frame;
  frame.rows = scratch.rows();
  frame.exec = frame.active = batch.active;
  frame.covered = batch.covered & batch.active;
  frame.saturations = counters.saturations.data();
  frame.counters = &counters;
  frame.samplers = batch.samplers.data();
  frame.base[static_cast<int>(Space::Row)] = frame.rows;
  frame.base[static_cast<int>(Space::Uniform)] = batch.constants;
  frame.base[static_cast<int>(Space::Literal)] = d.literals.data();
  frame.base[static_cast<int>(Space::Loop)] = frame.loop_values;
  if (batch.inputs_on_grid) {
    frame.base[static_cast<int>(Space::Input)] = batch.inputs;
  } else {
    double* inputs = frame.rows + static_cast<std::size_t>(d.input_row) * kLanes;
    for (std::size_t i = 0; i < d.inputs.size(); ++i)
      counters.sanitised_inputs += sanitise_row(d.input_grid, batch.inputs + i * kLanes, inputs + i * kLanes,
                                                batch.active, frame.covered);
    frame.base[static_cast<int>(Space::Input)] = inputs;
  }
  const auto clear_rows = [&] {
    for (std::uint32_t row : d.zero_rows) std::fill_n(frame.rows + row, kLanes, 0.0);
  };
  clear_rows();
  if (!run_compiled(executable, batch, frame, counters)) {
    clear_rows();  // given up half way
    execute(d, batch, frame, scratch.levels(), counters);
  }

  batch.killed = frame.killed;
  if (batch.outputs == nullptr) return;
  const std::uint64_t written = batch.active & ~frame.killed;
  for (std::size_t o = 0; o < d.output_rows.size(); ++o)
    copy_row(frame.rows + d.output_rows[o], batch.outputs + o * kLanes, written);
}

}  // namespace aluminate::vm
