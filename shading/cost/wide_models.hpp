// Issue words of the machines aluminate shows for contrast: RSX passes, VLIW5 bundles, scalar-lane
// operations, Utgard words. First-fit over the same block graph the Xenos scheduler gets: simpler than the
// real compilers, and documented as estimates (docs/cost_model.md).
#pragma once

#include "platform/console/gpu_model.hpp"
#include "shading/cost/xenos_graph.hpp"

#include <string>
#include <vector>

namespace aluminate::cost {

struct PlacedOperation {
  int node = -1;
  int word = 0;
  std::string unit;  // "SU0", "SU1"; "xyzw", "t"; "lane"; "vmul", ...
};

struct WideSchedule {
  double words = 0;
  double bound_words = 0;               // lanes over width, and the dependency chain
  std::vector<PlacedOperation> placed;  // by word
};

WideSchedule schedule_wide(const Graph& graph, console::AluModel model);

/// vec4 registers: most components alive at once, through the whole program, over four. Inputs count only on
/// machines that deliver them in registers.
int live_registers(const vm::Program& program, bool inputs_in_registers);

}  // namespace aluminate::cost
