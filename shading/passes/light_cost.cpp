#include "shading/passes/light_cost.hpp"

#include "shading/passes/programs.hpp"

namespace aluminate::passes {

LightCosts light_costs(const FrameOptions& options, const console::GpuModel& gpu) {
  LightCosts costs;
  if (!options.shader.empty()) return costs;
  const SurfaceFeatures plain;
  const vm::Program rolled = compile_pixel(options, plain, {.count = 2}, true);
  costs.rows.push_back(cost::loop_body_light(rolled, cost::price(rolled, gpu)));
  const vm::Program one = compile_pixel(options, plain, {.count = 1}, false);
  const vm::Program two = compile_pixel(options, plain, {.count = 2}, false);
  costs.rows.push_back(cost::marginal_light(cost::price(one, gpu), cost::price(two, gpu)));
  return costs;
}

}  // namespace aluminate::passes
