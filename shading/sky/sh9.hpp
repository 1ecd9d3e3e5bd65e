// Sky light as nine spherical-harmonics coefficients. In: a Sky, or coefficients and a normal. Out:
// coefficients, irradiance. Real orthonormal basis, z up, order 00, 1-1, 10, 11, 2-2, 2-1, 20, 21, 22.
// Coefficients are of radiance, not of irradiance.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <string_view>

#include "shading/sky/sky.hpp"

namespace aluminate::sky {

/// rgb of one coefficient each.
using Sh9 = std::array<glm::dvec3, 9>;
inline constexpr std::array<std::string_view, 9> kSh9Names{"00",  "1-1", "10", "11", "2-2",
                                                           "2-1", "20",  "21", "22"};

/// [Ramamoorthi01] Y00 = sqrt(1 / 4pi), Y1 = sqrt(3 / 4pi) (y, z, x), Y2 = sqrt(15 / 4pi) (xy, yz, ., xz,
/// (x^2 - y^2) / 2) with Y20 = sqrt(5 / 16pi) (3 z^2 - 1). int Y_i Y_j dw = 1 if i = j, else 0.
[[nodiscard]] std::array<double, 9> sh9_basis(const glm::dvec3& direction) noexcept;

/// c_i = int L Y_i dw over the sphere, `ground` below the horizon. Azimuth moments of f times zenith
/// integrals of gradient and phi, both split at the sun and at every colour stop; error below 1e-10 of the
/// largest coefficient.
[[nodiscard]] Sh9 project(const Sky& sky);

/// Coefficients rounded to multiples of 2^-20 (9.5e-7): what a renderer binds to a shader. The quadrature
/// uses libm, whose last bits differ between systems; the grid keeps them out of pixels.
[[nodiscard]] Sh9 snapped(const Sh9& light) noexcept;

/// [Ramamoorthi01] E(n) = sum A_l c_lm Y_lm(n), A = pi, 2 pi / 3, pi / 4. bands = 2 keeps four coefficients,
/// 3 all nine. Outgoing diffuse = cdiff E / pi. Normals away from a concentrated sky can go slightly
/// negative; callers clamp.
[[nodiscard]] glm::dvec3 irradiance(const Sh9& light, const glm::dvec3& normal, int bands = 3) noexcept;

/// [Ramamoorthi01] The same as the quadratic polynomial a shader evaluates, with c1..c5 = 0.429043, 0.511664,
/// 0.743125, 0.886227, 0.247708 in full precision.
[[nodiscard]] glm::dvec3 irradiance_polynomial(const Sh9& light, const glm::dvec3& normal) noexcept;

/// Two-colour ambient: lerp(lower, upper, (n.up + 1) / 2) times cdiff (+ cspec). Pi-folded: irradiance / pi.
struct HemisphereAmbient {
  glm::dvec3 upper{0}, lower{0};
  [[nodiscard]] glm::dvec3 at(double n_dot_up) const noexcept;
};

/// What bands 0 and 1 leave when only the vertical axis is kept: exact for a sky without azimuth and band 2.
/// lower >= 0.
[[nodiscard]] HemisphereAmbient hemisphere_ambient(const Sh9& light) noexcept;

}  // namespace aluminate::sky
