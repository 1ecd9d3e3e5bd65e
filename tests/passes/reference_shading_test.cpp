// The picture against the double-precision reference: every visible opaque pixel is shaded a second time from
// the same interpolated inputs and texels by shading/brdf in binary64 with libm, and may differ by one 8-bit
// step at most.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "rasterizer/quads.hpp"
#include "scenes/loader.hpp"
#include "shading/brdf/attenuation.hpp"
#include "shading/brdf/material.hpp"
#include "shading/brdf/punctual.hpp"
#include "shading/brdf/srgb.hpp"
#include "shading/passes/prepared.hpp"
#include "shading/passes/shade.hpp"
#include "shading/vm/srgb.hpp"
#include "shading/vm/texture_unit.hpp"
#include "tests/passes/sample_scene.hpp"

namespace aluminate::passes {
namespace {

using Rows = std::map<std::string, const double*>;  // "TEXCOORD0.x"

// RGBA texels of all 64 lanes.
struct Texels {
  alignas(64) std::array<std::array<double, 64>, 4> rows{};
  glm::dvec4 at(int lane) const {
    const auto l = static_cast<std::size_t>(lane);
    return {rows[0][l], rows[1][l], rows[2][l], rows[3][l]};
  }
};

Texels fetch_map(const PreparedFrame& prepared, const DrawState& draw, const MapInfo& map, const Rows& rows) {
  const scenes::TextureSlot& slot = draw.material->*map.slot;
  alignas(64) std::array<double, 64> u, v;
  const double* u_row = rows.at(slot.uv_set ? "TEXCOORD3.z" : "TEXCOORD3.x");
  const double* v_row = rows.at(slot.uv_set ? "TEXCOORD3.w" : "TEXCOORD3.y");
  for (std::size_t l = 0; l < 64; ++l) {
    const glm::dvec2 uv = slot.uv_transform * glm::dvec3(u_row[l], v_row[l], 1.0);
    u[l] = uv.x;
    v[l] = uv.y;
  }
  Texels texels;
  vm::FetchRequest request;
  request.rows = {u.data(), v.data()};
  request.exec = request.covered = ~std::uint64_t{0};
  const TextureUse use = map.srgb                        ? TextureUse::Color
                         : &map == &kMaps[kNormalMap] ? TextureUse::Normal
                                                      : TextureUse::Data;
  vm::fetch_reference(
      {prepared.list.textures.find(slot.image, use), sampler_state(slot.sampler)}, request, false,
      number::parse_number_format("fx31")->unit_grid(),
      {texels.rows[0].data(), texels.rows[1].data(), texels.rows[2].data(), texels.rows[3].data()});
  return texels;
}

class ReferenceShader {
 public:
  ReferenceShader(const PreparedFrame& prepared, const FrameOptions& options)
      : prepared_(prepared), options_(options) {}

  // Linear radiance of the covered lanes of one batch.
  std::array<glm::dvec3, 64> shade(const DrawState& draw, const Rows& rows) const {
    const scenes::Material& material = *draw.material;
    std::array<Texels, kMapCount> texels;
    for (int map = 0; map < kMapCount; ++map)
      if ((material.*kMaps[map].slot).present())
        texels[static_cast<std::size_t>(map)] = fetch_map(prepared_, draw, kMaps[map], rows);
    std::array<glm::dvec3, 64> colors;
    for (int lane = 0; lane < 64; ++lane)
      colors[static_cast<std::size_t>(lane)] = shade_lane(draw, rows, texels, lane);
    return colors;
  }

 private:
  static glm::dvec3 vec3(const Rows& rows, const std::string& semantic, int lane) {
    return {rows.at(semantic + ".x")[lane], rows.at(semantic + ".y")[lane], rows.at(semantic + ".z")[lane]};
  }

