#include "shading/passes/draw_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "platform/console/platform_file.hpp"
#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"
#include "shading/cost/listing.hpp"
#include "shading/passes/mesh_bounds.hpp"

namespace aluminate::passes {
namespace {

std::uint32_t whole(double cost) { return static_cast<std::uint32_t>(std::ceil(cost)); }

InputRow input_row(const std::string& semantic, int component, std::vector<Varying>& varyings) {
  using Kind = InputRow::Kind;
  if (semantic == "VFACE0") return {Kind::Face, 0};
  if (semantic == "VPOS0")
    return {component == 0   ? Kind::PixelX
            : component == 1 ? Kind::PixelY
            : component == 2 ? Kind::Zero
                             : Kind::One,
            0};
  const Varying wanted{semantic, component};
  const auto found = std::find(varyings.begin(), varyings.end(), wanted);
  const int index = static_cast<int>(found - varyings.begin());
  if (found == varyings.end()) varyings.push_back(wanted);
  return {Kind::Varying, index};
}

}  // namespace

std::string_view to_string(Pass pass) {
  constexpr std::string_view kNames[kPassCount] = {"gbuffer", "sun", "lights", "dome", "forward"};
  return kNames[static_cast<std::size_t>(pass)];
}

PixelProgram make_pixel_program(vm::Program program, const number::NumberFormat& format,
                                const console::GpuModel& gpu, const cost::Assumptions& assumptions) {
  vm::Executable executable = vm::prepare(program, format);
  PixelProgram p{.program = std::move(program),
                 .executable = std::move(executable),
                 .cost = {},
                 .path = {},
                 .varyings = {},
                 .inputs = {},
                 .attributes = {}};
  p.cost = cost::price(p.program, gpu, assumptions);
  p.straight_line = p.program.straight_line();
  p.path = {p.program.name,
            whole(p.cost.alu_words),
            static_cast<std::uint32_t>(p.cost.alu_slots),
            static_cast<std::uint32_t>(p.cost.fetches),
            whole(p.cost.fetch_cyc),
            cost::listing_lines(p.cost)};
  for (const vm::RowBinding& input : p.executable.inputs()) {
    p.inputs.push_back(input_row(p.program.inputs[input.index].semantic, input.component, p.varyings));
    if (p.inputs.back().kind == InputRow::Kind::Varying)
      p.attributes.push_back({static_cast<std::uint32_t>(p.inputs.back().varying),
                              static_cast<std::uint32_t>(p.inputs.size() - 1)});
  }
  for (auto& target : p.color_row) target.fill(-1);
  const auto outputs = p.executable.outputs();
  for (std::size_t row = 0; row < outputs.size(); ++row) {
    const std::string& semantic = p.program.outputs[outputs[row].index].semantic;
    for (std::size_t target = 0; target < kMaxTargets; ++target)
      if (semantic == fmt::format("COLOR{}", target))
        p.color_row[target][outputs[row].component] = static_cast<int>(row);
  }
  if (p.color_row[0][0] < 0)
    throw UserError(fmt::format("{}: the shader writes no COLOR0", p.program.name),
                    "return a float4 from main with the semantic COLOR0");
  return p;
}

namespace {

Surface surface_of(const scenes::Material& material) {
  switch (material.alpha_mode) {
    case scenes::AlphaMode::Mask:
      return Surface::Masked;
    case scenes::AlphaMode::Blend:
      return Surface::Blended;
    default:
      return Surface::Opaque;
  }
}

// Distance along the view of a mesh's middle: blended meshes are drawn from far to near.
double view_depth(const scenes::Mesh& mesh, const DrawList& list) {
  glm::dvec3 low(INFINITY), high(-INFINITY);
  for (const glm::dvec3& p : mesh.positions) {
    if (!std::isfinite(p.x + p.y + p.z)) continue;
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  return low.x <= high.x ? glm::dot(list.view.eye - list.space.point((low + high) * 0.5), list.view.back)
                         : 0.0;
}

// Deferred shading lights opaque surfaces through the G-buffer; what blends or is not lit is drawn on top.
Pass pass_of(const scenes::Material& material, Pipeline pipeline) {
  const bool on_top = material.unlit || surface_of(material) == Surface::Blended;
  return pipeline == Pipeline::Deferred && !on_top ? Pass::Gbuffer : Pass::Forward;
}

// A mesh that stands for the sky, by the name of its material: --sky takes its place.
bool is_painted_sky(const scenes::Material& material) {
  std::string name = material.name;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c); });
  return material.unlit && name == "sky";
}

