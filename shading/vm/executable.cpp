#include "shading/vm/executable.hpp"

#include <algorithm>
#include <new>

#include "platform/host/error.hpp"
#include "platform/number/scalar.hpp"
#include "shading/vm/decoded.hpp"
#include "shading/vm/jit/slot.hpp"

namespace aluminate::vm {

Executable::Executable(std::shared_ptr<const Decoded> decoded)
    : decoded_(std::move(decoded)), slot_(std::make_shared<jit::Slot>()) {}

const number::NumberFormat& Executable::format() const { return decoded_->format; }
std::span<const RowBinding> Executable::inputs() const { return decoded_->inputs; }
std::span<const RowBinding> Executable::outputs() const { return decoded_->outputs; }
std::size_t Executable::output_row(std::size_t index) const { return decoded_->output_rows[index]; }
std::size_t Executable::block_count() const { return decoded_->blocks.size(); }
std::size_t Executable::instruction_count() const { return decoded_->instruction_count; }
int Executable::row_count() const { return decoded_->row_count; }
std::size_t Executable::operation_count() const { return decoded_->operations.size(); }

void Scratch::AlignedDelete::operator()(double* rows) const {
  ::operator delete[](rows, std::align_val_t{kRowAlignment});
}

void Scratch::fit(const Executable& executable) {
  const Decoded& d = executable.decoded();
  const auto rows = static_cast<std::size_t>(d.row_count);
  if (rows > row_capacity_) {
    void* memory = ::operator new[](rows * kLanes * sizeof(double), std::align_val_t{kRowAlignment});
    rows_.reset(static_cast<double*>(memory));
    row_capacity_ = rows;
    // Lanes that never run still pass through the kernels: they must hold finite numbers.
    std::fill_n(rows_.get(), rows * kLanes, 0.0);
  }
  const auto levels = static_cast<std::size_t>(std::max(d.level_count, 1));
  if (levels_.size() < levels) levels_.resize(levels);
}

ConstantBank quantise_constants(const number::NumberFormat& format, std::span<const double> values) {
  const number::Grid grid = format.default_grid();
  ConstantBank bank;
  bank.values.reserve(values.size());
  for (double value : values) {
    const number::Ranged r = number::sanitise(grid, value);
    bank.values.push_back(r.value);
    bank.sanitised += r.saturated ? 1 : 0;
  }
  return bank;
}

Counters::Counters(const Executable& executable)
    : blocks(executable.block_count()), saturations(executable.instruction_count(), 0) {}

Counters& Counters::operator+=(const Counters& other) {
  blocks.resize(std::max(blocks.size(), other.blocks.size()));
  saturations.resize(std::max(saturations.size(), other.saturations.size()), 0);
  for (std::size_t b = 0; b < other.blocks.size(); ++b) {
    blocks[b].executions += other.blocks[b].executions;
    blocks[b].covered_lanes += other.blocks[b].covered_lanes;
    blocks[b].helper_lanes += other.blocks[b].helper_lanes;
  }
  for (std::size_t i = 0; i < other.saturations.size(); ++i) saturations[i] += other.saturations[i];
  sanitised_inputs += other.sanitised_inputs;
  fetches += other.fetches;
  fetch_cycles += other.fetch_cycles;
  if (other.overrun_loop >= 0 && (overrun_loop < 0 || other.overrun_loop < overrun_loop)) overrun_loop = other.overrun_loop;
  return *this;
}

void raise_loop_overrun(const Program& program, const Counters& counters) {
  if (counters.overrun_loop < 0) return;
  const SourceLine& line = program.code[static_cast<std::size_t>(counters.overrun_loop)].line;
  throw UserError(SourcePlace{line.file < program.files.size() ? program.files[line.file] : program.name,
                              static_cast<int>(line.line), line.column},
                  fmt::format("loop did not end within {} iterations", kLoopLimit),
                  "check the condition that leaves the loop");
}

}  // namespace aluminate::vm