  glm::dvec3 shade_lane(const DrawState& draw, const Rows& rows, const std::array<Texels, kMapCount>& texels,
                        int lane) const {
    const scenes::Material& material = *draw.material;
    const auto texel = [&](int map) {
      return (material.*kMaps[map].slot).present() ? texels[static_cast<std::size_t>(map)].at(lane)
                                                   : glm::dvec4(1.0);
    };
    glm::dvec4 base = material.base_color * texel(kBaseColorMap);
    if (rows.contains("COLOR0.x"))
      base *=
          glm::dvec4(vec3(rows, "COLOR0", lane), rows.contains("COLOR0.w") ? rows.at("COLOR0.w")[lane] : 1.0);
    if (material.unlit) return glm::dvec3(base);

    brdf::SurfacePoint surface;
    glm::dvec3 n = vec3(rows, "TEXCOORD1", lane);
    if (material.normal_map.present()) {
      glm::dvec3 t = glm::dvec3(texel(kNormalMap)) * 2.0 - 1.0;
      t.x *= material.normal_scale;
      t.y *= material.normal_scale;
      const glm::dvec3 tangent = vec3(rows, "TEXCOORD2", lane);
      n = tangent * t.x + glm::cross(n, tangent) * rows.at("TEXCOORD2.w")[lane] * t.y + n * t.z;
    }
    surface.normal = glm::normalize(n);
    if (rows.contains("VFACE0.x")) surface.normal *= rows.at("VFACE0.x")[lane];
    const glm::dvec3 position = vec3(rows, "TEXCOORD0", lane);
    surface.to_eye = glm::normalize(prepared_.list.view.eye - position);

    const glm::dvec4 mr = texel(kMetallicRoughnessMap);
    const glm::dvec4 sg = texel(kSpecularGlossinessMap);
    const brdf::Reflectance reflectance =
        material.workflow == scenes::Workflow::SpecularGlossiness
            ? brdf::from_specular_glossiness(glm::dvec3(base), material.specular * glm::dvec3(sg),
                                             material.glossiness * sg.a)
            : brdf::from_metallic_roughness(glm::dvec3(base), material.metallic * mr.b,
                                            material.roughness * mr.g);
    surface.cdiff = reflectance.cdiff;
    surface.cspec = reflectance.cspec;
    surface.m = reflectance.m;
    surface.occlusion = 1.0 + material.occlusion_strength * (texel(kOcclusionMap).r - 1.0);
    surface.emissive = material.emissive * glm::dvec3(texel(kEmissiveMap));

    std::vector<brdf::IncidentLight> lights;
    for (const scenes::ShadingLight& light : prepared_.list.lights.lights) {
      const glm::dvec3 to_light = glm::dvec3(light.position) - position * light.position.w;
      const double d2 = glm::dot(to_light, to_light);
      const glm::dvec3 l = to_light / std::sqrt(d2);
      const double reach = d2 * light.inv_range2;
      const double cone = brdf::clamped(glm::dot(l, light.spot_axis) * light.spot_scale + light.spot_offset);
      const double att = brdf::clamped(1.0 - reach * reach) * cone * cone / (light.k0 + d2 * light.k1);
      lights.push_back({l, light.color * att});
    }
    return brdf::outgoing_radiance(surface, lights, {options_.visibility, options_.fresnel},
                                   glm::dvec3(options_.ambient_value));
  }

