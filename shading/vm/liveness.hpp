// Which results are ever used, and over which stretch of code each register component holds a value somebody reads.
// Per lane a structured program is an ordinary flow graph, so liveness is the textbook one: lanes that take another
// path keep their own values because every write under a mask is masked.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shading/vm/program.hpp"

namespace aluminate::vm {

/// Instruction indices [first, last] between which a component must keep its row; last < first: never live.
struct LiveRange {
  std::int32_t first = INT32_MAX, last = -1;
  bool used() const { return last >= first; }
};

struct Liveness {
  std::vector<std::uint8_t> live_mask;              // per instruction: components of its write mask that are used
  std::vector<std::array<LiveRange, 4>> temps;
  std::vector<std::array<LiveRange, 4>> outputs;
  std::vector<std::uint8_t> zero_temps;             // per Temp: components that some path reads before writing
  std::vector<std::uint8_t> zero_outputs;
  std::vector<std::uint8_t> quad_temps;             // per Temp: components read across lanes under a mask: never shared
  std::vector<bool> masked;                         // per instruction: may run with fewer lanes than the batch has
};

Liveness find_liveness(const Program& program);

}  // namespace aluminate::vm
