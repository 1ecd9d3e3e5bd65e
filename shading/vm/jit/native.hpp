// What compiled code and the machine around it agree on.
//   in   a batch whose inputs are sanitised, and the frame the interpreter's kernels see
//   out  rows, kills and counters with the interpreter's bits
// Compiled code calls back through this frame only: a block of code holds no address and may be stored and moved.
#pragma once

#include <cstdint>
#include <span>

#include "platform/host/machine_code.hpp"
#include "shading/vm/decoded.hpp"

namespace aluminate::vm::jit {

struct NativeFrame {
  Frame frame;
  BlockCount* blocks = nullptr;
  std::uint32_t* lane_blocks = nullptr;  // may be null, as in Batch
  std::uint64_t covered = 0;             // Batch::covered: what block counts are split by
  std::uint64_t lanes = 0;               // lanes to compute from lane 0, a multiple of the code's width
  std::int32_t overrun_loop = -1;
  std::uint64_t gave_up = 0;             // a value left its range: the batch is the interpreter's
  const Operation* operations = nullptr;
  /// One operation by its kernel, on all 64 lanes.
  void (*call)(NativeFrame&, std::uint32_t operation) noexcept = nullptr;
  /// Adds the executing lanes to lane_blocks.
  void (*count_lanes)(NativeFrame&, std::uint32_t block) noexcept = nullptr;
};

using NativeFunction = void (*)(NativeFrame*) noexcept;

/// Code for one decoded program, and what it takes for granted. Immutable, shared between threads.
class Native {
 public:
  struct Description {
    std::uint32_t width = 64;      // lanes of one step: batches are computed in multiples of it
    bool typical_only = false;     // made with Assume::Typical: other batches must go elsewhere
  };
  Native(std::span<const std::uint8_t> code, const Description& description) : code_(code), description_(description) {}

  const Description& description() const { return description_; }
  NativeFunction function() const { return reinterpret_cast<NativeFunction>(const_cast<void*>(code_.entry())); }
  std::size_t bytes() const { return code_.bytes(); }

 private:
  host::MachineCode code_;
  Description description_;
};

enum class Outcome : std::uint8_t {
  Done,
  Atypical,  // not the batch this code was made for; nothing has changed
  GaveUp,    // a value left its range, which the interpreter bounds and counts; nothing but scratch rows has changed
};

/// Runs a prepared frame as the interpreter would.
Outcome run_native(const Native& native, const Decoded& decoded, const Batch& batch, Frame& frame, Counters& counters) noexcept;

}  // namespace aluminate::vm::jit
