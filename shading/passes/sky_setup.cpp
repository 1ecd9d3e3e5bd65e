#include "shading/passes/sky_setup.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "platform/host/error.hpp"
#include "shading/sky/day_cycle.hpp"
#include "shading/sky/sun.hpp"
#include "shading/sky/sun_light.hpp"

namespace aluminate::passes {
namespace {

/// To a multiple of 2^-24: far coarser than what libm may differ by, far finer than a stored step.
double snapped(double x) { return std::nearbyint(x * 0x1p24) * 0x1p-24; }
glm::dvec3 snapped(const glm::dvec3& v) { return {snapped(v.x), snapped(v.y), snapped(v.z)}; }

/// An evening hour with the sun this high on the default path: the artists' colours are keyed by time.
double hours_of_elevation(double elevation_deg) {
  const double noon = sky::sun_at(12.0).elevation_deg;
  return std::clamp(12.0 + 6.0 * (noon - elevation_deg) / noon, 12.0, 23.99);
}

sky::Sky sky_of(const FrameOptions& options) {
  const sky::CieParameters cie = sky::parse_sky(options.sky);
  if (options.sun.empty()) return sky::sky_at(sky::parse_time(options.time), sky::clear_day(), cie);
  const sky::SunPosition sun = sky::parse_sun(options.sun);
  sky::Sky sky = sky::sky_at(hours_of_elevation(sun.elevation_deg), sky::clear_day(), cie);
  sky.to_sun = sky::to_sun(sun);
  return sky;
}

// The quadratic of sky::irradiance_polynomial in world axes (x, z, -y), over pi.
std::array<glm::dvec4, 7> world_quadratic(const sky::Sh9& l) {
  // [Ramamoorthi01] c1..c5 = 0.429043, 0.511664, 0.743125, 0.886227, 0.247708: A_l times the basis.
  constexpr double pi = std::numbers::pi, over_pi = 1 / pi;
  const double c1 = pi / 8 * std::sqrt(15 / (4 * pi)), c2 = pi / 3 * std::sqrt(3 / (4 * pi)),
               c3 = 3 * pi / 4 * std::sqrt(5 / (16 * pi)), c4 = pi * std::sqrt(1 / (4 * pi)), c5 = c3 / 3;
  std::array<glm::dvec4, 7> q{};
  for (int c = 0; c < 3; ++c) {
    const auto k = static_cast<std::size_t>(c);
    q[k] = glm::dvec4(2 * c2 * l[3][c], 2 * c2 * l[2][c], -2 * c2 * l[1][c], c4 * l[0][c] - c5 * l[6][c]) *
           over_pi;
    q[3 + k] = glm::dvec4(2 * c1 * l[7][c], -2 * c1 * l[5][c], -2 * c1 * l[4][c], c3 * l[6][c]) * over_pi;
    q[6][c] = c1 * l[8][c] * over_pi;
  }
  return q;
}

}  // namespace

std::optional<SkySetup> make_sky_setup(const FrameOptions& options) {
  if (!options.has_sky()) {
    if (options.ambient == AmbientKind::Sky || options.ambient == AmbientKind::Hemisphere)
      throw UserError(fmt::format("--ambient {}: there is no sky", ambient_text(options)),
                      "add --sky fc3, or use --ambient flat:0.03");
    return std::nullopt;
  }
  SkySetup s;
  s.sky = sky_of(options);
  s.light = sky::snapped(sky::project(s.sky));
  s.ambient_sh = world_quadratic(s.light);
  s.hemisphere = sky::hemisphere_ambient(s.light);

  const glm::dvec3 to_sun = snapped(sky::z_up_to_world(s.sky.to_sun));
  s.sun.name = "sun";
  s.sun.position = glm::dvec4(to_sun, 0.0);
  s.sun.color = snapped(sky::sun_color(s.sky.to_sun));

  constexpr double kLog2E = std::numbers::log2e;
  const sky::CieParameters& cie = s.sky.cie;
  const double day = sky::day_share(s.sky.to_sun);
  const double scale = day * s.sky.intensity * sky::normalisation(cie, s.sky.relative, s.sky.to_sun);
  s.sun_direction = glm::dvec4(to_sun, 0.0);
  s.gradation = {snapped(cie.a), snapped(cie.b * kLog2E), 0, 0};
  s.indicatrix = {snapped(cie.c), snapped(cie.d * kLog2E), snapped(cie.e),
                  snapped(1.0 - cie.c * std::exp(cie.d * (std::numbers::pi / 2)))};
  s.zenith = glm::dvec4(snapped(s.sky.gradient.at(1.0) * scale), 0.0);
  s.horizon = glm::dvec4(snapped(s.sky.gradient.at(0.0) * scale), 0.0);
  s.night_zenith = glm::dvec4(snapped(s.sky.night.at(1.0) * (1.0 - day)), 0.0);
  s.night_horizon = glm::dvec4(snapped(s.sky.night.at(0.0) * (1.0 - day)), 0.0);
  return s;
}

void replace_directional_lights(const SkySetup& sky, scenes::LightSet& lights) {
  std::erase_if(lights.lights, [](const scenes::ShadingLight& light) { return light.position.w == 0.0; });
  if (sky.sun.color != glm::dvec3(0.0)) lights.lights.insert(lights.lights.begin(), sky.sun);
}

}  // namespace aluminate::passes
