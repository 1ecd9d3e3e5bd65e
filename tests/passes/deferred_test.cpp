// Deferred against forward. The bound is derived, pixel by pixel: from what the G-buffer holds, the cell of
// surfaces that would have stored it (half a step of every target each way) is pushed through the shading
// formulas in interval arithmetic, and the forward picture must lie inside. Beside it, the deferred picture
// is the binary64 reference of the stored texels, to the precision of the number format.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "scenes/loader.hpp"
#include "shading/brdf/environment.hpp"
#include "shading/brdf/punctual.hpp"
#include "shading/brdf/srgb.hpp"
#include "shading/passes/tile_worker.hpp"
#include "shading/vm/srgb.hpp"
#include "tests/passes/cube_map_file.hpp"
#include "tests/passes/interval.hpp"
#include "tests/passes/sample_scene.hpp"

namespace aluminate::passes {
namespace {

using test::Interval;
using test::Interval3;

// A deferred frame with its G-buffer kept, and which of its pixels show nothing but the G-buffer's light.
struct Deferred {
  PreparedFrame prepared;
  GBuffer gbuffer;
  Frame frame;
  std::vector<std::uint8_t> lit;
  std::vector<std::uint32_t> depth;  // of the lit surface
};

void draw(const scenes::Scene& scene, const FrameOptions& options, Deferred& d) {
  prepare(scene, options, d.prepared);
  shade_all_vertices(d.prepared);
  set_up_triangles(d.prepared, options);
  d.gbuffer = GBuffer(options.width, options.height, d.prepared.list.gbuffer_targets);
  d.frame = blank_frame(options);
  d.lit.resize(d.frame.pixel_count());
  TileWorker worker(d.prepared, options, d.gbuffer, d.frame);
  for (const std::uint32_t tile : d.prepared.raster_frame.tile_order()) worker.run(static_cast<int>(tile));
  for (std::size_t i = 0; i < d.lit.size(); ++i) {
    const std::uint32_t path = d.frame.cost.path[i];
    if (path == 0) continue;
    for (const DrawState& state : d.prepared.list.draws)
      if (state.pass == Pass::Gbuffer && state.pixel_program + 1 == static_cast<int>(path)) d.lit[i] = 1;
  }
}

// What a texel says, as the cell of values that round to it.
struct Texel {
  std::uint64_t bits;
  double channel(int c) const { return static_cast<double>(bits >> 16 * c & 0xffff) / 65535.0; }
  Interval unorm(int c, int greatest) const {
    const double code = std::round(channel(c) * greatest);
    return test::clamped({(code - 0.5) / greatest, (code + 0.5) / greatest}, 0.0, 1.0);
  }
  // The cell of an sRGB byte, and its middle as decoded.
  Interval srgb(int c) const {
    const double stored = std::round(brdf::linear_to_srgb(channel(c)) * 255.0);
    return {brdf::srgb_to_linear(std::max(0.0, stored - 0.5) / 255.0),
            brdf::srgb_to_linear(std::min(255.0, stored + 0.5) / 255.0)};
  }
  glm::dvec3 rgb() const { return {channel(0), channel(1), channel(2)}; }
  Interval3 srgb3() const { return {srgb(0), srgb(1), srgb(2)}; }
};

struct Pixel {
  Texel diffuse, normal, specular, emissive;
  std::uint32_t depth = 0;
  glm::dvec2 ndc{0};
};

class Shading {
 public:
  Shading(const PreparedFrame& prepared, const FrameOptions& options)
      : list_(prepared.list), rays_(prepared.list.view), options_(options) {}

