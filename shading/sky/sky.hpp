// Sky radiance: the artists' colour gradient times CIE luminance, in one function that the dome, the SH light
// and the cube maps share. In: a Sky and a direction (z up, unit). Out: linear rgb radiance, not clamped. The
// post-process multiplier is not part of it: it belongs to what the eye sees of the dome, never to light
// (dome.hpp).
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "shading/sky/cie_sky.hpp"

namespace aluminate::sky {

/// A colour at a height: cos_zenith = sine of elevation, 0 at the horizon, 1 at the zenith.
struct ColorStop {
  double cos_zenith = 0;
  glm::dvec3 color_lin{1};
};

/// Piecewise linear in cos Z between stops of rising height, constant beyond the ends; no stops: white. Two
/// stops at 0 and 1 are lerp(horizon, zenith, cos Z). It multiplies the gradation phi instead of replacing
/// it: the sources build light "from gradients and CIE model" and leave the combination open.
struct SkyGradient {
  std::vector<ColorStop> stops;
  [[nodiscard]] glm::dvec3 at(double cos_zenith) const noexcept;
};
[[nodiscard]] SkyGradient zenith_horizon_gradient(const glm::dvec3& zenith_lin,
                                                  const glm::dvec3& horizon_lin);

struct Sky {
  CieParameters cie = kFarCry3Sky;
  Relative relative = Relative::Sun;
  glm::dvec3 to_sun{0, 0, 1};                   // unit, z up; z < 0: sun below the horizon
  SkyGradient gradient;                         // by day
  double intensity = 1;                         // >= 0
  SkyGradient night{{{0.0, glm::dvec3(0.0)}}};  // radiance when the sun is 6 degrees down; black by default
  glm::dvec3 ground{0};                         // radiance from below the horizon, as light
};

/// Share of the day term: 1 while the sun is up, linear in its angle to 0 at 6 degrees below the horizon
/// (civil twilight). The CIE model ends at sunset; this is ours.
[[nodiscard]] double day_share(const glm::dvec3& to_sun) noexcept;

/// day_share gradient(cos Z) L_rel intensity + (1 - day_share) night(cos Z). Below the horizon the values of
/// the horizon continue (phi = 1, cos Z = 0): what a dome mesh shows there.
[[nodiscard]] glm::dvec3 extended_radiance(const Sky& sky, const glm::dvec3& direction) noexcept;

/// The same above the horizon; `ground` where direction.z < 0: what lights a surface.
[[nodiscard]] glm::dvec3 radiance(const Sky& sky, const glm::dvec3& direction) noexcept;

}  // namespace aluminate::sky
