// Where register components live in the scratch rows of a batch.
//   in   live ranges of every component
//   out  a row per used component; components whose ranges do not overlap share one
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shading/vm/liveness.hpp"

namespace aluminate::vm {

inline constexpr std::int32_t kNoRow = -1;

struct RowMap {
  std::vector<std::array<std::int32_t, 4>> temps, outputs;  // row numbers from 0; kNoRow: never used
  int rows = 0;
};

/// Greedy in order of first use. Two components never share a row at an instruction both touch, so an instruction may
/// write its results one by one while its sources are still needed.
RowMap map_rows(const Liveness& liveness);

}  // namespace aluminate::vm