  glm::dvec3 of_stored(const Pixel& p) const {
    brdf::SurfacePoint s;
    const glm::dvec3 position = rays_.position(p.ndc, rays_.distance(p.depth));
    s.normal = glm::normalize(p.normal.rgb() * 2.0 - 1.0);
    s.to_eye = glm::normalize(list_.view.eye - position);
    s.cdiff = p.diffuse.rgb();
    s.occlusion = p.diffuse.channel(3);
    s.cspec = p.specular.rgb();
    s.m = brdf::power_from_gloss(p.specular.channel(3));
    s.emissive = p.emissive.rgb() * list_.uniforms.emissive_scale;
    std::vector<brdf::IncidentLight> lights;
    for (const scenes::ShadingLight& light : list_.lights.lights) {
      const glm::dvec3 to_light = glm::dvec3(light.position) - position * light.position.w;
      const double d2 = glm::dot(to_light, to_light);
      const glm::dvec3 l = to_light / std::sqrt(d2);
      const double reach = d2 * light.inv_range2;
      const double cone = brdf::clamped(glm::dot(l, light.spot_axis) * light.spot_scale + light.spot_offset);
      lights.push_back(
          {l, light.color * (brdf::clamped(1 - reach * reach) * cone * cone / (light.k0 + d2 * light.k1))});
    }
    glm::dvec3 radiance = brdf::outgoing_radiance(s, lights, {options_.visibility, options_.fresnel},
                                                  glm::dvec3(options_.ambient_value));
    if (!options_.has_reflections()) return radiance;
    const double gloss = p.specular.channel(3), n_dot_v = brdf::clamped(glm::dot(s.normal, s.to_eye));
    for (int c = 0; c < 3; ++c)
      radiance[c] += s.occlusion * (kSurroundings * brdf::environment_reflectance(gloss, n_dot_v, s.cspec[c]) -
                                    options_.ambient_value * s.cspec[c]);
    return radiance;
  }

  // Everything a surface may radiate that stores this pixel.
  Interval3 of_cell(const Pixel& p) const {
    // D24 rounds to nearest from vertex depths with 4 more bits and lanes with 7: 1/2 + 2 (1/32) + 1/256 of a
    // step.
    constexpr double kDepthStep = 0.5 + 2.0 / 32 + 1.0 / 256;
    const Interval distance{exact_distance(p.depth - kDepthStep), exact_distance(p.depth + kDepthStep)};
    Interval3 position;
    const glm::dvec3 a = rays_.position(p.ndc, distance.low), b = rays_.position(p.ndc, distance.high);
    for (int c = 0; c < 3; ++c)
      position.at[static_cast<std::size_t>(c)] = {std::min(a[c], b[c]) - kGrid, std::max(a[c], b[c]) + kGrid};
    const Interval3 v(glm::normalize(list_.view.eye - a));
    Interval3 n;
    for (std::size_t c = 0; c < 3; ++c) {
      const Interval cell = p.normal.unorm(static_cast<int>(c), 1023);
      n.at[c] = {cell.low * 2 - 1 - kGrid, cell.high * 2 - 1 + kGrid};
    }
    const Interval gloss = p.specular.unorm(3, 255);
    const Interval m{brdf::power_from_gloss(gloss.low), brdf::power_from_gloss(gloss.high)};
    const Interval3 cdiff = p.diffuse.srgb3(), cspec = p.specular.srgb3(), emissive = p.emissive.srgb3();
    const Interval occlusion = p.diffuse.unorm(3, 255), n_dot_v = test::clamped(dot(n, v), 0, 1);
    Interval3 sum;
    for (std::size_t c = 0; c < 3; ++c)
      sum.at[c] =
          (list_.uniforms.emissive_scale > 0 ? emissive.at[c] * list_.uniforms.emissive_scale : Interval()) +
          occlusion * (options_.has_reflections()
                           ? options_.ambient_value * cdiff.at[c] + surroundings(gloss, n_dot_v, cspec.at[c])
                           : options_.ambient_value * (cdiff.at[c] + cspec.at[c]));
    for (const scenes::ShadingLight& light : list_.lights.lights) {
      Interval3 to_light;
      for (int c = 0; c < 3; ++c)
        to_light.at[static_cast<std::size_t>(c)] =
            Interval(light.position[c]) - position.at[static_cast<std::size_t>(c)] * light.position.w;
      const Interval d2 = length_squared(to_light);
      const Interval3 l = over(to_light, root(d2));
      const Interval reach = d2 * light.inv_range2;
      const Interval cone =
          test::clamped(dot(l, light.spot_axis) * light.spot_scale + light.spot_offset, 0, 1);
      const Interval attenuation = test::clamped(Interval(1) - square(reach), 0, 1) * square(cone) /
                                   (Interval(light.k0) + d2 * light.k1);
      const Interval3 both{l.at[0] + v.at[0], l.at[1] + v.at[1], l.at[2] + v.at[2]};
      const Interval3 h = over(both, root(length_squared(both)));
      const Interval lobe =
          specular_lobe(m, test::clamped(dot(n, l), 0, 1), n_dot_v, test::clamped(dot(n, h), 0, 1));
      const Interval h_dot_v = test::clamped(dot(h, v), 0, 1);
      const auto weight = brdf::term(options_.fresnel).weight;
      const Interval w{weight(h_dot_v.high), weight(h_dot_v.low)};  // falls with h.v
      for (std::size_t c = 0; c < 3; ++c) {
        // cspec + (1 - cspec) w rises with both.
        const Interval& s = cspec.at[c];
        const Interval fresnel{s.low + (1 - s.low) * w.low, s.high + (1 - s.high) * w.high};
        sum.at[c] = sum.at[c] + Interval(light.color[static_cast<int>(c)]) * attenuation *
                                    test::clamped(dot(n, l), 0, 1) * (cdiff.at[c] + fresnel * lobe);
      }
    }
    return sum;
  }

