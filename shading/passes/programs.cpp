#include "shading/passes/programs.hpp"

#include <fmt/format.h>

#include "shading/compiler/program_cache.hpp"
#include "shading/programs/shipped.hpp"
#include "shading/vm/jit/tier.hpp"

namespace aluminate::passes {

const MapInfo kMaps[kMapCount] = {
    {"base_color_map", "BASE_COLOR", true, &scenes::Material::base_color_map},
    {"metallic_roughness_map", "METALLIC_ROUGHNESS", false, &scenes::Material::metallic_roughness_map},
    {"specular_glossiness_map", "SPECULAR_GLOSSINESS", true, &scenes::Material::specular_glossiness_map},
    {"normal_map", "NORMAL", false, &scenes::Material::normal_map},
    {"occlusion_map", "OCCLUSION", false, &scenes::Material::occlusion_map},
    {"emissive_map", "EMISSIVE", true, &scenes::Material::emissive_map},
};

bool SurfaceFeatures::has_uv() const {
  for (const bool map : maps)
    if (map) return true;
  return false;
}

std::string SurfaceFeatures::label() const {
  std::string text;
  const auto add = [&text](std::string_view word) { text += (text.empty() ? "" : "+") + std::string(word); };
  for (int i = 0; i < kMapCount; ++i)
    if (maps[i]) add(kMaps[i].sampler.substr(0, kMaps[i].sampler.size() - 4));
  if (vertex_color) add("vertex_color");
  if (specular_glossiness) add("specular_glossiness");
  if (double_sided) add("double_sided");
  if (alpha_mask) add("alpha_mask");
  if (toksvig != ToksvigMode::Off) add("toksvig_" + std::string(to_string(toksvig)));
  if (dxt5nm) add("dxt5nm");
  if (unlit) add("unlit");
  return text.empty() ? "plain" : text;
}

Defines SurfaceFeatures::defines() const {
  Defines d;
  const auto flag = [&d](std::string name, bool on) {
    if (on) d.emplace_back(std::move(name), "1");
  };
  for (int i = 0; i < kMapCount; ++i) {
    flag(fmt::format("HAS_{}_MAP", kMaps[i].define), maps[i]);
    if (maps[i]) d.emplace_back(fmt::format("{}_UV_SET", kMaps[i].define), fmt::format("{}", uv_set[i]));
  }
  if (toksvig != ToksvigMode::Off) d.emplace_back("TOKSVIG", fmt::format("{}", static_cast<int>(toksvig)));
  flag("HAS_UV", has_uv());
  flag("UV_TRANSFORMS", uv_transforms);
  flag("HAS_VERTEX_COLOR", vertex_color);
  flag("DOUBLE_SIDED", double_sided);
  flag("UNLIT", unlit);
  flag("SPECULAR_GLOSSINESS", specular_glossiness);
  flag("ALPHA_MASK", alpha_mask);
  flag("NORMAL_SCALE", normal_scale);
  flag("NORMAL_DXT5NM", dxt5nm);
  return d;
}

SurfaceFeatures features_of(const scenes::Material& material, const scenes::Mesh& mesh, bool permute) {
  SurfaceFeatures f;
  f.unlit = material.unlit;
  f.specular_glossiness = material.workflow == scenes::Workflow::SpecularGlossiness;
  f.alpha_mask = material.alpha_mode == scenes::AlphaMode::Mask;
  f.double_sided = material.double_sided && !material.unlit;
  f.vertex_color = !mesh.colors.empty() || !permute;
  for (int i = 0; i < kMapCount; ++i) {
    const scenes::TextureSlot& slot = material.*kMaps[i].slot;
    const bool other_workflow = i == (f.specular_glossiness ? kMetallicRoughnessMap : kSpecularGlossinessMap);
    const bool unseen = f.unlit && i != kBaseColorMap;
    if (other_workflow || unseen) continue;
    f.maps[i] = slot.present() || (!permute && i != kNormalMap);
    f.uv_set[i] = slot.uv_set;
    f.uv_transforms |= slot.present() && slot.uv_transform != glm::dmat3x2{1, 0, 0, 1, 0, 0};
  }
  f.normal_scale = f.maps[kNormalMap] && material.normal_scale != 1.0;
  return f;
}

void choose_tier(const vm::Executable& executable, VmTier tier) {
  using vm::jit::Tier;
  vm::jit::select_tier(executable, tier == VmTier::Jit    ? Tier::Jit
                                   : tier == VmTier::Auto ? Tier::Auto
                                                          : Tier::Interpreter);
}

bool rolls_lights(const FrameOptions& options, int light_count) {
  return options.light_loop == LightLoop::Rolled ||
         (options.light_loop == LightLoop::Auto && light_count > kUnrolledLights);
}

LightSetup light_setup(const scenes::LightSet& lights) {
  LightSetup setup{static_cast<int>(lights.lights.size()), false, 0};
  for (const scenes::ShadingLight& light : lights.lights)
    setup.punctual |= light.k0 != 1.0 || light.inv_range2 != 0 || light.spot_scale != 0;
  return setup;
}

namespace {

void add_frame_defines(const FrameOptions& options, const LightSetup& lights, bool rolled,
                       compiler::Options& c) {
  c.stage = vm::Stage::Pixel;
  c.defines.emplace_back("VISIBILITY", fmt::format("{}", static_cast<int>(options.visibility)));
  c.defines.emplace_back("FRESNEL", fmt::format("{}", static_cast<int>(options.fresnel)));
  c.defines.emplace_back("LIGHT_COUNT", fmt::format("{}", lights.count));
  c.defines.emplace_back("UNROLL", rolled ? "0" : "1");
  if (lights.punctual) c.defines.emplace_back("PUNCTUAL_LIGHTS", "1");
  if (lights.shadows > 0) c.defines.emplace_back("SHADOW_COUNT", fmt::format("{}", lights.shadows));
  if (options.ambient == AmbientKind::Sky) c.defines.emplace_back("AMBIENT_KIND", "1");
  if (options.ambient == AmbientKind::Hemisphere) c.defines.emplace_back("AMBIENT_KIND", "2");
  if (options.has_reflections()) c.defines.emplace_back("REFLECTIONS", "1");
  c.loops = rolled ? compiler::LoopMode::Rolled : compiler::LoopMode::AsWritten;
}

void add_user_defines(const FrameOptions& options, compiler::Options& c) {
  for (const auto& define : options.defines) {
    std::erase_if(c.defines,
                  [&](const auto& own) { return own.first == define.first; });  // the user's value wins
    c.defines.push_back(define);
  }
}

std::string lights_text(int count) { return fmt::format("{} light{}", count, count == 1 ? "" : "s"); }

}  // namespace

vm::Program compile_pixel(const FrameOptions& options, const SurfaceFeatures& features,
                          const LightSetup& lights, bool rolled) {
  compiler::Options c = options.shader.empty() ? programs::shipped("forward_lit.hlsl") : compiler::Options{};
  if (!options.shader.empty()) {
    c.source_path = options.shader;
    programs::add_shipped_includes(c);
  }
  c.defines = features.defines();
  add_frame_defines(options, lights, rolled, c);
  add_user_defines(options, c);
  vm::Program program = compiler::compile_kept(c);
  program.name = fmt::format("{} [{}] {}", program.name, features.label(), lights_text(lights.count));
  return program;
}

vm::Program compile_gbuffer_fill(const FrameOptions& options, const SurfaceFeatures& features,
                                 bool emissive) {
  compiler::Options c = programs::shipped("gbuffer_fill.hlsl");
  c.stage = vm::Stage::Pixel;
  c.defines = features.defines();
  if (emissive) c.defines.emplace_back("GBUFFER_EMISSIVE", "1");
  add_user_defines(options, c);
  vm::Program program = compiler::compile_kept(c);
  program.name = fmt::format("{} [{}]", program.name, features.label());
  return program;
}

vm::Program compile_shadow_caster(const SurfaceFeatures& features) {
  compiler::Options c = programs::shipped("shadow_caster.hlsl");
  c.stage = vm::Stage::Pixel;
  c.defines = features.defines();
  return compiler::compile_kept(c);
}

vm::Program compile_deferred_light(const FrameOptions& options, const LightGroup& group) {
  compiler::Options c = programs::shipped("deferred_light.hlsl");
  add_frame_defines(options, group.lights, rolls_lights(options, group.lights.count), c);
  if (group.ambient) c.defines.emplace_back("AMBIENT", "1");
  if (group.ambient && group.emissive) c.defines.emplace_back("GBUFFER_EMISSIVE", "1");
  if (group.accumulate) c.defines.emplace_back("ACCUMULATE", "1");
  if (group.orthographic) c.defines.emplace_back("ORTHOGRAPHIC", "1");
  add_user_defines(options, c);
  vm::Program program = compiler::compile_kept(c);
  program.name =
      fmt::format("{} {}{}", program.name, group.ambient ? "ambient, " : "", lights_text(group.lights.count));
  return program;
}

vm::Program compile_vertex(const SurfaceFeatures& features) {
  compiler::Options c = programs::shipped("transform.hlsl");
  c.stage = vm::Stage::Vertex;
  c.defines = features.defines();
  return compiler::compile_kept(c);
}

vm::Program compile_dome(const FrameOptions& options) {
  compiler::Options c = programs::shipped("dome.hlsl");
  if (options.polarizer != glm::dvec3(1.0)) c.defines.emplace_back("POLARIZER", "1");
  add_user_defines(options, c);
  return compiler::compile_kept(c);
}

vm::Program compile_dome_vertex(bool orthographic) {
  compiler::Options c = programs::shipped("dome_vertex.hlsl");
  c.stage = vm::Stage::Vertex;
  if (orthographic) c.defines.emplace_back("ORTHOGRAPHIC", "1");
  return compiler::compile_kept(c);
}

vm::Program compile_tonemap(Tonemap tonemap) {
  compiler::Options c = programs::shipped("tonemap.hlsl");
  c.defines.emplace_back("TONEMAP", fmt::format("{}", static_cast<int>(tonemap)));
  return compiler::compile_kept(c);
}

vm::Program compile_eval_brdf(brdf::Visibility visibility, brdf::Fresnel fresnel) {
  compiler::Options c = programs::shipped("eval_brdf.hlsl");
  c.defines.emplace_back("VISIBILITY", fmt::format("{}", static_cast<int>(visibility)));
  c.defines.emplace_back("FRESNEL", fmt::format("{}", static_cast<int>(fresnel)));
  return compiler::compile_kept(c);
}

}  // namespace aluminate::passes
