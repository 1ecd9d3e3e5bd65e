// Outgoing radiance of one surface point under punctual lights and flat ambient: the reference of a whole
// pixel. In: unit vectors in any one space, pi-folded light colours already attenuated. Out: linear radiance,
// not clamped.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "shading/brdf/specular.hpp"

namespace aluminate::brdf {

/// A light as one surface point sees it.
struct IncidentLight {
  glm::dvec3 to_light{0, 0, 1};  // unit
  glm::dvec3 color{1};           // linear, carries pi, times attenuation
};

struct SurfacePoint {
  glm::dvec3 normal{0, 0, 1};  // unit
  glm::dvec3 to_eye{0, 0, 1};  // unit
  glm::dvec3 cdiff{0};         // linear
  glm::dvec3 cspec{0};         // linear
  double m = 1;                // Blinn-Phong power
  glm::dvec3 emissive{0};      // linear
  double occlusion = 1;        // of ambient only
};

/// Cosines of a pair of directions, clamped. h = normalize(l + v); for l = -v, where h is not defined, n.h =
/// h.v = 0: the highlight vanishes for every m > 0, and n.l (n.v) = 0 there anyway unless the eye is behind
/// the surface.
[[nodiscard]] inline Cosines cosines(const glm::dvec3& normal, const glm::dvec3& to_light,
                                     const glm::dvec3& to_eye) noexcept {
  const glm::dvec3 sum = to_light + to_eye;
  const double length_squared = glm::dot(sum, sum);
  const glm::dvec3 half = length_squared > 0.0 ? sum / std::sqrt(length_squared) : glm::dvec3(0.0);
  return {clamped(glm::dot(normal, to_light)), clamped(glm::dot(normal, to_eye)),
          clamped(glm::dot(normal, half)), clamped(glm::dot(half, to_eye))};
}

/// [McAuley12] [Hoffman10] One light's share: color (n.l) (cdiff + F V norm(m) (n.h)^m). A light below the
/// horizon is dropped by its factor n.l = 0, as V is finite there. n.v < 0, which interpolated normals
/// produce, counts as 0. Diffuse is not reduced by 1 - F, as published.
[[nodiscard]] inline glm::dvec3 light_radiance(const SurfacePoint& surface, const IncidentLight& light,
                                               Variant variant) noexcept {
  const Cosines c = cosines(surface.normal, light.to_light, surface.to_eye);
  const double lobe = scaled_visibility(variant.visibility, surface.m, c.n_dot_l, c.n_dot_v) *
                      blinn_phong_lobe(surface.m, c.n_dot_h);
  const double weight = term(variant.fresnel).weight(c.h_dot_v);
  const glm::dvec3 reflectance = surface.cdiff + (surface.cspec + (1.0 - surface.cspec) * weight) * lobe;
  return light.color * (c.n_dot_l * reflectance);
}

/// Lo = emissive + occlusion ambient (cdiff + cspec) + sum_i color_i (n.l_i) (cdiff + F V norm(m) (n.h)^m),
/// lights in the order given. `ambient` is the flat ambient colour (--ambient flat:V).
[[nodiscard]] inline glm::dvec3 outgoing_radiance(const SurfacePoint& surface,
                                                  std::span<const IncidentLight> lights, Variant variant,
                                                  const glm::dvec3& ambient = glm::dvec3(0.0)) noexcept {
  glm::dvec3 radiance = surface.emissive + surface.occlusion * ambient * (surface.cdiff + surface.cspec);
  for (const IncidentLight& light : lights) radiance += light_radiance(surface, light, variant);
  return radiance;
}

}  // namespace aluminate::brdf
