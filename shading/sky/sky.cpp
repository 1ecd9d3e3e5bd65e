#include "shading/sky/sky.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace aluminate::sky {

glm::dvec3 SkyGradient::at(double cos_zenith) const noexcept {
  if (stops.empty()) return glm::dvec3(1.0);
  if (!(cos_zenith > stops.front().cos_zenith)) return stops.front().color_lin;
  for (std::size_t i = 1; i < stops.size(); ++i) {
    if (cos_zenith > stops[i].cos_zenith) continue;
    const double span = stops[i].cos_zenith - stops[i - 1].cos_zenith;
    return glm::mix(stops[i - 1].color_lin, stops[i].color_lin,
                    (cos_zenith - stops[i - 1].cos_zenith) / span);
  }
  return stops.back().color_lin;
}

SkyGradient zenith_horizon_gradient(const glm::dvec3& zenith_lin, const glm::dvec3& horizon_lin) {
  return {{{0.0, horizon_lin}, {1.0, zenith_lin}}};
}

double day_share(const glm::dvec3& to_sun) noexcept {
  constexpr double kTwilight = 6.0 * std::numbers::pi / 180.0;
  const double elevation = std::atan2(to_sun.z, std::hypot(to_sun.x, to_sun.y));
  return std::clamp(1.0 + elevation / kTwilight, 0.0, 1.0);
}

glm::dvec3 extended_radiance(const Sky& sky, const glm::dvec3& direction) noexcept {
  const double height = std::clamp(direction.z, 0.0, 1.0);
  const double day = day_share(sky.to_sun);
  glm::dvec3 sum(0.0);
  if (day > 0.0)
    sum += sky.gradient.at(height) *
           (day * sky.intensity * relative_luminance(sky.cie, sky.relative, sky.to_sun, direction));
  if (day < 1.0) sum += sky.night.at(height) * (1.0 - day);
  return sum;
}

glm::dvec3 radiance(const Sky& sky, const glm::dvec3& direction) noexcept {
  return direction.z < 0.0 ? sky.ground : extended_radiance(sky, direction);
}

}  // namespace aluminate::sky
