// Which writes of a register component reach which reads of it. Compilers reuse registers: a component holds a unit
// vector here and a distance there, and what is known of one must not be said of the other.
//   web  the writes that some read cannot tell apart, and all the reads of them (Muchnick, webs of def-use chains)
// Lanes that run a read have run every write before it in the same or an enclosing region of the same iteration, so a
// write there hides earlier ones; where regions join, values of both ways are one web.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shading/vm/program.hpp"

namespace aluminate::vm {

struct ValueWebs {
  using Web = std::uint32_t;
  std::vector<std::array<Web, 4>> written;               // per instruction, by component of a Temp destination
  std::vector<std::array<std::array<Web, 4>, 3>> read;   // per instruction and source, by component of a Temp source
  Web count = 0;
};

/// For a valid program. Components nobody wrote yet are a web of their own: they hold 0.
ValueWebs find_value_webs(const Program& program);

}  // namespace aluminate::vm