// Meshes in submission order.
std::vector<std::size_t> submission_order(const scenes::Scene& scene, const DrawList& list,
                                          const FrameOptions& options) {
  struct Key {
    Pass pass;
    Surface surface;
    double minus_depth;  // 0 unless blended: stable file order
    std::size_t mesh;
  };
  std::vector<Key> keys;
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const scenes::Mesh& mesh = scene.meshes[i];
    if (mesh.indices.empty()) continue;
    const scenes::Material& material = scene.materials[static_cast<std::size_t>(mesh.material)];
    const Surface surface = surface_of(material);
    if (options.has_sky() && is_painted_sky(material)) continue;
    keys.push_back({pass_of(material, options.pipeline), surface,
                    surface == Surface::Blended ? -view_depth(mesh, list) : 0.0, i});
  }
  std::stable_sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
    return std::tie(a.pass, a.surface, a.minus_depth) < std::tie(b.pass, b.surface, b.minus_depth);
  });
  std::vector<std::size_t> order;
  for (const Key& key : keys) order.push_back(key.mesh);
  return order;
}

// Programs by permutation, compiled once each.
class Permutations {
 public:
  Permutations(DrawList& list, const FrameOptions& options)
      : list_(list), options_(options), setup_(light_setup(list.lights)) {
    setup_.shadows = static_cast<int>(list.uniforms.shadows.size());
  }

  std::pair<int, int> programs_for(const SurfaceFeatures& features, Pass pass) {
    std::string key(to_string(pass));
    for (const auto& [name, value] : features.defines()) key += " " + name + "=" + value;
    const auto [entry, fresh] = known_.try_emplace(key);
    if (fresh) entry->second = add(compile(features, pass), compile_vertex(features), pass);
    return entry->second;
  }
  std::pair<int, int> dome_programs() {
    return add(compile_dome(options_), compile_dome_vertex(!list_.view.perspective), Pass::Dome);
  }

 private:
  std::pair<int, int> add(vm::Program pixel, vm::Program vertex, Pass pass) {
    list_.pixel_programs.push_back(make_pixel_program(
        std::move(pixel), list_.format, list_.gpu,
        {.filter = cost::FilterAssumption::Trilinear, .anisotropy = options_.anisotropy}));
    const vm::ConstantBank bank =
        vm::quantise_constants(list_.format, uniform_values(vertex, list_.uniforms, nullptr));
    list_.sanitised_constants += bank.sanitised;
    list_.vertex_costs.push_back(cost::price(vertex, list_.gpu));
    list_.vertex_passes.push_back(pass);
    vm::Executable executable = vm::prepare(vertex, list_.format);
    list_.vertex_programs.push_back({std::move(vertex), std::move(executable), bank.values});
    return {static_cast<int>(list_.pixel_programs.size()) - 1,
            static_cast<int>(list_.vertex_programs.size()) - 1};
  }

  vm::Program compile(const SurfaceFeatures& features, Pass pass) const {
    return pass == Pass::Gbuffer
               ? compile_gbuffer_fill(options_, features, list_.gbuffer_targets == kMaxTargets)
               : compile_pixel(options_, features, setup_, rolls_lights(options_, setup_.count));
  }

  DrawList& list_;
  const FrameOptions& options_;
  LightSetup setup_;
  std::map<std::string, std::pair<int, int>> known_;
};

// Covers the picture and hangs over two of its sides.
std::unique_ptr<scenes::Mesh> dome_triangle() {
  auto mesh = std::make_unique<scenes::Mesh>();
  mesh->name = "sky dome";
  mesh->positions.resize(3);
  mesh->uv0 = {{-1, -1}, {3, -1}, {-1, 3}};
  mesh->indices = {0, 1, 2};
  return mesh;
}

// Targets of the G-buffer pass: the fourth holds emitted light and exists only where something glows.
void choose_gbuffer(const scenes::Scene& scene, Pipeline pipeline, DrawList& list) {
  double brightest = 0;
  for (const scenes::Mesh& mesh : scene.meshes) {
    const scenes::Material& material = scene.materials[static_cast<std::size_t>(mesh.material)];
    if (mesh.indices.empty() || pass_of(material, pipeline) != Pass::Gbuffer) continue;
    list.gbuffer_targets = 3;
    for (int c = 0; c < 3; ++c) brightest = std::max(brightest, material.emissive[c]);
  }
  if (!(brightest > 0)) return;
  list.gbuffer_targets = 4;
  list.uniforms.emissive_scale = 1;
  while (list.uniforms.emissive_scale < brightest) list.uniforms.emissive_scale *= 2;
}

// The map behind a sampler name, or null for a name that is not one of ours.
const MapInfo* map_named(const std::string& sampler) {
  for (const MapInfo& map : kMaps)
    if (map.sampler == sampler) return &map;
  return nullptr;
}

