#include "shading/passes/prepared.hpp"

#include "shading/passes/mesh_bounds.hpp"

namespace aluminate::passes {
namespace {

raster::SkipSet skip_set(const FrameOptions& options) {
  raster::SkipSet skips;
  for (std::size_t i = 0; i < raster::kSkipNames.size(); ++i)
    if (options.no_skip.contains(raster::kSkipNames[i])) skips.disable(static_cast<raster::Skip>(i));
  return skips;
}

}  // namespace

void prepare(const scenes::Scene& scene, const FrameOptions& options, PreparedFrame& prepared) {
  prepared.list = make_draw_list(scene, options);
  prepared.light_plan = make_light_plan(prepared.list, options);
}

void draw_shadows(PreparedFrame& prepared, const FrameOptions& options) {
  if (prepared.list.shadow_atlas) prepared.shadows = draw_shadow_maps(options, prepared.list);
}

void shade_all_vertices(PreparedFrame& prepared) {
  const DrawList& list = prepared.list;
  for (std::vector<double>* component : {&prepared.x, &prepared.y, &prepared.z, &prepared.w})
    component->resize(list.vertex_count);
  prepared.varyings.resize(list.varying_count);
  prepared.vertex_counters.clear();
  for (const VertexProgram& program : list.vertex_programs)
    prepared.vertex_counters.emplace_back(program.executable);
  for (std::size_t i = 0; i < list.draws.size(); ++i) {
    const DrawState& draw = list.draws[i];
    const auto program = static_cast<std::size_t>(draw.vertex_program);
    if (list.raster_draws[i].outside) {
      count_unshaded_vertices(draw.mesh->positions.size(), prepared.vertex_counters[program]);
      continue;
    }
    const std::size_t v = draw.first_vertex;
    const VertexTarget target{prepared.x.data() + v, prepared.y.data() + v, prepared.z.data() + v,
                              prepared.w.data() + v, prepared.varyings.data() + draw.first_varying};
    shade_vertices(list.vertex_programs[program], *draw.mesh, list.space,
                   list.pixel_programs[static_cast<std::size_t>(draw.pixel_program)].varyings, target,
                   prepared.vertex_counters[program]);
  }
}

void set_up_triangles(PreparedFrame& prepared, const FrameOptions& options) {
  prepared.raster_frame.set_up({.viewport = {options.width, options.height},
                                .positions = {prepared.x, prepared.y, prepared.z, prepared.w},
                                .indices = prepared.list.indices,
                                .draws = prepared.list.raster_draws,
                                .skips = skip_set(options),
                                .samples = options.msaa},
                               raster::host_threads());
}

raster::TileOptions tile_options(const console::GpuModel& gpu, const FrameOptions& options) {
  // The platform's block counts samples: at four samples a pixel it covers half as many pixels each way.
  const int side = static_cast<int>(gpu.depth.reject_samples.value);
  const bool hierarchical = side > 1;
  return {.bill = {hierarchical ? raster::BillRule::Kind::Hierarchical : raster::BillRule::Kind::PerPixel,
                   hierarchical ? side / (options.msaa == 4 ? 2 : 1) : 4},
          .skips = skip_set(options)};
}

}  // namespace aluminate::passes
