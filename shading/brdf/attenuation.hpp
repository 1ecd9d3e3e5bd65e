// How a punctual light falls off with distance and angle. In: squared distance, cone cosines. Out: a factor
// >= 0 on the light's colour. Scene lights follow glTF; the rig has its own law, bounded at the light.
#pragma once

#include <algorithm>
#include <cmath>

#include "shading/brdf/clamped.hpp"

namespace aluminate::brdf {

/// The rig's falloff 1 / (1 + 4 d^2 / r^2), r the scene's half diagonal > 0: 1 at the light, 1/5 at distance
/// r.
[[nodiscard]] inline double rig_attenuation(double distance_squared, double scene_radius) noexcept {
  return 1.0 / (1.0 + distance_squared * 4.0 / (scene_radius * scene_radius));
}

/// [KHRLights] Inverse square under a window that reaches 0 at the range: clamp(1 - (d / range)^4) / d^2;
/// range <= 0 is unlimited. Distances below 0.00316 (d^2 < 1e-5) count as that, so the value stays finite at
/// the light.
[[nodiscard]] inline double range_attenuation(double distance_squared, double range) noexcept {
  constexpr double kMinDistanceSquared = 1e-5;
  double window = 1.0;
  if (range > 0.0) {
    const double ratio_squared = distance_squared / (range * range);
    window = clamped(1.0 - ratio_squared * ratio_squared);
  }
  return window / std::max(distance_squared, kMinDistanceSquared);
}

/// [KHRLights] Spot cone: clamp((cos angle - cos outer) / max(0.001, cos inner - cos outer))^2, angles in
/// radians from the axis, 0 <= inner < outer <= pi/2. 1 inside the inner cone, 0 outside the outer.
[[nodiscard]] inline double spot_attenuation(double cos_angle, double inner_cone,
                                             double outer_cone) noexcept {
  const double cos_outer = std::cos(outer_cone);
  const double scale = 1.0 / std::max(0.001, std::cos(inner_cone) - cos_outer);
  const double cone = clamped((cos_angle - cos_outer) * scale);
  return cone * cone;
}

}  // namespace aluminate::brdf