TextureUse use_of(const MapInfo& map) {
  return map.srgb ? TextureUse::Color : &map == &kMaps[kNormalMap] ? TextureUse::Normal : TextureUse::Data;
}

void bind_samplers(const DrawList& list, int anisotropy, DrawState& draw) {
  const PixelProgram& program = list.pixel_programs[static_cast<std::size_t>(draw.pixel_program)];
  for (const vm::SamplerSymbol& symbol : program.program.samplers) {
    vm::SamplerBinding binding;
    if (const auto of_frame = frame_sampler(list, symbol.name)) {
      binding = *of_frame;
    } else if (symbol.name == "toksvig_map") {
      binding = {list.toksvig->texture(*draw.material),
                 sampler_state(draw.material->normal_map.sampler, anisotropy)};
    } else if (symbol.name == kMaps[kNormalMap].sampler && list.toksvig->mode() == ToksvigMode::Dxt5) {
      binding = {list.toksvig->texture(*draw.material),
                 sampler_state(draw.material->normal_map.sampler, anisotropy)};
    } else if (const MapInfo* map = map_named(symbol.name)) {
      const scenes::TextureSlot& slot = draw.material->*map->slot;
      binding = {list.textures.find(slot.image, use_of(*map)), sampler_state(slot.sampler, anisotropy)};
    }
    draw.samplers.push_back(binding);
  }
}

FrameUniforms make_uniforms(const FrameOptions& options, const DrawList& list) {
  FrameUniforms uniforms;
  uniforms.view = list.view;
  uniforms.ambient = options.ambient == AmbientKind::Flat ? options.ambient_value : 0.0;
  uniforms.ambient_kind = options.ambient;
  uniforms.polarizer = options.polarizer;
  // Just in front of the cleared depth, as far as the format can tell 1 from less.
  uniforms.dome_depth = 1.0 - std::max(0x1p-23, list.format.default_grid().step);
  return uniforms;
}

}  // namespace

std::optional<vm::SamplerBinding> frame_sampler(const DrawList& list, std::string_view name) {
  if (name == "shadow_map") return vm::SamplerBinding{list.shadow_atlas.get(), kPointSampler};
  if (name == "reflection_map" && list.reflections)
    return vm::SamplerBinding{&list.reflections->texture, vm::SamplerState{}};
  return std::nullopt;
}