  /// Light from every direction, of the reflections these tests draw with.
  static constexpr double kSurroundings = 0.5;

 private:
  // Rises with gloss and cspec, falls with n.v.
  static Interval surroundings(Interval gloss, Interval n_dot_v, Interval cspec) {
    return Interval{brdf::environment_reflectance(gloss.low, n_dot_v.high, cspec.low),
                    brdf::environment_reflectance(gloss.high, n_dot_v.low, cspec.high)} *
           kSurroundings;
  }

  static constexpr double kGrid =
      1e-7;  // forward's interpolated position and normal lie on the format's grid

  double exact_distance(double depth) const {
    const double z = depth / raster::kDepthMax;
    return rays_.depth_to_distance.z / (rays_.depth_to_distance.x - z * rays_.depth_to_distance.y);
  }

  // V norm (n.h)^m: V falls with both cosines, norm rises with m, the lobe rises with n.h and falls with m.
  Interval specular_lobe(Interval m, Interval n_dot_l, Interval n_dot_v, Interval n_dot_h) const {
    const brdf::VisibilityTerm& t = brdf::term(options_.visibility);
    const Interval visibility = t.constant ? Interval(t.visibility(m.low, 1, 1), t.visibility(m.high, 1, 1))
                                           : Interval(t.visibility(m.low, n_dot_l.high, n_dot_v.high),
                                                      t.visibility(m.high, n_dot_l.low, n_dot_v.low));
    const Interval lobe{std::pow(n_dot_h.low, m.high), std::pow(n_dot_h.high, m.low)};
    return visibility * lobe * Interval(t.norm(m.low), t.norm(m.high));
  }

