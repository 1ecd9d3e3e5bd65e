// What one more light costs before anything runs, under each convention people quote. The shipped shader on a
// plain surface (no maps), compiled for this purpose: the term under test is the same on every surface.
#pragma once

#include <vector>

#include "platform/console/gpu_model.hpp"
#include "shading/cost/static_cost.hpp"
#include "shading/passes/options.hpp"

namespace aluminate::passes {

struct LightCosts {
  std::vector<cost::LightCost> rows;  // "rolled loop, ps_3_0 slots, nothing hoisted", then "unrolled,
                                      // hoisted"; empty with a user's shader
};

LightCosts light_costs(const FrameOptions& options, const console::GpuModel& gpu);

}  // namespace aluminate::passes
