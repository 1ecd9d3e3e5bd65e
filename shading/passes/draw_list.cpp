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

PixelProgram make_pixel_program(vm::Program program, const number::NumberFormat& format,
                                const console::GpuModel& gpu) {
  vm::Executable executable = vm::prepare(program, format);
  PixelProgram p{.program = std::move(program),
                 .executable = std::move(executable),
                 .cost = {},
                 .path = {},
                 .varyings = {},
                 .inputs = {}};
  p.cost = cost::price(p.program, gpu, {.filter = cost::FilterAssumption::Trilinear});
  p.straight_line = p.program.straight_line();
  p.path = {p.program.name, whole(p.cost.alu_words), static_cast<std::uint32_t>(p.cost.alu_slots),
            static_cast<std::uint32_t>(p.cost.fetches), whole(p.cost.fetch_cyc), cost::listing_lines(p.cost)};
  for (const vm::RowBinding& input : p.executable.inputs())
    p.inputs.push_back(input_row(p.program.inputs[input.index].semantic, input.component, p.varyings));
  const auto outputs = p.executable.outputs();
  for (std::size_t row = 0; row < outputs.size(); ++row) {
    const std::string& semantic = p.program.outputs[outputs[row].index].semantic;
    if (semantic == "COLOR0") p.color_row[outputs[row].component] = static_cast<int>(row);
  }
  if (p.color_row[0] < 0)
    throw UserError(fmt::format("{}: the shader writes no COLOR0", p.program.name),
                    "return a float4 from main with the semantic COLOR0");
  return p;
}

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

// Meshes in submission order.
std::vector<std::size_t> submission_order(const scenes::Scene& scene, const DrawList& list) {
  struct Key {
    Surface surface;
    double minus_depth;  // 0 unless blended: stable file order
    std::size_t mesh;
  };
  std::vector<Key> keys;
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const scenes::Mesh& mesh = scene.meshes[i];
    if (mesh.indices.empty()) continue;
    const Surface surface = surface_of(scene.materials[static_cast<std::size_t>(mesh.material)]);
    keys.push_back({surface, surface == Surface::Blended ? -view_depth(mesh, list) : 0.0, i});
  }
  std::stable_sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
    return a.surface != b.surface ? a.surface < b.surface : a.minus_depth < b.minus_depth;
  });
  std::vector<std::size_t> order;
  for (const Key& key : keys) order.push_back(key.mesh);
  return order;
}

// Programs by permutation, compiled once each.
class Permutations {
 public:
  Permutations(DrawList& list, const FrameOptions& options, const FrameUniforms& frame)
      : list_(list), options_(options), frame_(frame) {
    setup_.count = static_cast<int>(list.lights.lights.size());
    for (const scenes::ShadingLight& light : list.lights.lights)
      setup_.punctual |= light.k0 != 1.0 || light.inv_range2 != 0 || light.spot_scale != 0;
  }

  std::pair<int, int> programs_for(const SurfaceFeatures& features) {
    std::string key;
    for (const auto& [name, value] : features.defines()) key += name + "=" + value + ";";
    const auto [entry, fresh] = known_.try_emplace(key);
    if (fresh) {
      const bool rolled = rolls_lights(options_, setup_.count);
      list_.pixel_programs.push_back(
          make_pixel_program(compile_pixel(options_, features, setup_, rolled), list_.format, list_.gpu));
      vm::Program vertex = compile_vertex(features);
      const vm::ConstantBank bank =
          vm::quantise_constants(list_.format, uniform_values(vertex, frame_, nullptr));
      list_.sanitised_constants += bank.sanitised;
      list_.vertex_costs.push_back(cost::price(vertex, list_.gpu));
      vm::Executable executable = vm::prepare(vertex, list_.format);
      list_.vertex_programs.push_back({std::move(vertex), std::move(executable), bank.values});
      entry->second = {static_cast<int>(list_.pixel_programs.size()) - 1,
                       static_cast<int>(list_.vertex_programs.size()) - 1};
    }
    return entry->second;
  }