  const DrawList& list_;
  ViewRays rays_;
  const FrameOptions& options_;
};

struct Tally {
  std::uint64_t pixels = 0, outside = 0, off_reference = 0, tight = 0;
  double worst_outside = 0, worst_reference = 0;
};

Tally compare(const scenes::Scene& scene, FrameOptions options) {
  options.pipeline = Pipeline::Forward;
  const Frame forward = render_frame(scene, options);
  options.pipeline = Pipeline::Deferred;
  Deferred d;
  draw(scene, options, d);
  const Shading shading(d.prepared, options);
  Tally tally;
  for (std::size_t i = 0; i < d.lit.size(); ++i) {
    if (!d.lit[i]) continue;
    EXPECT_EQ(forward.depth_d24[i], d.frame.depth_d24[i]);
    const auto texel = [&](std::size_t target) {
      Texel found{0};
      if (d.gbuffer.targets() > static_cast<int>(target))
        for (std::size_t c = 0; c < 4; ++c)
          found.bits |= std::uint64_t{d.gbuffer.color(target).linear16(0, i, c)} << 16 * c;
      return found;
    };
    const int x = static_cast<int>(i) % options.width, y = static_cast<int>(i) / options.width;
    const Pixel pixel{texel(0),
                      texel(1),
                      texel(2),
                      texel(3),
                      d.frame.depth_d24[i],
                      {pixel_ndc(x, options.width), -pixel_ndc(y, options.height)}};
    const glm::dvec3 reference = shading.of_stored(pixel);
    const Interval3 cell = shading.of_cell(pixel);
    ++tally.pixels;
    for (std::size_t c = 0; c < 3; ++c) {
      const double got = d.frame.linear[4 * i + c], want = reference[static_cast<int>(c)];
      // What the format itself may err: 2e-5 of the specular term (docs/accuracy.md), 1e-6 where all is
      // small.
      const double slack = 4e-5 * std::max(want, cell.at[c].high) + 1e-6;
      const double off = std::abs(got - want) - (4e-5 * want + 1e-6);
      tally.off_reference += off > 0;
      tally.worst_reference = std::max(tally.worst_reference, off);
      const double f = forward.linear[4 * i + c];
      const double beyond = std::max(cell.at[c].low - f, f - cell.at[c].high) - slack;
      tally.outside += beyond > 0;
      tally.worst_outside = std::max(tally.worst_outside, beyond);
      tally.tight += cell.at[c].width() < 0.1;
    }
  }
  return tally;
}

TEST(Deferred, ForwardLiesInTheCellOfWhatWasStored) {
  for (const char* name :
       {"material_wall", "beach_hut", "grazing_floor", "overdraw_stress"})  // "triangle" is not lit
    for (const brdf::VisibilityTerm& visibility : brdf::kVisibilityTerms) {
      // The terms differ in nothing but the lobe: one scene with every gloss judges them all.
      if (visibility.id != brdf::Visibility::SchlickSmith && std::string(name) != "material_wall") continue;
      FrameOptions options;
      options.width = 160;
      options.height = 90;
      options.visibility = visibility.id;
      const Tally tally = compare(test::sample_scene(name), options);
      EXPECT_GT(tally.pixels, 500u) << name;
      EXPECT_EQ(tally.outside, 0u) << name << " " << visibility.name << ", by " << tally.worst_outside;
      EXPECT_EQ(tally.off_reference, 0u)
          << name << " " << visibility.name << ", by " << tally.worst_reference;
      // The bound says something: most channels may move by less than 0.1 at all.
      EXPECT_GT(tally.tight, tally.pixels * 3 / 2) << name << " " << visibility.name;
    }
}

TEST(Deferred, ForwardLiesInTheCellOnPublicModels) {
  int seen = 0;
  for (const char* file : {"atrium.glb", "carbon_sphere.glb", "exploding_barrel.glb", "flight_helmet.glb",
                           "hotel_room.glb", "pbr_spheres.glb"}) {
    const std::string path = test::public_model(file);
    if (path.empty()) continue;
    ++seen;
    FrameOptions options;
    options.width = 128;
    options.height = 72;
    set_options(options, "lights=rig:4");
    const Tally tally = compare(scenes::load_scene(path), options);
    EXPECT_GT(tally.pixels, 500u) << file;
    EXPECT_EQ(tally.outside, 0u) << file << ", by " << tally.worst_outside;
    EXPECT_EQ(tally.off_reference, 0u) << file << ", by " << tally.worst_reference;
  }
  if (seen == 0) GTEST_SKIP() << "no public models beside the project";
}

TEST(Deferred, ForwardLiesInTheCellWithReflectionsToo) {
  // Surroundings of one colour: what a lookup gives does not depend on the direction, only the reflectance does.
  CubeMap map;
  map.seen = {16, std::vector<glm::dvec4>(6 * 16 * 16, glm::dvec4(glm::dvec3(Shading::kSurroundings), 0))};
  map.surface.assign(6 * 16 * 16, glm::dvec3(Shading::kSurroundings));
  FrameOptions options;
  options.width = 160;
  options.height = 90;
  const test::CubeMapFile file(map);
  options.reflections = file.path();
  for (const char* name : {"material_wall", "beach_hut"}) {
    const Tally tally = compare(test::sample_scene(name), options);
    EXPECT_GT(tally.pixels, 500u) << name;
    EXPECT_EQ(tally.outside, 0u) << name << ", by " << tally.worst_outside;
    EXPECT_EQ(tally.off_reference, 0u) << name << ", by " << tally.worst_reference;
  }
}

TEST(Deferred, WhatIsDrawnOnTopIsTheForwardDraw) {
  for (const char* name : {"beach_hut", "overdraw_stress"}) {
    FrameOptions options;
    options.width = 160;
    options.height = 90;
    const scenes::Scene& scene = test::sample_scene(name);
    PreparedFrame forward, deferred;
    prepare(scene, options, forward);
    const Frame a = render_frame(scene, options);
    options.pipeline = Pipeline::Deferred;
    prepare(scene, options, deferred);
    const Frame b = render_frame(scene, options);
    int on_top = 0;
    for (const DrawState& draw : deferred.list.draws) {
      if (draw.pass != Pass::Forward) continue;
      ++on_top;
      for (const DrawState& other : forward.list.draws) {
        if (other.mesh != draw.mesh) continue;
        EXPECT_EQ(other.constants, draw.constants);
        EXPECT_EQ(forward.list.pixel_programs[static_cast<std::size_t>(other.pixel_program)].path.program,
                  deferred.list.pixel_programs[static_cast<std::size_t>(draw.pixel_program)].path.program);
      }
    }
    EXPECT_GT(on_top, 0) << name;
    // Where no lit surface lies below, the pictures are equal to the bit.
    const auto on_gbuffer = [&](std::size_t i) { return b.depth_d24[i] != raster::kDepthMax; };
    std::uint64_t compared = 0;
    for (std::size_t i = 0; i < a.pixel_count(); ++i) {
      if (on_gbuffer(i) && std::string(name) == "overdraw_stress") continue;
      const std::uint32_t path = b.cost.path[i];
      if (path == 0 || b.paths[path - 1].program.find("forward_lit") == std::string::npos) continue;
      const bool opaque = b.paths[path - 1].program.find("unlit") != std::string::npos;
      if (!opaque && on_gbuffer(i)) continue;
      ++compared;
      for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(a.linear[4 * i + c], b.linear[4 * i + c]);
    }
    EXPECT_GT(compared, std::string(name) == "beach_hut" ? 100u : 0u);
  }
}

TEST(Deferred, PassesNobodyNeedsDoNotRun) {
  FrameOptions options;
  options.width = 96;
  options.height = 54;
  options.pipeline = Pipeline::Deferred;
  const auto names = [&] {
    std::string text;
    for (const PassTotals& pass : render_frame(test::sample_scene("material_wall"), options).passes)
      text += pass.name + " ";
    return text;
  };
  EXPECT_EQ(names(), "gbuffer sun ");
  options.lights = "none";
  EXPECT_EQ(names(), "gbuffer sun ");  // ambient
  options.ambient = AmbientKind::None;
  EXPECT_EQ(names(), "gbuffer ");
}

}  // namespace
}  // namespace aluminate::passes
