// Reflectance of the specular term under light from everywhere, as one expression a shader can afford: what a
// prefiltered cube map is multiplied by. In: gloss, cosine of the view, cspec. Out: an approximation of
// directional_albedo() with Schlick-Smith visibility and Schlick's Fresnel, in [0, 1].
#pragma once

#include <algorithm>
#include <cmath>

namespace aluminate::brdf {

/// [Lazarov13], fitted to this very lobe (m = 8192^g): a0 + cspec (a1 - a0), a0 the reflectance of cspec = 0
/// up to scale. Within 0.05 of the integral for cspec = 0.04; for cspec = 1 within 0.12 from gloss 0.6 and
/// n.v = 1/2 up. Rough metals and metals at grazing views keep the energy that Schlick-Smith loses: 0.90
/// against 0.32 at gloss 0.6, n.v = 0.05 (environment_test.cpp). g, n_dot_v, cspec in [0, 1].
[[nodiscard]] inline double environment_reflectance(double gloss, double n_dot_v, double cspec) noexcept {
  const double a0 = gloss / 0.96 * std::min(0.475 * gloss, std::exp2(-9.28 * n_dot_v)) +
                    (0.0275 - 0.25 * 0.04) / 0.96 * gloss + (0.015 - 0.75 * 0.04) / 0.96;
  const double a1 = 0.25 * gloss + 0.75;
  return std::clamp(a0 + cspec * (a1 - a0), 0.0, 1.0);
}

}  // namespace aluminate::brdf
