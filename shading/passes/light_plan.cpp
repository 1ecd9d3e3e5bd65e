#include "shading/passes/light_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shading/passes/view_rays.hpp"

namespace aluminate::passes {
namespace {

constexpr std::string_view kLightArrays[4] = {"light_position", "light_color", "light_window", "light_axis"};

bool bounded(const scenes::ShadingLight& light) { return light.position.w != 0.0 && light.inv_range2 > 0.0; }

// Pixels of the rectangle around a sphere's box along the view axes; the whole picture once it touches the
// near plane.
std::uint64_t rectangle_pixels(const scenes::View& view, const glm::dvec3& centre, double radius, int width,
                               int height) {
  const ViewRays rays(view);
  const glm::dvec3 from_eye = centre - view.eye;
  const double ahead = glm::dot(from_eye, rays.forward);
  if (ahead + radius < view.near_plane) return 0;
  const auto whole = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  if (view.perspective && ahead - radius < view.near_plane) return whole;
  std::uint64_t sides[2];
  for (int axis = 0; axis < 2; ++axis) {
    const glm::dvec3& scaled = axis == 0 ? rays.right : rays.up;  // NDC 1 lies at scaled from the middle
    const double length2 = glm::dot(scaled, scaled);
    const double middle = glm::dot(from_eye, scaled) / length2, half = radius / std::sqrt(length2);
    double low = middle - half, high = middle + half;
    if (view.perspective) {
      const double near = ahead - radius, far = ahead + radius;
      low /= low < 0 ? near : far;
      high /= high < 0 ? far : near;
    }
    const int size = axis == 0 ? width : height;
    const double first = std::floor((std::clamp(low, -1.0, 1.0) + 1) * 0.5 * size),
                 last = std::ceil((std::clamp(high, -1.0, 1.0) + 1) * 0.5 * size);
    sides[axis] = static_cast<std::uint64_t>(last - first);
  }
  return sides[0] * sides[1];
}

class Planner {
 public:
  Planner(DrawList& list, const FrameOptions& options) : list_(list), options_(options) {
    group_.orthographic = !list.view.perspective;
    group_.lights.punctual = light_setup(list.lights).punctual;
    // The first lights cast shadows: they stay first on either side.
    for (std::size_t i = 0; i < list.lights.lights.size(); ++i) {
      const scenes::ShadingLight& light = list.lights.lights[i];
      (bounded(light) ? bounded_ : endless_).push_back(light);
      if (i < list.uniforms.shadows.size())
        (bounded(light) ? bounded_shadows_ : endless_shadows_).push_back(list.uniforms.shadows[i]);
    }
  }

  LightPlan make() {
    plan_.first_screen_stamp = stamp_index();
    add_everywhere();
    if (!bounded_.empty()) add_bounded();
    return std::move(plan_);
  }

 private:
  std::uint32_t stamp_index() const {
    return static_cast<std::uint32_t>(list_.draws.size() + list_.screen_draws.size());
  }

  std::vector<double> constants_for(const vm::Program& program,
                                    const std::vector<scenes::ShadingLight>& lights,
                                    const std::vector<ShadowView>& shadows = {}) {
    FrameUniforms uniforms = list_.uniforms;
    uniforms.lights = lights;
    uniforms.shadows = shadows;
    vm::ConstantBank bank = vm::quantise_constants(list_.format, uniform_values(program, uniforms, nullptr));
    list_.sanitised_constants += bank.sanitised;
    return std::move(bank.values);
  }

  PixelProgram program(const LightGroup& group) const {
    PixelProgram light = make_pixel_program(compile_deferred_light(options_, group), list_.format, list_.gpu,
                                            {.filter = cost::FilterAssumption::Targets});
    choose_tier(light.executable, options_.vm);
    return light;
  }

  void add_everywhere() {
    const bool emissive = list_.gbuffer_targets == static_cast<int>(kMaxTargets);
    const bool ambient = emissive || list_.uniforms.has_ambient();
    const std::size_t draws =
        std::max<std::size_t>(ambient, (endless_.size() + kUnrolledLights - 1) / kUnrolledLights);
    for (std::size_t draw = 0; draw < draws; ++draw) {
      const std::size_t first = draw * kUnrolledLights,
                        last = std::min(endless_.size(), first + kUnrolledLights);
      const std::vector<scenes::ShadingLight> lights(endless_.begin() + static_cast<std::ptrdiff_t>(first),
                                                     endless_.begin() + static_cast<std::ptrdiff_t>(last));
      LightGroup group = group_;
      group.lights.count = static_cast<int>(lights.size());
      group.lights.shadows = draw == 0 ? static_cast<int>(endless_shadows_.size()) : 0;  // at most 4 of 8
      group.ambient = draw == 0 && ambient;
      group.emissive = emissive;
      std::string name = group.ambient ? "ambient" : "";
      for (const scenes::ShadingLight& light : lights) name += (name.empty() ? "" : " + ") + light.name;
      list_.screen_draws.push_back(
          {std::move(name), Pass::Sun, static_cast<int>(list_.pixel_programs.size()), draw > 0});
      list_.pixel_programs.push_back(program(group));
      group.accumulate = draw > 0;
      plan_.programs.push_back(group.accumulate ? program(group) : list_.pixel_programs.back());
      plan_.everywhere.push_back({static_cast<int>(plan_.programs.size()) - 1,
                                  constants_for(plan_.programs.back().program, lights,
                                                draw == 0 ? endless_shadows_ : std::vector<ShadowView>{})});
    }
  }

