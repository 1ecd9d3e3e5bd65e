#include "shading/passes/light_cost.hpp"

#include "shading/passes/programs.hpp"

namespace aluminate::passes {
namespace {

// A light pass reads the G-buffer and starts anew: only lights of one draw share anything.
LightCosts deferred_costs(const FrameOptions& options, const console::GpuModel& gpu) {
  const auto priced = [&](int lights, bool punctual) {
    LightGroup group;
    group.lights.count = lights;
    group.lights.punctual = punctual;
    return cost::price(compile_deferred_light(options, group), gpu,
                       {.filter = cost::FilterAssumption::Targets});
  };
  const cost::StaticCost volume = priced(1, true);
  LightCosts costs;
  costs.rows.push_back({"volume", "deferred, a volume of its own: G-buffer read again, nothing hoisted",
                        volume.alu_words, volume.alu_slots, volume.fetches});
  cost::LightCost shared = cost::marginal_light(priced(1, false), priced(2, false));
  shared.convention = "deferred, one more in a full-screen draw, hoisted";
  costs.rows.push_back(shared);
  return costs;
}

}  // namespace

LightCosts light_costs(const FrameOptions& options, const console::GpuModel& gpu) {
  if (options.pipeline == Pipeline::Deferred) return deferred_costs(options, gpu);
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