 private:
  DrawList& list_;
  const FrameOptions& options_;
  const FrameUniforms& frame_;
  LightSetup setup_;
  std::map<std::string, std::pair<int, int>> known_;
};

// The map behind a sampler name, or null for a name that is not one of ours.
const MapInfo* map_named(const std::string& sampler) {
  for (const MapInfo& map : kMaps)
    if (map.sampler == sampler) return &map;
  return nullptr;
}

void bind_samplers(const DrawList& list, DrawState& draw) {
  const PixelProgram& program = list.pixel_programs[static_cast<std::size_t>(draw.pixel_program)];
  for (const vm::SamplerSymbol& symbol : program.program.samplers) {
    vm::SamplerBinding binding;
    if (const MapInfo* map = map_named(symbol.name)) {
      const scenes::TextureSlot& slot = draw.material->*map->slot;
      binding = {list.textures.find(slot.image, map->srgb), sampler_state(slot.sampler)};
    }
    draw.samplers.push_back(binding);
  }
}

}  // namespace

DrawList make_draw_list(const scenes::Scene& scene, const FrameOptions& options) {
  DrawList list;
  list.gpu = console::load_platform(options.platform);
  list.format = number::parse_number_format(options.number).value();
  list.space = scenes::normalised_space(scene);
  list.view = scenes::make_view(scene, list.space, scenes::parse_camera(options.camera),
                                static_cast<double>(options.width) / options.height);
  list.lights = scenes::make_lights(scene, list.space, list.view,
                                    scenes::parse_lights(options.lights.empty() ? "auto" : options.lights));
  list.warnings = list.lights.warnings;

  const FrameUniforms frame{list.view.world_to_clip(), list.view.eye,
                            options.ambient == AmbientKind::Flat ? options.ambient_value : 0.0,
                            list.lights.lights};
  Permutations permutations(list, options, frame);
  std::vector<DrawState> draws;
  std::vector<raster::Draw> raster_draws;
  for (const std::size_t index : submission_order(scene, list)) {
    const scenes::Mesh& mesh = scene.meshes[index];
    DrawState draw;
    draw.mesh = &mesh;
    draw.material = &scene.materials[static_cast<std::size_t>(mesh.material)];
    draw.surface = surface_of(*draw.material);
    std::tie(draw.pixel_program, draw.vertex_program) =
        permutations.programs_for(features_of(*draw.material, mesh, true));
    const PixelProgram& program = list.pixel_programs[static_cast<std::size_t>(draw.pixel_program)];
    const vm::ConstantBank bank =
        vm::quantise_constants(list.format, uniform_values(program.program, frame, draw.material));
    draw.constants = bank.values;
    list.sanitised_constants += bank.sanitised;
    draw.first_vertex = list.vertex_count;
    draw.first_varying = list.varying_count;

    const bool in_order = draw.surface != Surface::Opaque || !program.straight_line;
    raster_draws.push_back(
        {.first_index = static_cast<std::uint32_t>(list.indices.size()),
         .triangle_count = static_cast<std::uint32_t>(mesh.indices.size() / 3),
         .first_vertex = static_cast<std::uint32_t>(draw.first_vertex),
         .cull = draw.material->double_sided ? raster::CullMode::None : raster::CullMode::Back,
         .draw_class = in_order ? raster::DrawClass::InOrder : raster::DrawClass::Opaque,
         .depth_write = draw.surface != Surface::Blended,
         .execute_billed = !program.straight_line});
    list.indices.insert(list.indices.end(), mesh.indices.begin(), mesh.indices.end());
    list.vertex_count += mesh.positions.size();
    list.varying_count += mesh.positions.size() * program.varyings.size();
    draws.push_back(std::move(draw));
  }
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
        list.textures.want((draw.material->*map->slot).image, map->srgb);
  if (every_image)
    for (const scenes::Material& material : scene.materials)
      for (const MapInfo& map : kMaps) list.textures.want((material.*map.slot).image, map.srgb);
  list.textures.decode(scene);
  for (DrawState& draw : list.draws) bind_samplers(list, draw);
  if (!options.no_skip.contains("mesh_bounds")) mark_draws_outside(list);
  return list;
}

}  // namespace aluminate::passes
