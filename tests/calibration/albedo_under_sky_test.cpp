// The whole way of an albedo: photograph, calibration, material of a scene, picture under a sky. What is seen
// is the measured reflectance times the sky's irradiance over pi; no number is guessed on the way.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "calibration/calibrate.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/output_file.hpp"
#include "scenes/base_color.hpp"
#include "scenes/loader.hpp"
#include "shading/passes/prepared.hpp"
#include "shading/passes/sky_setup.hpp"
#include "shading/sky/sun.hpp"
#include "tests/calibration/synthetic_photo.hpp"

namespace aluminate::calibration {
namespace {

namespace fs = std::filesystem;

// Light from the hemisphere around a direction, weighted by its cosine: midpoints in height and angle, no
// harmonics.
glm::dvec3 irradiance_by_quadrature(const sky::Sky& sky, const glm::dvec3& normal) {
  constexpr int kHeights = 400, kAngles = 800;
  glm::dvec3 sum(0.0);
  for (int i = 0; i < kHeights; ++i)
    for (int j = 0; j < kAngles; ++j) {
      const double z = (i + 0.5) / kHeights, angle = 2.0 * std::numbers::pi * (j + 0.5) / kAngles;
      const double r = std::sqrt(1.0 - z * z);
      const glm::dvec3 direction(r * std::cos(angle), r * std::sin(angle), z);  // z up, above the ground
      const double cosine = glm::dot(direction, normal);
      if (cosine > 0.0) sum += sky::extended_radiance(sky, direction) * cosine;
    }
  return sum * (2.0 * std::numbers::pi / kHeights / kAngles);
}

TEST(AlbedoUnderTheSky, IsSeenAsReflectanceTimesIrradianceOverPi) {
  const fs::path folder = fs::path(testing::TempDir()) / ("albedo_under_sky_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const std::string photo = folder / "photo.png", albedo = folder / "albedo.png", wall = folder / "wall.gltf",
                    scene_file = folder / "scene.glb";
  test::Scene taken;
  taken.camera = test::realistic_camera();
  test::write_photograph(taken, photo);
  calibrate(photo, {}, {albedo, "", "", "", wall, ""}, "test");
  // A scene of its own whose material gets the picture, as `aluminate scene material` does it.
  host::write_file(scene_file, scenes::with_base_color(wall, host::read_bytes(albedo), albedo, {}));
  const scenes::Scene scene = scenes::load_scene(scene_file);
  const host::Image8 codes = host::read_image_rgba8(albedo);
  const auto centres = patch_centres(taken.corners);

  for (const char* sky : {"sky=fc3,sun=40,90", "sky=12,sun=25,90"}) {
    passes::FrameOptions options;
    options.width = options.height = 9;
    set_options(options, std::string(sky) + ",ambient=sky");
    const passes::SkySetup setup = *passes::make_sky_setup(options);
    const glm::dvec3 normal(0, 0, 1);
    ASSERT_LT(glm::dot(glm::dvec3(setup.sun.position), normal), 0.0) << "the sun must stand behind the wall";
    const glm::dvec3 light = sky::irradiance(setup.light, sky::world_to_z_up(normal));
    const glm::dvec3 checked = irradiance_by_quadrature(setup.sky, sky::world_to_z_up(normal));
    for (int c = 0; c < 3; ++c)  // nine harmonics are within some percent of the sky
      EXPECT_NEAR(light[c], checked[c], 0.06 * checked[c]) << sky;

    for (const std::size_t patch : {0u, 7u, 14u, 18u, 21u, 23u}) {
      // The square is the picture, its longer side 2: look straight at the middle of a patch, and at nothing
      // else.
      const double x = (centres[patch].x + 0.5) / 320.0 - 1.0, y = 0.75 - (centres[patch].y + 0.5) / 320.0;
      options.camera = fmt::format("{},{},1:{},{},0:4", x, y, x, y);
      const passes::Frame frame = render_frame(scene, options);
      const std::size_t texel = static_cast<std::size_t>(std::lround(centres[patch].y)) * 640 +
                                static_cast<std::size_t>(std::lround(centres[patch].x));
      for (std::size_t c = 0; c < 3; ++c) {
        const double reflectance = srgb_to_linear(codes.texels[4 * texel + c] / 255.0);
        EXPECT_NEAR(reflectance, std::max(0.0, chart_reference(taken.edition).rgb_lin[patch][c]), 0.02);
        constexpr double kSpecular = 0.04;  // glTF: a dielectric reflects it beside its diffuse colour
        const double want = (reflectance + kSpecular) * light[static_cast<int>(c)] / std::numbers::pi;
        for (std::size_t i = 0; i < frame.pixel_count(); ++i)
          EXPECT_NEAR(frame.linear[4 * i + c], want, 2e-4 * want + 1e-5)
              << sky << " patch " << patch << " channel " << c << " pixel " << i;
      }
    }
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace aluminate::calibration
