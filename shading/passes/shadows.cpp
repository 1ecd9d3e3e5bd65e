#include "shading/passes/shadows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "platform/host/parallel.hpp"
#include "platform/host/workers.hpp"
#include "shading/passes/gbuffer.hpp"
#include "shading/passes/prepared.hpp"
#include "shading/passes/shade.hpp"

namespace aluminate::passes {
namespace {

struct Box {
  glm::dvec3 low{HUGE_VAL}, high{-HUGE_VAL};
  bool empty() const { return !(low.x <= high.x); }
  glm::dvec3 corner(int i) const {
    return {(i & 1) ? high.x : low.x, (i & 2) ? high.y : low.y, (i & 4) ? high.z : low.z};
  }
};

Box box_of(const scenes::Mesh& mesh, const scenes::NormalisedSpace& space) {
  Box box;
  for (const glm::dvec3& p : mesh.positions) {
    if (!std::isfinite(p.x + p.y + p.z)) continue;
    box.low = glm::min(box.low, space.point(p));
    box.high = glm::max(box.high, space.point(p));
  }
  return box;
}

// right and up of a view that looks along -back.
void orient(scenes::View& view, const glm::dvec3& back) {
  const glm::dvec3 hint = std::fabs(back.y) < 0.99 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  view.back = back;
  view.right = glm::normalize(glm::cross(hint, back));
  view.up = glm::cross(back, view.right);
}

// Around everything lit.
ShadowView directional(const scenes::ShadingLight& light, const std::vector<Box>& boxes, int size) {
  ShadowView shadow;
  orient(shadow.view, glm::dvec3(light.position));
  Box around;  // along right, up, back
  for (const Box& box : boxes)
    for (int i = 0; i < 8; ++i) {
      const glm::dvec3 p = box.corner(i);
      const glm::dvec3 q(glm::dot(p, shadow.view.right), glm::dot(p, shadow.view.up),
                         glm::dot(p, shadow.view.back));
      around.low = glm::min(around.low, q);
      around.high = glm::max(around.high, q);
    }
  const glm::dvec3 middle = (around.low + around.high) * 0.5;
  const glm::dvec3 half = (around.high - around.low) * 0.5 * 1.01 + 1e-3;
  shadow.view.perspective = false;
  shadow.view.half_height = half.y;
  shadow.view.aspect = half.x / half.y;
  shadow.view.near_plane = half.z * 0.1;
  shadow.view.far_plane = half.z * 2.2;
  shadow.view.eye = shadow.view.right * middle.x + shadow.view.up * middle.y +
                    shadow.view.back * (middle.z + half.z * 1.15);
  const double texel = 2 * std::max(half.x, half.y) / size;
  shadow.bias = {1.5 * texel, texel / (shadow.view.far_plane - shadow.view.near_plane), 0, 0};
  return shadow;
}

ShadowView spot(const scenes::ShadingLight& light, double radius, int size) {
  ShadowView shadow;
  orient(shadow.view, light.spot_axis);
  const double cosine = std::clamp(-light.spot_offset / light.spot_scale, 0.05, 0.9999);
  shadow.view.eye = glm::dvec3(light.position);
  shadow.view.tan_half_fovy = 1.01 * std::sqrt(1 - cosine * cosine) / cosine;
  shadow.view.aspect = 1;
  shadow.view.far_plane = light.inv_range2 > 0 ? 1 / std::sqrt(light.inv_range2) : 4 * radius;
  shadow.view.near_plane = 0.01 * shadow.view.far_plane;
  const double texel = 2 * shadow.view.tan_half_fovy * shadow.view.far_plane * 0.5 / size;
  shadow.bias = {1.5 * texel, 0x1p-16, 0, 0};
  return shadow;
}

// NDC of the view to its square of the atlas; v points down.
void make_rows(ShadowView& shadow, int atlas_px) {
  const glm::dmat4 clip = glm::transpose(shadow.view.world_to_clip());  // columns are now rows
  const double scale = 0.5 * shadow.size / atlas_px;
  const double u = (shadow.origin_x + 0.5 * shadow.size) / atlas_px,
               v = (shadow.origin_y + 0.5 * shadow.size) / atlas_px;
  shadow.rows = {clip[0] * scale + clip[3] * u, clip[1] * -scale + clip[3] * v, clip[2], clip[3]};
}

// Everything the caster can darken lies beyond one side of the picture.
bool cannot_matter(const Box& box, const scenes::ShadingLight& light, const scenes::View& camera,
                   double radius) {
  const glm::dmat4 clip = camera.world_to_clip();
  bool beyond[6] = {true, true, true, true, true, true};
  for (int i = 0; i < 16; ++i) {
    glm::dvec3 p = box.corner(i & 7);
    if (i >= 8) {  // as far as a shadow can reach
      const glm::dvec3 away = light.position.w == 0.0 ? -glm::dvec3(light.position)
                                                      : glm::normalize(p - glm::dvec3(light.position));
      p += away * (8 * radius);
    }
    const glm::dvec4 c = clip * glm::dvec4(p, 1.0);
    const double distance[6] = {c.w + c.x, c.w - c.x, c.w + c.y, c.w - c.y, c.z, c.w - c.z};
    for (int plane = 0; plane < 6; ++plane) beyond[plane] &= distance[plane] < -1e-3 * (1 + std::fabs(c.w));
  }
  return std::any_of(std::begin(beyond), std::end(beyond), [](bool b) { return b; });
}

// Draws one map.
class CasterWorker : public raster::QuadShader, public raster::BillSink {
 public:
  CasterWorker(const PreparedFrame& prepared, const FrameOptions& options, const ShadowView& shadow,
               const std::vector<std::uint8_t>& left_out, vm::Texture& atlas, int atlas_px)
      : prepared_(prepared),
        tile_(prepared.raster_frame, tile_options(prepared.list.gpu, options)),
        shader_(prepared),
        shadow_(shadow),
        left_out_(left_out),
        atlas_(atlas),
        atlas_px_(atlas_px) {}