  void add_bounded() {
    LightGroup group = group_;
    group.lights.count = 1;
    const int billed_program = static_cast<int>(list_.pixel_programs.size());
    list_.pixel_programs.push_back(program(group));
    const vm::Program billed = list_.pixel_programs.back().program;
    int casting_program = -1;
    plan_.reach_margin = 0x1p-12 + 4096 * list_.format.default_grid().step;
    for (const scenes::ShadingLight& light : bounded_) {
      BoundedLight bound;
      bound.stamp_draw = stamp_index();
      bound.position = glm::dvec3(light.position);
      bound.inv_range2 = light.inv_range2;
      bound.range = 1 / std::sqrt(light.inv_range2);
      bound.spot_axis = light.spot_axis;
      bound.spot_scale = light.spot_scale;
      bound.spot_offset = light.spot_offset;
      bound.rectangle_pixels =
          rectangle_pixels(list_.view, bound.position, bound.range, options_.width, options_.height);
      int program_index = billed_program;
      if (const std::size_t at = plan_.bounded.size(); at < bounded_shadows_.size()) {
        LightGroup casting = group;
        casting.lights.shadows = 1;
        if (casting_program < 0) {
          casting_program = static_cast<int>(list_.pixel_programs.size());
          list_.pixel_programs.push_back(program(casting));
        }
        program_index = casting_program;
        casting.accumulate = true;
        plan_.programs.push_back(program(casting));
        bound.own_group = static_cast<int>(plan_.own.size());
        plan_.own.push_back({static_cast<int>(plan_.programs.size()) - 1,
                             constants_for(plan_.programs.back().program, {light}, {bounded_shadows_[at]})});
      }
      plan_.bounded.push_back(bound);
      list_.screen_draws.push_back({light.name, Pass::Lights, program_index, true});
      const std::vector<double> values = constants_for(billed, {light});
      std::array<double, 16> rows{};
      for (const vm::UniformSymbol& symbol : billed.uniforms)
        for (std::size_t a = 0; a < 4; ++a)
          if (symbol.name == kLightArrays[a])
            for (int c = 0; c < symbol.components; ++c)
              rows[4 * a + static_cast<std::size_t>(symbol.component + c)] =
                  values[static_cast<std::size_t>(symbol.reg) * 4 +
                         static_cast<std::size_t>(symbol.component + c)];
      plan_.light_rows.push_back(rows);
    }
    group.accumulate = true;
    for (std::size_t i = 0; i < LightPlan::kSizes.size(); ++i) {
      group.lights.count = LightPlan::kSizes[i];
      if (LightPlan::kSizes[i] > static_cast<int>(bounded_.size())) continue;
      plan_.programs.push_back(program(group));
      const std::vector<scenes::ShadingLight> some(bounded_.begin(), bounded_.begin() + group.lights.count);
      plan_.sized[i] = {static_cast<int>(plan_.programs.size()) - 1,
                        constants_for(plan_.programs.back().program, some)};
    }
  }

  DrawList& list_;
  const FrameOptions& options_;
  LightGroup group_;
  std::vector<scenes::ShadingLight> endless_, bounded_;
  std::vector<ShadowView> endless_shadows_, bounded_shadows_;
  LightPlan plan_;
};

}  // namespace

void LightPlan::fill_constants(std::size_t size_index, std::span<const std::uint32_t> lights,
                               std::vector<double>& constants) const {
  const Group& group = sized[size_index];
  constants = group.constants;
  for (const vm::UniformSymbol& symbol : programs[static_cast<std::size_t>(group.program)].program.uniforms)
    for (std::size_t a = 0; a < 4; ++a) {
      if (symbol.name != kLightArrays[a]) continue;
      for (std::size_t i = 0; i < lights.size() && static_cast<int>(i) < symbol.registers; ++i)
        for (int c = 0; c < symbol.components; ++c) {
          const auto component = static_cast<std::size_t>(symbol.component + c);
          constants[(static_cast<std::size_t>(symbol.reg) + i) * 4 + component] =
              light_rows[lights[i]][4 * a + component];
        }
    }
}

LightPlan make_light_plan(DrawList& list, const FrameOptions& options) {
  return list.gbuffer_targets > 0 ? Planner(list, options).make() : LightPlan{};
}

}  // namespace aluminate::passes
