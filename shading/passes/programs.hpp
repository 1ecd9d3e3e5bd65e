// Shader permutations: which macros a material asks for, and the compiled, prepared and priced programs
// behind them. A map, a colour or a face flag that a surface lacks is compiled out, so absent features are
// never paid for.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/light_rig.hpp"
#include "scenes/scene.hpp"
#include "shading/passes/options.hpp"
#include "shading/vm/executable.hpp"
#include "shading/vm/program.hpp"

namespace aluminate::passes {

/// The texture slots of the shipped shaders, in the order of `uv_transform` in material.hlsl.
enum MapSlot {
  kBaseColorMap,
  kMetallicRoughnessMap,
  kSpecularGlossinessMap,
  kNormalMap,
  kOcclusionMap,
  kEmissiveMap,
  kMapCount
};

struct MapInfo {
  std::string_view sampler;  // name in the shader
  std::string_view define;   // "BASE_COLOR": HAS_BASE_COLOR_MAP, BASE_COLOR_UV_SET
  bool srgb;
  scenes::TextureSlot scenes::Material::*slot;
};
extern const MapInfo kMaps[kMapCount];

using Defines = std::vector<std::pair<std::string, std::string>>;

/// What the shader has to know about a surface at compile time.
struct SurfaceFeatures {
  bool maps[kMapCount] = {};
  int uv_set[kMapCount] = {};
  bool uv_transforms = false, vertex_color = false, double_sided = false, unlit = false;
  ToksvigMode toksvig = ToksvigMode::Off;  // where there is a normal map
  bool specular_glossiness = false, alpha_mask = false, normal_scale = false;
  bool dxt5nm = false;  // the normal map has x in alpha, y in green and no z

  bool has_uv() const;
  std::string label() const;  // "base_color+normal, double sided"
  Defines defines() const;
};

/// permute = false keeps every map's code whether present or not (`--no-skip permutations`): absent maps then
/// read white.
SurfaceFeatures features_of(const scenes::Material& material, const scenes::Mesh& mesh, bool permute);

struct LightSetup {
  int count = 0;
  bool punctual = false;  // lights of the file: inverse square, range, cone
  int shadows = 0;        // of the first lights
};
LightSetup light_setup(const scenes::LightSet& lights);

/// The pixel shader of a surface: forward_lit.hlsl, or the user's file with the same macros.
/// rolled: keep the light loop a loop.
vm::Program compile_pixel(const FrameOptions& options, const SurfaceFeatures& features,
                          const LightSetup& lights, bool rolled);
/// The material of a lit surface into three targets, or four with what it emits.
vm::Program compile_gbuffer_fill(const FrameOptions& options, const SurfaceFeatures& features, bool emissive);
/// A group of lights over the G-buffer. accumulate: adds to an input instead of starting from black.
struct LightGroup {
  LightSetup lights;
  bool ambient = false, emissive = false, accumulate = false, orthographic = false;
};
vm::Program compile_deferred_light(const FrameOptions& options, const LightGroup& group);
/// Alpha test alone, for a depth pass.
vm::Program compile_shadow_caster(const SurfaceFeatures& features);
vm::Program compile_vertex(const SurfaceFeatures& features);
/// The sky behind everything: pixel and vertex shader of its one triangle.
vm::Program compile_dome(const FrameOptions& options);
vm::Program compile_dome_vertex(bool orthographic);
vm::Program compile_tonemap(Tonemap tonemap);
vm::Program compile_eval_brdf(brdf::Visibility visibility, brdf::Fresnel fresnel);

/// Has the program run the way the tier asks for.
void choose_tier(const vm::Executable& executable, VmTier tier);

/// True when `options` and the light count ask for a rolled loop.
bool rolls_lights(const FrameOptions& options, int light_count);

}  // namespace aluminate::passes
