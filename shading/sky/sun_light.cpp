#include "shading/sky/sun_light.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace aluminate::sky {

glm::dvec3 sun_color(const glm::dvec3& to_sun) noexcept {
  constexpr double kBrightness = 2.0, kDiscRadiusDeg = 0.25;
  constexpr double kOpticalDepth[3] = {0.09, 0.15, 0.27};
  const double elevation_deg =
      std::atan2(to_sun.z, std::hypot(to_sun.x, to_sun.y)) * (180.0 / std::numbers::pi);
  const double above = std::clamp((elevation_deg + kDiscRadiusDeg) / (2 * kDiscRadiusDeg), 0.0, 1.0);
  if (above == 0.0) return glm::dvec3(0.0);
  const double h = std::max(elevation_deg, 0.0);
  const double airmass =
      1.0 / (std::sin(h * (std::numbers::pi / 180.0)) + 0.50572 * std::pow(h + 6.07995, -1.6364));
  glm::dvec3 color;
  for (int c = 0; c < 3; ++c) color[c] = above * kBrightness * std::exp(-kOpticalDepth[c] * airmass);
  return color;
}

}  // namespace aluminate::sky
