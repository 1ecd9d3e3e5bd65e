// `--number auto`: fx31 in which every instruction rounds to the finest grid whose range it provably keeps.
//   in   the program decoded on fx31's grids
//   out  the plan with its final grids, and the program decoded on them
// Nothing is assumed of inputs and uniforms but that the format holds them, and no instruction rounds more coarsely than in
// fx31. An instruction on a finer grid saturates only after another one did: v rsq(dp3(v, v)) counts as bounded, which it is
// unless the dp3 saturated. The proof is a fixed point: ranges depend on grids
// (rsq and log take their smallest operand from them), so grids that the final ranges do not allow are taken back.
#pragma once

#include <functional>

#include "shading/vm/decoded.hpp"
#include "shading/vm/grid_plan.hpp"

namespace aluminate::vm {

Decoded refine_grids(const Program& program, GridPlan& plan, Decoded decoded,
                     const std::function<Decoded(const GridPlan&)>& decode);

}  // namespace aluminate::vm