  void run(int tile) {
    tile_.begin(tile);
    tile_.draw_opaque(this);
    tile_.draw_in_order(*this, this);
    const raster::TileView view = tile_.view();
    for (int y = 0; y < view.height; ++y)
      for (int x = 0; x < view.width; ++x)
        atlas_.set_texel(static_cast<std::size_t>(shadow_.origin_y + view.origin.y + y) *
                                 static_cast<std::size_t>(atlas_px_) +
                             static_cast<std::size_t>(shadow_.origin_x + view.origin.x + x),
                         depth24_texel(view.depth[static_cast<std::size_t>(view.element(x, y, 0))]));
  }

  std::uint64_t shade(const raster::QuadBatch& batch) override {
    std::array<raster::QuadPosition, raster::kBatchQuads> quads;
    const auto count = static_cast<std::size_t>(batch.count);
    for (std::size_t q = 0; q < count; ++q) quads[q] = {batch.triangle[q], batch.x[q], batch.y[q]};
    return shader_.run({batch.draw, {quads.data(), count}, batch.visible, nullptr}) & batch.visible;
  }

  // Depth alone runs no pixel shader; cut-out casters run theirs.
  void billed(std::span<const raster::BilledStamp> stamps) override {
    for (const raster::BilledStamp& stamp : stamps) {
      if (left_out_[stamp.draw]) continue;
      const DrawState& draw = prepared_.list.draws[stamp.draw];
      const auto covered = static_cast<std::uint64_t>(std::popcount(stamp.covered));
      totals_.rop_depth_only += covered;
      if (draw.surface == Surface::Opaque) continue;
      const auto lanes = static_cast<std::uint64_t>(std::popcount(raster::shaded_lanes(stamp.covered)));
      const PathInfo& path = prepared_.list.pixel_programs[static_cast<std::size_t>(draw.pixel_program)].path;
      totals_.pixels += covered;
      totals_.quads += lanes / 4;
      totals_.helper_lanes += lanes - covered;
      totals_.alu_words += lanes * path.alu_words;
      totals_.alu_slots += lanes * path.alu_slots;
      totals_.fetches += lanes * path.fetches;
      totals_.fetch_cyc += lanes * path.fetch_cyc;
    }
  }

  const PassTotals& totals() const { return totals_; }

