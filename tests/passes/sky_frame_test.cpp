// The sky in a frame: the dome and the light it casts are one function, the polariser touches one and not the
// other.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "rasterizer/limits.hpp"
#include "scenes/scene.hpp"
#include "shading/passes/prepared.hpp"
#include "shading/passes/view_rays.hpp"
#include "shading/sky/sun.hpp"
#include "tests/passes/sample_scene.hpp"

namespace aluminate::passes {
namespace {

FrameOptions options_for(const std::string& assignments) {
  FrameOptions options;
  options.width = options.height = 128;
  set_options(options, assignments);
  return options;
}

// A scene of nothing: every pixel is sky.
scenes::Scene nothing() {
  scenes::Scene scene;
  scene.file = "nothing";
  scene.bounds_min = glm::dvec3(-1);
  scene.bounds_max = glm::dvec3(1);
  return scene;
}

// The dome as six pictures of a cube: each pixel's solid angle is that of its square, (4 / n^2) / (1 + u^2 +
// v^2)^1.5.
glm::dvec3 rendered_dome_integral(const std::string& sky) {
  // fovy 90, square pictures. Looking exactly up or down is a camera of its own: scenes/view.cpp.
  const char* cameras[] = {"0,0,0:1,0,0:90",  "0,0,0:-1,0,0:90", "0,0,0:0,1,0:90",
                           "0,0,0:0,-1,0:90", "0,0,0:0,0,1:90",  "0,0,0:0,0,-1:90"};
  glm::dvec3 sum(0.0);
  double solid_angle = 0;
  for (const char* camera : cameras) {
    FrameOptions options = options_for(sky);
    options.camera = camera;
    const Frame frame = render_frame(nothing(), options);
    PreparedFrame prepared;
    prepare(nothing(), options, prepared);
    const ViewRays rays(prepared.list.view);
    for (int y = 0; y < options.height; ++y)
      for (int x = 0; x < options.width; ++x) {
        const double u = pixel_ndc(x, options.width), v = -pixel_ndc(y, options.height);
        const double weight = 4.0 / (options.width * options.height) / std::pow(1 + u * u + v * v, 1.5);
        solid_angle += weight;
        if ((rays.right * u + rays.up * v + rays.forward).y < 0) continue;  // the SH light has a black ground
        const float* pixel = &frame.linear[4 * static_cast<std::size_t>(y * options.width + x)];
        sum += glm::dvec3(pixel[0], pixel[1], pixel[2]) * weight;
      }
  }
  EXPECT_NEAR(solid_angle, 4 * std::numbers::pi, 1e-3);
  return sum;
}

TEST(SkyInTheFrame, RenderedDomeIntegratesToTheShConstantTerm) {
  for (const char* sky : {"sky=fc3,sun=35,20", "sky=fc3,time=18:00", "sky=12,sun=5,200", "sky=5,sun=60,0"}) {
    const std::optional<SkySetup> setup = make_sky_setup(options_for(sky));
    const glm::dvec3 dc = setup->light[0] / 0.28209479177387814;  // int L dw = c00 / Y00
    const glm::dvec3 rendered = rendered_dome_integral(sky);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(rendered[c], dc[c], 0.005 * dc[c]) << sky << " channel " << c;
  }
}

TEST(SkyInTheFrame, EveryPixelIsTheSkyFunction) {
  for (const char* sky : {"sky=fc3,sun=8,-40", "sky=1,time=09:00", "sky=fc3,sun=-3,10", "sky=15,sun=-20,0"}) {
    FrameOptions options = options_for(sky);
    options.camera = "0,0,0:0.3,0.5,-1:100";
    const Frame frame = render_frame(nothing(), options);
    PreparedFrame prepared;
    prepare(nothing(), options, prepared);
    const ViewRays rays(prepared.list.view);
    const SkySetup& setup = *prepared.list.uniforms.sky;
    for (int y = 0; y < options.height; y += 3)
      for (int x = 0; x < options.width; ++x) {
        const glm::dvec3 ray = glm::normalize(rays.right * pixel_ndc(x, options.width) -
                                              rays.up * pixel_ndc(y, options.height) + rays.forward);
        const glm::dvec3 want = sky::extended_radiance(setup.sky, sky::world_to_z_up(ray));
        const float* got = &frame.linear[4 * static_cast<std::size_t>(y * options.width + x)];
        // 6.7e-5 rad of the shader's arc cosine times the steepest d = 3, and the uniforms' grid of 2^-24.
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(got[c], want[c], 2.5e-4 * want[c] + 1e-5) << sky << " " << x << "," << y;
      }
  }
}

TEST(SkyInTheFrame, PolariserScalesTheDomeAndNothingElse) {
  const scenes::Scene& scene = test::sample_scene("beach_hut");
  for (const char* pipeline : {"forward", "deferred"}) {
    FrameOptions options = options_for("sky=fc3,time=16:00,ambient=sky,pipeline=" + std::string(pipeline));
    options.height = 72;
    const Frame plain = render_frame(scene, options);
    set_option(options, "polarizer", "1,1,1");
    set_option(options, "D", "POLARIZER=1");  // the multiplication itself, by 1
    const Frame identity = render_frame(scene, options);
    EXPECT_EQ(identity.linear, plain.linear);
    EXPECT_EQ(identity.rgba8, plain.rgba8);
    set_option(options, "polarizer", "0.5,0.75,2");
    const Frame filtered = render_frame(scene, options);
    EXPECT_EQ(make_sky_setup(options)->light, make_sky_setup(options_for("sky=fc3,time=16:00"))->light);
    std::uint64_t sky_pixels = 0, others = 0;
    const float factor[3] = {0.5f, 0.75f, 2.0f};
    for (std::size_t i = 0; i < plain.pixel_count(); ++i) {
      const bool dome = plain.paths[plain.cost.path[i] - 1].program.find("dome") != std::string::npos;
      // Blended surfaces show the dome behind them.
      const bool through =
          plain.paths[plain.cost.path[i] - 1].program.find("forward_lit") != std::string::npos &&
          std::string(pipeline) == "deferred";
      if (through || (std::string(pipeline) == "forward" && plain.depth_d24[i] == raster::kDepthMax && !dome))
        continue;
      dome ? ++sky_pixels : ++others;
      for (std::size_t c = 0; c < 3; ++c) {
        const float want = dome ? plain.linear[4 * i + c] * factor[c] : plain.linear[4 * i + c];
        if (dome)
          EXPECT_NEAR(filtered.linear[4 * i + c], want,
                      2e-7 * (1 + want));  // rounded on the grid, not in binary32
        else
          EXPECT_EQ(filtered.linear[4 * i + c], want);
      }
    }
    EXPECT_GT(sky_pixels, 500u);
    EXPECT_GT(others, 500u);
  }
}

TEST(SkyInTheFrame, AmbientIsTheIrradianceOfTheSkyOverPi) {
  for (const char* time : {"07:00", "12:00", "18:10"}) {
    const SkySetup setup = *make_sky_setup(options_for("sky=fc3,time=" + std::string(time)));
    for (const glm::dvec3 n : {glm::dvec3(0, 1, 0), glm::dvec3(0.6, 0, 0.8), glm::dvec3(-0.48, -0.6, 0.64)}) {
      const glm::dvec3 want = sky::irradiance(setup.light, sky::world_to_z_up(n)) / std::numbers::pi;
      for (int c = 0; c < 3; ++c) {
        const auto& q = setup.ambient_sh;
        const auto k = static_cast<std::size_t>(c);
        const double got = glm::dot(q[k], glm::dvec4(n, 1)) +
                           glm::dot(q[3 + k], glm::dvec4(n.x * n.y, n.y * n.z, n.z * n.x, n.y * n.y)) +
                           q[6][c] * (n.x * n.x - n.z * n.z);
        EXPECT_NEAR(got, want[c], 1e-12) << time;
      }
    }
  }
}

TEST(SkyInTheFrame, SkyLightWithoutASkyIsRefused) {
  EXPECT_THROW(render_frame(nothing(), options_for("ambient=sky")), UserError);
}

}  // namespace
}  // namespace aluminate::passes
