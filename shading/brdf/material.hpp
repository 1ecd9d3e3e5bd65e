// glTF materials in the terms of the BRDF. In: linear factors as the file gives them, after textures. Out:
// cdiff, cspec, power m and gloss g. Never reads a texture, never decodes sRGB.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "shading/brdf/blinn_phong.hpp"

namespace aluminate::brdf {

/// Reflectance at normal incidence of a dielectric in metallic-roughness: index of refraction 1.5 [glTF2].
inline constexpr double kDielectricSpecular = 0.04;

struct Reflectance {
  glm::dvec3 cdiff{0};   // linear, [0, 1]
  glm::dvec3 cspec{0};   // linear, [0, 1], at normal incidence
  double m = kMinPower;  // Blinn-Phong power, 1 .. 8192
  double gloss = 0;      // log2(m) / 13, [0, 1]
};

/// [Walter07] [glTF2] Equal peak curvature of Beckmann / GGX of width alpha = roughness^2 and of (n.h)^m: m =
/// 2 / alpha^2 - 2, clamped to the artists' range 1 .. 8192. roughness 0 gives 8192; every roughness above
/// (2/3)^(1/4) = 0.904 gives 1.
[[nodiscard]] inline double power_from_roughness(double roughness) noexcept {
  const double alpha = roughness * roughness;
  const double alpha_squared = alpha * alpha;
  if (!(alpha_squared > 2.0 / (kMaxPower + 2.0))) return kMaxPower;
  return std::max(2.0 / alpha_squared - 2.0, kMinPower);
}

/// Roughness of a power in 1 .. 8192: (2 / (m + 2))^(1/4), the inverse of power_from_roughness.
[[nodiscard]] inline double roughness_from_power(double m) noexcept {
  return std::sqrt(std::sqrt(2.0 / (m + 2.0)));
}

/// [glTF2] cdiff = base (1 - metallic), cspec = mix(0.04, base, metallic), m from roughness. All inputs in
/// [0, 1].
[[nodiscard]] inline Reflectance from_metallic_roughness(const glm::dvec3& base_color_lin, double metallic,
                                                         double roughness) noexcept {
  Reflectance r;
  r.cdiff = base_color_lin * (1.0 - metallic);
  r.cspec = glm::mix(glm::dvec3(kDielectricSpecular), base_color_lin, metallic);
  r.m = power_from_roughness(roughness);
  r.gloss = gloss_from_power(r.m);
  return r;
}

/// [KHRSpecGloss] Maps one to one: diffuse is cdiff, specular is cspec, glossiness is g. The extension's own
/// conversion cdiff (1 - max(cspec)) is left out, as the published model does not reduce diffuse by specular
/// either.
[[nodiscard]] inline Reflectance from_specular_glossiness(const glm::dvec3& diffuse_lin,
                                                          const glm::dvec3& specular_lin,
                                                          double glossiness) noexcept {
  return {diffuse_lin, specular_lin, power_from_gloss(glossiness), glossiness};
}

}  // namespace aluminate::brdf