DrawList make_draw_list(const scenes::Scene& scene, const FrameOptions& options) {
  DrawList list;
  list.gpu = console::load_platform(options.platform);
  list.format = number::parse_number_format(options.number).value();
  list.space = scenes::normalised_space(scene);
  list.view = scenes::make_view(scene, list.space, scenes::parse_camera(options.camera),
                                static_cast<double>(options.width) / options.height);
  std::optional<SkySetup> sky = make_sky_setup(options);
  const bool only_sky = sky && options.lights.empty() && scene.lights.empty();
  list.lights = scenes::make_lights(scene, list.space, list.view,
                                    scenes::parse_lights(only_sky                 ? "none"
                                                         : options.lights.empty() ? "auto"
                                                                                  : options.lights));
  if (sky) replace_directional_lights(*sky, list.lights);
  list.warnings = list.lights.warnings;

  if (options.pipeline == Pipeline::Deferred && options.msaa > 1)
    throw UserError(fmt::format("--pipeline deferred with --msaa {}: the G-buffer holds one sample a pixel",
                                options.msaa),
                    "four would take six eDRAM parts and their average is no surface (docs/frame.md): use --msaa 1, "
                    "or --pipeline forward");
  if (options.pipeline == Pipeline::Deferred && !options.shader.empty())
    throw UserError("--shader replaces the forward shader, but --pipeline deferred was asked for",
                    "use --pipeline forward with your own shader");
  list.uniforms = make_uniforms(options, list);
  list.toksvig = std::make_unique<ToksvigSet>(scene, options.toksvig);
  list.uniforms.toksvig = list.toksvig.get();
  if (options.shadows) {
    list.shadows = plan_shadows(scene, list.space, list.lights);
    list.uniforms.shadows = list.shadows.views;
    if (!list.shadows.views.empty())
      list.shadow_atlas = std::make_unique<vm::Texture>(
          vm::Texture::render_target(list.shadows.atlas_px, list.shadows.atlas_px));
    list.warnings = list.lights.warnings;
  }
  list.uniforms.lights = list.lights.lights;
  if (options.has_reflections()) {
    list.reflections =
        std::make_unique<Reflections>(load_reflections(options.reflections, sky, options.polarizer));
    list.uniforms.reflection = list.reflections->uniform;
  }
  list.uniforms.sky = std::move(sky);
  choose_gbuffer(scene, options.pipeline, list);
  Permutations permutations(list, options);
  std::vector<DrawState> draws;
  std::vector<raster::Draw> raster_draws;
  const auto add = [&](DrawState draw, bool in_order, bool depth_write) {
    const PixelProgram& program = list.pixel_programs[static_cast<std::size_t>(draw.pixel_program)];
    const vm::ConstantBank bank =
        vm::quantise_constants(list.format, uniform_values(program.program, list.uniforms, draw.material));
    draw.constants = bank.values;
    for (const double value : draw.constants)
      draw.constant_bound = std::max(draw.constant_bound, std::fabs(value));
    list.sanitised_constants += bank.sanitised;
    draw.first_vertex = list.vertex_count;
    draw.first_varying = list.varying_count;
    const bool double_sided = !draw.material || draw.material->double_sided;
    raster_draws.push_back({.first_index = static_cast<std::uint32_t>(list.indices.size()),
                            .triangle_count = static_cast<std::uint32_t>(draw.mesh->indices.size() / 3),
                            .first_vertex = static_cast<std::uint32_t>(draw.first_vertex),
                            .cull = double_sided ? raster::CullMode::None : raster::CullMode::Back,
                            .draw_class = in_order || !program.straight_line ? raster::DrawClass::InOrder
                                                                             : raster::DrawClass::Opaque,
                            .depth_write = depth_write,
                            .execute_billed = !program.straight_line});
    list.indices.insert(list.indices.end(), draw.mesh->indices.begin(), draw.mesh->indices.end());
    list.vertex_count += draw.mesh->positions.size();
    list.varying_count += draw.mesh->positions.size() * program.varyings.size();
    draws.push_back(std::move(draw));
  };
  bool dome_due = options.has_sky() && options.dome;
  const auto add_dome = [&] {
    dome_due = false;
    DrawState draw;
    list.dome = dome_triangle();
    draw.mesh = list.dome.get();
    draw.pass = Pass::Dome;
    std::tie(draw.pixel_program, draw.vertex_program) = permutations.dome_programs();
    add(std::move(draw), true, false);
  };
  for (const std::size_t index : submission_order(scene, list, options)) {
    const scenes::Mesh& mesh = scene.meshes[index];
    DrawState draw;
    draw.mesh = &mesh;
    draw.material = &scene.materials[static_cast<std::size_t>(mesh.material)];
    draw.surface = surface_of(*draw.material);
    draw.pass = pass_of(*draw.material, options.pipeline);
    if (dome_due && draw.surface == Surface::Blended) add_dome();  // behind what blends over it
    SurfaceFeatures features = features_of(*draw.material, mesh, true);
    if (features.maps[kNormalMap]) {
      features.toksvig = options.toksvig;
      features.dxt5nm = options.textures == TextureStorage::Dxt && options.toksvig != ToksvigMode::Dxt5;
    }
    std::tie(draw.pixel_program, draw.vertex_program) = permutations.programs_for(features, draw.pass);
    // What the forward pass draws over a lit G-buffer comes after it, whatever it is.
    const bool on_top = list.gbuffer_targets > 0 && draw.pass == Pass::Forward;
    const Surface surface = draw.surface;
    add(std::move(draw), surface != Surface::Opaque || on_top, surface != Surface::Blended);
  }
  if (dome_due) add_dome();
  // The rasterizer takes its opaque draws first; an opaque surface whose shader branches on data runs in
  // order after them.
  for (const auto draw_class : {raster::DrawClass::Opaque, raster::DrawClass::InOrder}) {
    for (std::size_t i = 0; i < draws.size(); ++i) {
      if (raster_draws[i].draw_class != draw_class) continue;
      list.raster_draws.push_back(raster_draws[i]);
      list.draws.push_back(std::move(draws[i]));
    }
  }

  const bool every_image = options.no_skip.contains("textures");
  for (const DrawState& draw : list.draws)
    for (const vm::SamplerSymbol& symbol :
         list.pixel_programs[static_cast<std::size_t>(draw.pixel_program)].program.samplers)
      if (const MapInfo* map = map_named(symbol.name))
        list.textures.want((draw.material->*map->slot).image, use_of(*map));
  if (every_image)
    for (const scenes::Material& material : scene.materials)
      for (const MapInfo& map : kMaps) list.textures.want((material.*map.slot).image, use_of(map));
  list.textures.decode(scene, options.textures);
  for (DrawState& draw : list.draws) bind_samplers(list, options.anisotropy, draw);
  if (!options.no_skip.contains("mesh_bounds")) mark_draws_outside(list);
  for (const PixelProgram& program : list.pixel_programs) choose_tier(program.executable, options.vm);
  for (const VertexProgram& program : list.vertex_programs) choose_tier(program.executable, options.vm);
  return list;
}

}  // namespace aluminate::passes
