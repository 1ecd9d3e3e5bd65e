#include "shading/passes/uniforms.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <map>
#include <string>

#include "platform/host/error.hpp"
#include "platform/host/suggest.hpp"
#include "shading/passes/programs.hpp"
#include "shading/passes/view_rays.hpp"

namespace aluminate::passes {
namespace {

using Value = std::vector<glm::dvec4>;  // one vec4 per register
using Source = std::function<Value(const FrameUniforms&, const scenes::Material&)>;

const SkySetup& sky_of(const FrameUniforms& frame) {
  static const SkySetup kNone;
  return frame.sky ? *frame.sky : kNone;
}

Value per_light(const FrameUniforms& frame, glm::dvec4 (*of)(const scenes::ShadingLight&)) {
  Value value;
  for (const scenes::ShadingLight& light : frame.lights) value.push_back(of(light));
  return value;
}

// The contract of --shader: every name a shader may declare (docs/shader_contract.md).
const std::map<std::string, Source, std::less<>>& sources() {
  static const std::map<std::string, Source, std::less<>> table = {
      {"world_to_clip",
       [](const FrameUniforms& f, const scenes::Material&) {
         // Column-major registers: what mul(M, v) and M * v read.
         const glm::dmat4 m = f.view.world_to_clip();
         return Value{m[0], m[1], m[2], m[3]};
       }},
      {"eye",
       [](const FrameUniforms& f, const scenes::Material&) {
         return Value{{f.view.eye, 1.0}};
       }},
      {"ambient",
       [](const FrameUniforms& f, const scenes::Material&) { return Value{glm::dvec4(f.ambient)}; }},
      {"sky_sun",
       [](const FrameUniforms& f, const scenes::Material&) { return Value{sky_of(f).sun_direction}; }},
      {"sky_gradation",
       [](const FrameUniforms& f, const scenes::Material&) { return Value{sky_of(f).gradation}; }},
      {"sky_indicatrix",
       [](const FrameUniforms& f, const scenes::Material&) { return Value{sky_of(f).indicatrix}; }},
      {"sky_zenith", [](const FrameUniforms& f, const scenes::Material&) { return Value{sky_of(f).zenith}; }},
      {"sky_horizon",
       [](const FrameUniforms& f, const scenes::Material&) { return Value{sky_of(f).horizon}; }},
      {"night_zenith",
       [](const FrameUniforms& f, const scenes::Material&) { return Value{sky_of(f).night_zenith}; }},
      {"night_horizon",
       [](const FrameUniforms& f, const scenes::Material&) { return Value{sky_of(f).night_horizon}; }},
      {"toksvig",
       [](const FrameUniforms& f, const scenes::Material& m) {
         // Coarser than what libm may differ by.
         const double factor = f.toksvig ? f.toksvig->factor(m) : 1.0;
         return Value{{std::nearbyint(factor * 0x1p24) * 0x1p-24, 0.0, 0.0, 0.0}};
       }},
      {"shadow_matrix",
       [](const FrameUniforms& f, const scenes::Material&) {
         Value rows;
         for (const ShadowView& shadow : f.shadows)
           rows.insert(rows.end(), shadow.rows.begin(), shadow.rows.end());
         return rows;
       }},
      {"shadow_bias",
       [](const FrameUniforms& f, const scenes::Material&) {
         Value biases;
         for (const ShadowView& shadow : f.shadows) biases.push_back(shadow.bias);
         return biases;
       }},
      {"polarizer",
       [](const FrameUniforms& f, const scenes::Material&) {
         return Value{{f.polarizer, 1.0}};
       }},
      {"reflection", [](const FrameUniforms& f, const scenes::Material&) { return Value{f.reflection}; }},
      {"ambient_sh",
       [](const FrameUniforms& f, const scenes::Material&) {
         return Value(sky_of(f).ambient_sh.begin(), sky_of(f).ambient_sh.end());
       }},
      {"ambient_upper",
       [](const FrameUniforms& f, const scenes::Material&) {
         return Value{{sky_of(f).hemisphere.upper, 0.0}};
       }},
      {"ambient_lower",
       [](const FrameUniforms& f, const scenes::Material&) {
         return Value{{sky_of(f).hemisphere.lower, 0.0}};
       }},
      {"dome_depth",
       [](const FrameUniforms& f, const scenes::Material&) {
         return Value{{f.dome_depth, 0.0, 0.0, 0.0}};
       }},
      {"gbuffer_emissive_scale",
       [](const FrameUniforms& f, const scenes::Material&) {
         return Value{{f.emissive_scale, f.emissive_scale > 0 ? 1 / f.emissive_scale : 0.0, 0.0, 0.0}};
       }},
      {"depth_to_distance",
       [](const FrameUniforms& f, const scenes::Material&) {
         return Value{{ViewRays(f.view).depth_to_distance, 0.0}};
       }},
      {"view_forward",
       [](const FrameUniforms& f, const scenes::Material&) {
         return Value{{ViewRays(f.view).forward, 0.0}};
       }},
      {"view_right",
       [](const FrameUniforms& f, const scenes::Material&) {
         return Value{{ViewRays(f.view).right, 0.0}};
       }},
      {"view_up",
       [](const FrameUniforms& f, const scenes::Material&) {
         return Value{{ViewRays(f.view).up, 0.0}};
       }},
      {"view_origin",
       [](const FrameUniforms& f, const scenes::Material&) {
         return Value{{f.view.eye, 1.0}};
       }},
      {"light_position",
       [](const FrameUniforms& f, const scenes::Material&) {
         return per_light(f, [](const scenes::ShadingLight& l) { return l.position; });
       }},
      {"light_color",
       [](const FrameUniforms& f, const scenes::Material&) {
         return per_light(f, [](const scenes::ShadingLight& l) { return glm::dvec4(l.color, l.k1); });
       }},
      {"light_window",
       [](const FrameUniforms& f, const scenes::Material&) {
         return per_light(f, [](const scenes::ShadingLight& l) {
           return glm::dvec4(l.inv_range2, l.k0, l.spot_scale, l.spot_offset);
         });
       }},
      {"light_axis",
       [](const FrameUniforms& f, const scenes::Material&) {
         return per_light(f, [](const scenes::ShadingLight& l) { return glm::dvec4(l.spot_axis, 0.0); });
       }},
      {"base_color_factor",
       [](const FrameUniforms&, const scenes::Material& m) { return Value{m.base_color}; }},
      {"material_factors",
       [](const FrameUniforms&, const scenes::Material& m) {
         return Value{{m.metallic, m.roughness, m.alpha_cutoff, m.occlusion_strength}};
       }},
      {"specular_factor",
       [](const FrameUniforms&, const scenes::Material& m) {
         return Value{{m.specular, m.glossiness}};
       }},
      {"emissive_factor",
       [](const FrameUniforms&, const scenes::Material& m) {
         return Value{{m.emissive, m.normal_scale}};
       }},
      {"uv_transform",
       [](const FrameUniforms&, const scenes::Material& m) {
         Value rows;
         for (const MapInfo& map : kMaps) {
           const glm::dmat3x2& t = (m.*map.slot).uv_transform;
           rows.push_back({t[0].x, t[1].x, t[2].x, 0.0});
           rows.push_back({t[0].y, t[1].y, t[2].y, 0.0});
         }
         return rows;
       }},
  };
  return table;
}

}  // namespace

std::vector<double> uniform_values(const vm::Program& program, const FrameUniforms& frame,
                                   const scenes::Material* material) {
  static const scenes::Material kNoMaterial;
  std::vector<double> values(static_cast<std::size_t>(program.uniform_count) * 4, 0.0);
  for (const vm::UniformSymbol& symbol : program.uniforms) {
    const auto source = sources().find(symbol.name);
    if (source == sources().end()) {
      std::vector<std::string> names;
      for (const auto& [name, unused] : sources()) names.push_back(name);
      throw UserError({program.files.empty() ? program.name : program.files.front(), 0, 0},
                      fmt::format("no value for uniform '{}'", symbol.name),
                      host::did_you_mean(symbol.name, names));
    }
    const Value value = source->second(frame, material ? *material : kNoMaterial);
    for (std::size_t r = 0; r < static_cast<std::size_t>(symbol.registers) && r < value.size(); ++r)
      for (int c = 0; c < symbol.components; ++c)
        values[(static_cast<std::size_t>(symbol.reg) + r) * 4 +
               static_cast<std::size_t>(symbol.component + c)] = value[r][c];
  }
  return values;
}

}  // namespace aluminate::passes
