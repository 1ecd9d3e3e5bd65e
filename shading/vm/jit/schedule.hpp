// The order in which a stretch of operations is written out. Operations that do not wait for each other, the terms of
// several lights say, are brought together, so that the processor finds independent work next to each other.
//   in   operations [first, last) of a decoded program, straight-line
//   out  the same operations in an order that keeps every value's producer before its readers
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "shading/vm/decoded.hpp"

namespace aluminate::vm::jit {

inline constexpr std::int32_t kFromMemory = -1;  // written before the stretch

struct ScheduledOperation {
  std::uint32_t index = 0;  // into Decoded::operations
  /// Which operation made each row it reads (with masked, also the row it writes): row offset, index or kFromMemory.
  std::vector<std::pair<std::uint32_t, std::int32_t>> rows;
};

struct Stretch {
  std::vector<ScheduledOperation> operations;
  /// Row offset and the operation that wrote it last.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> written;
};

/// window: how far ahead of the oldest waiting operation another may be taken. 1 keeps the order of the program; more
/// overlaps more and keeps more values alive.
Stretch schedule(const Decoded& decoded, std::uint32_t first, std::uint32_t last, std::uint32_t window);

}  // namespace aluminate::vm::jit