 private:
  const PreparedFrame& prepared_;
  raster::TileRasterizer tile_;
  Shader shader_;
  const ShadowView& shadow_;
  const std::vector<std::uint8_t>& left_out_;  // draws a console is not sent; drawn here only to prove it
  vm::Texture& atlas_;
  int atlas_px_;
  PassTotals totals_;
};

// The draws of a frame that cast, as the light sees them: depth alone, or a program that only cuts out.
DrawList caster_list(const DrawList& main, const scenes::View& view) {
  DrawList list;
  list.gpu = main.gpu;
  list.format = main.format;
  list.space = main.space;
  list.view = list.uniforms.view = view;
  std::map<std::string, int> known;
  for (std::size_t i = 0; i < main.draws.size(); ++i) {
    const DrawState& from = main.draws[i];
    if (!from.material || from.material->unlit || from.surface == Surface::Blended) continue;
    SurfaceFeatures features;
    if (from.surface == Surface::Masked) {
      const SurfaceFeatures all = features_of(*from.material, *from.mesh, true);
      features.maps[kBaseColorMap] = all.maps[kBaseColorMap];
      features.uv_set[kBaseColorMap] = all.uv_set[kBaseColorMap];
      features.uv_transforms = all.uv_transforms;
      features.vertex_color = all.vertex_color;
      features.alpha_mask = true;
    }
    std::string key;
    for (const auto& [name, value] : features.defines()) key += name + "=" + value + " ";
    const auto [entry, fresh] = known.try_emplace(key, static_cast<int>(list.pixel_programs.size()));
    if (fresh) {
      list.pixel_programs.push_back(
          make_pixel_program(compile_shadow_caster(features), list.format, list.gpu));
      vm::Program vertex = compile_vertex(features);
      const vm::ConstantBank bank =
          vm::quantise_constants(list.format, uniform_values(vertex, list.uniforms, nullptr));
      list.vertex_costs.push_back(cost::price(vertex, list.gpu));
      list.vertex_passes.push_back(Pass::Forward);
      vm::Executable executable = vm::prepare(vertex, list.format);
      list.vertex_programs.push_back({std::move(vertex), std::move(executable), bank.values});
    }
    DrawState draw;
    draw.mesh = from.mesh;
    draw.material = from.material;
    draw.surface = from.surface;
    draw.pixel_program = draw.vertex_program = entry->second;
    const PixelProgram& program = list.pixel_programs[static_cast<std::size_t>(entry->second)];
    draw.constants =
        vm::quantise_constants(list.format, uniform_values(program.program, list.uniforms, draw.material))
            .values;
    for (const vm::SamplerSymbol& symbol : program.program.samplers)
      if (symbol.name == kMaps[kBaseColorMap].sampler) {
        const scenes::TextureSlot& slot = draw.material->base_color_map;
        draw.samplers.push_back({main.textures.find(slot.image, TextureUse::Color), sampler_state(slot.sampler)});
      }
    draw.first_vertex = list.vertex_count;
    draw.first_varying = list.varying_count;
    raster::Draw raster_draw = main.raster_draws[i];
    raster_draw.first_index = static_cast<std::uint32_t>(list.indices.size());
    raster_draw.first_vertex = static_cast<std::uint32_t>(draw.first_vertex);
    raster_draw.draw_class =
        from.surface == Surface::Masked ? raster::DrawClass::InOrder : raster::DrawClass::Opaque;
    raster_draw.execute_billed = raster_draw.outside = false;
    list.raster_draws.push_back(raster_draw);
    list.indices.insert(list.indices.end(), draw.mesh->indices.begin(), draw.mesh->indices.end());
    list.vertex_count += draw.mesh->positions.size();
    list.varying_count += draw.mesh->positions.size() * program.varyings.size();
    list.draws.push_back(std::move(draw));
  }
  return list;
}

void add(const PassTotals& from, PassTotals& to) {
  for (const auto member :
       {&PassTotals::pixels, &PassTotals::quads, &PassTotals::helper_lanes, &PassTotals::alu_words,
        &PassTotals::alu_slots, &PassTotals::fetches, &PassTotals::fetch_cyc, &PassTotals::rop_depth_only})
    to.*member += from.*member;
}

// Vertices and triangles of the draws a console would be sent.
void add_geometry(const DrawList& list, const std::vector<std::uint8_t>& left_out, PassTotals& to) {
  for (std::size_t d = 0; d < list.draws.size(); ++d) {
    if (left_out[d]) continue;
    const auto program = static_cast<std::size_t>(list.draws[d].vertex_program);
    const std::uint64_t vertices = list.draws[d].mesh->positions.size();
    to.vertices += vertices;
    to.vertex_words += vertices * static_cast<std::uint64_t>(std::ceil(list.vertex_costs[program].alu_words));
    to.triangles += list.raster_draws[d].triangle_count;
    to.bytes += vertices * 4 * list.vertex_programs[program].executable.inputs().size() +
                std::uint64_t{list.raster_draws[d].triangle_count} * 3 * (list.vertex_count < 65536 ? 2 : 4);
  }
}

}  // namespace

ShadowPlan plan_shadows(const scenes::Scene& scene, const scenes::NormalisedSpace& space,
                        scenes::LightSet& lights) {
  const auto can_cast = [](const scenes::ShadingLight& l) {
    return l.position.w == 0.0 || l.spot_scale != 0.0;
  };
  const auto end = std::stable_partition(lights.lights.begin(), lights.lights.end(), can_cast);
  const auto casting = static_cast<std::size_t>(end - lights.lights.begin());
  if (casting > kMaxShadows)
    lights.warnings.push_back(
        fmt::format("{} lights could cast shadows; the first {} do", casting, kMaxShadows));
  std::vector<Box> boxes;
  for (const scenes::Mesh& mesh : scene.meshes) {
    if (scene.materials[static_cast<std::size_t>(mesh.material)].unlit) continue;
    const Box box = box_of(mesh, space);
    if (!box.empty()) boxes.push_back(box);
  }
  ShadowPlan plan;
  const std::size_t count = boxes.empty() ? 0 : std::min(casting, kMaxShadows);
  if (count == 0) return plan;
  plan.atlas_px = 2 * kShadowMapPx;
  const int size = count == 1 ? plan.atlas_px : kShadowMapPx;
  for (std::size_t i = 0; i < count; ++i) {
    const scenes::ShadingLight& light = lights.lights[i];
    ShadowView shadow =
        light.position.w == 0.0 ? directional(light, boxes, size) : spot(light, space.radius, size);
    shadow.size = size;
    shadow.origin_x = static_cast<int>(i % 2) * size;
    shadow.origin_y = static_cast<int>(i / 2) * size;
    make_rows(shadow, plan.atlas_px);
    plan.views.push_back(shadow);
  }
  return plan;
}

ShadowResult draw_shadow_maps(const FrameOptions& options, const DrawList& main) {
  ShadowResult result;
  result.totals.name = "shadow";
  for (std::size_t i = 0; i < main.shadows.views.size(); ++i) {
    const ShadowView& shadow = main.shadows.views[i];
    FrameOptions map_options = options;
    map_options.width = map_options.height = shadow.size;
    map_options.msaa = 1;
    PreparedFrame map;
    map.list = caster_list(main, shadow.view);
    std::vector<std::uint8_t> left_out(map.list.draws.size());
    for (std::size_t d = 0; d < left_out.size(); ++d) {
      const Box box = box_of(*map.list.draws[d].mesh, main.space);
      left_out[d] = !box.empty() && cannot_matter(box, main.lights.lights[i], main.view, main.space.radius);
      if (!left_out[d] || options.no_skip.contains("shadow_casters")) continue;
      map.list.raster_draws[d].outside = true;
      ++result.skipped_casters;
    }
    shade_all_vertices(map);
    set_up_triangles(map, map_options);
    host::PerWorker<CasterWorker> workers([&] {
      return CasterWorker(map, map_options, shadow, left_out, *main.shadow_atlas, main.shadows.atlas_px);
    });
    host::parallel_for_workers(map.raster_frame.viewport().tile_count(), [&](std::int64_t tile, int worker) {
      workers[worker].run(static_cast<int>(tile));
    });
    workers.for_each([&](const CasterWorker& worker) { add(worker.totals(), result.totals); });
    add_geometry(map.list, left_out, result.totals);
    if (main.gpu.has_edram())
      result.totals.resolve_pixels +=
          static_cast<std::uint64_t>(shadow.size) * static_cast<std::uint64_t>(shadow.size);
  }
  return result;
}

}  // namespace aluminate::passes