  const PreparedFrame& prepared_;
  const FrameOptions& options_;
};

struct Agreement {
  std::uint64_t pixels = 0, off_by_one = 0, worse = 0;
  int worst = 0;
};

Agreement compare_with_reference(const scenes::Scene& scene, const FrameOptions& options) {
  PreparedFrame prepared;
  prepare(scene, options, prepared);
  shade_all_vertices(prepared);
  set_up_triangles(prepared, options);
  raster::TileRasterizer tile(prepared.raster_frame, tile_options(prepared.list.gpu, options));
  Shader shader(prepared);
  const ReferenceShader reference(prepared, options);
  Agreement agreement;
  std::vector<raster::VisibleQuad> visible;
  for (const std::uint32_t index : prepared.raster_frame.tile_order()) {
    tile.begin(static_cast<int>(index));
    tile.draw_opaque(nullptr);
    raster::gather_visible_quads(prepared.raster_frame, tile.view(), visible);
    for (std::size_t first = 0; first < visible.size();) {
      std::vector<raster::QuadPosition> quads;
      std::uint64_t covered = 0;
      const std::uint32_t draw_index = visible[first].draw;
      while (quads.size() < raster::kBatchQuads && first < visible.size() &&
             visible[first].draw == draw_index) {
        covered |= std::uint64_t{visible[first].lanes} << 4 * quads.size();
        quads.push_back({visible[first].triangle, visible[first].x, visible[first].y});
        ++first;
      }
      const DrawState& draw = prepared.list.draws[draw_index];
      const PixelProgram& program =
          prepared.list.pixel_programs[static_cast<std::size_t>(draw.pixel_program)];
      shader.run({draw_index, quads, covered, nullptr});
      Rows rows;
      const auto inputs = program.executable.inputs();
      for (std::size_t row = 0; row < inputs.size(); ++row)
        rows[program.program.inputs[inputs[row].index].semantic + "." + "xyzw"[inputs[row].component]] =
            shader.input_row(row);
      const std::array<glm::dvec3, 64> expected = reference.shade(draw, rows);
      for (int lane = 0; lane < 64; ++lane) {
        if ((covered >> lane & 1) == 0) continue;
        ++agreement.pixels;
        for (int c = 0; c < 3; ++c) {
          const double linear = std::clamp(expected[static_cast<std::size_t>(lane)][c], 0.0, 1.0);
          const int want = brdf::linear_to_srgb8(linear);
          const int got = vm::srgb_encode8(shader.color(c, lane));
          const int step = std::abs(got - want);
          agreement.off_by_one += step == 1;
          agreement.worse += step > 1;
          agreement.worst = std::max(agreement.worst, step);
        }
      }
    }
  }
  return agreement;
}

FrameOptions variant(brdf::Visibility visibility, brdf::Fresnel fresnel, int width, int height) {
  FrameOptions options;
  options.visibility = visibility;
  options.fresnel = fresnel;
  options.width = width;
  options.height = height;
  return options;
}

TEST(ReferenceShading, EveryPixelOfTheSamplesWithinOneStep) {
  for (const char* name : {"material_wall", "grazing_floor", "beach_hut"})
    for (const auto& visibility : brdf::kVisibilityTerms)
      for (const auto& fresnel : brdf::kFresnelTerms) {
        const Agreement agreement =
            compare_with_reference(test::sample_scene(name), variant(visibility.id, fresnel.id, 160, 90));
        EXPECT_GT(agreement.pixels, 1000u) << name;
        EXPECT_EQ(agreement.worse, 0u) << name << " " << visibility.name << " " << fresnel.name << ", worst "
                                       << agreement.worst << " steps";
        // A rounding that lands on the other side is rare: formats err by 1e-6, a step is 1/255.
        EXPECT_LT(static_cast<double>(agreement.off_by_one), 1e-3 * static_cast<double>(agreement.pixels) + 2)
            << name;
      }
}

TEST(ReferenceShading, EveryPixelOfThePublicModelsWithinOneStep) {
  for (const char* file : {"flight_helmet.glb", "pbr_spheres.glb", "exploding_barrel.glb"}) {
    const std::string path = test::public_model(file);
    if (path.empty()) GTEST_SKIP() << "public models are not here";
    FrameOptions options = variant(brdf::Visibility::SchlickSmith, brdf::Fresnel::Schlick, 640, 360);
    options.lights = "rig:4";
    const Agreement agreement = compare_with_reference(scenes::load_scene(path), options);
    EXPECT_GT(agreement.pixels, 10000u) << file;
    EXPECT_EQ(agreement.worse, 0u) << file << ", worst " << agreement.worst << " steps";
  }
}

}  // namespace
}  // namespace aluminate::passes
