// A program decoded for one number format: immutable, cheap to copy, shared between threads.
//   in   a valid Program (validate) and a NumberFormat
//   out  per-component operations on rows of 64 lanes, grids chosen, registers mapped to rows, dead components dropped
// Counters and saturations still speak of Program::code and find_blocks: decoding changes no count and no bit.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "platform/number/format.hpp"
#include "shading/vm/batch.hpp"
#include "shading/vm/counters.hpp"
#include "shading/vm/program.hpp"

namespace aluminate::vm {

/// Which register component a row of Batch::inputs or Batch::outputs carries.
struct RowBinding {
  std::uint16_t index = 0;     // v# or o#
  std::uint8_t component = 0;  // 0..3
  bool operator==(const RowBinding&) const = default;
};

struct Decoded;  // shading/vm/decoded.hpp: for the interpreter and the JIT
namespace jit {
class Slot;      // shading/vm/jit/slot.hpp
}

class Executable {
 public:
  const number::NumberFormat& format() const;
  /// Exactly the input components the program reads, ascending.
  std::span<const RowBinding> inputs() const;
  /// Exactly the output components the program writes, ascending.
  std::span<const RowBinding> outputs() const;
  /// Where output `index` of the last batch stands in its Scratch::rows(), in doubles.
  std::size_t output_row(std::size_t index) const;
  std::size_t block_count() const;
  std::size_t instruction_count() const;
  /// Rows of scratch a batch needs; 512 bytes each.
  int row_count() const;
  /// Per-component operations on rows, the interpreter's unit of work, and those that implement the instruction set.
  std::size_t operation_count() const;

  const Decoded& decoded() const { return *decoded_; }
  /// Compiled code, once there is some: shared by all copies.
  jit::Slot& slot() const { return *slot_; }

 private:
  friend Executable prepare(const Program&, const number::NumberFormat&);
  explicit Executable(std::shared_ptr<const Decoded> decoded);
  std::shared_ptr<const Decoded> decoded_;
  std::shared_ptr<jit::Slot> slot_;
};

/// Validates and decodes. Throws InternalError for an invalid program.
Executable prepare(const Program& program, const number::NumberFormat& format);

/// Working memory of one worker. Grows in fit(), never in run().
class Scratch {
 public:
  Scratch() = default;
  explicit Scratch(const Executable& executable) { fit(executable); }
  void fit(const Executable& executable);

  struct Level {               // one open If or Loop
    std::uint64_t outer = 0;   // lanes that entered
    std::uint64_t waiting = 0; // If: lanes of the other branch, then lanes that finished the first; Loop: lanes in Continue
    std::int32_t iteration = 0;
  };
  double* rows() { return rows_.get(); }
  Level* levels() { return levels_.data(); }

 private:
  struct AlignedDelete {
    void operator()(double* rows) const;
  };
  std::unique_ptr<double[], AlignedDelete> rows_;
  std::size_t row_capacity_ = 0;
  std::vector<Level> levels_;
};

/// Runs one batch: compiled where jit::select_tier() was asked for and the code is ready, else interpreted. The same bits
/// and counts either way. scratch.fit(executable) and Counters(executable) come first. Allocates nothing.
void run(const Executable& executable, Batch& batch, Scratch& scratch, Counters& counters) noexcept;

}  // namespace aluminate::vm
