// Fresnel reflectance in three spellings, each F = cspec + (1 - cspec) w(h.v) with w falling from 1 at
// grazing incidence. In: cspec (linear, [0, 1]) and h.v. Out: [cspec, 1]. Variants are rows of kFresnelTerms:
// to add one, add a row.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>

#include "shading/brdf/clamped.hpp"

namespace aluminate::brdf {

enum class Fresnel : std::uint8_t { Schlick, Sg, SgLagarde };

/// [Schlick94] w = (1 - h.v)^5. w(0) = 1, w(1) = 0, both exact. Shader cost: sub, 3 mul, mad.
[[nodiscard]] inline double fresnel_weight_schlick(double h_dot_v) noexcept {
  const double x = 1.0 - clamped(h_dot_v);
  const double x2 = x * x;
  return x2 * x2 * x;
}

/// [Lagarde12] [McAuley12] w = exp(-6 h.v), a spherical Gaussian. w(0) = 1, but w(1) = 0.00248: head-on F is
/// 6% above cspec = 0.04. Against Schlick at cspec = 0.04: 0.040 darker near h.v = 0.11, 33% brighter near
/// h.v = 0.61. Shader cost: mul, exp2, mad, with -6 log2(e) = -8.65617 as the constant.
[[nodiscard]] inline double fresnel_weight_sg(double h_dot_v) noexcept {
  return std::exp(-6.0 * clamped(h_dot_v));
}

/// [Lagarde12] w = 2^((-5.55473 h.v - 6.98316) h.v), the better fit. w(0) = 1, w(1) = 0.000168. Shader cost:
/// mad, mul, exp2, mad.
[[nodiscard]] inline double fresnel_weight_sg_lagarde(double h_dot_v) noexcept {
  const double x = clamped(h_dot_v);
  return std::exp2((-5.55473 * x - 6.98316) * x);
}

/// One variant as data; `name` is the value of --fresnel.
struct FresnelTerm {
  Fresnel id;
  std::string_view name;
  std::string_view formula;
  double (*weight)(double h_dot_v) noexcept;
};

inline constexpr std::array<FresnelTerm, 3> kFresnelTerms{{
    {Fresnel::Schlick, "schlick", "(1-h.v)^5", fresnel_weight_schlick},
    {Fresnel::Sg, "sg", "exp(-6 h.v)", fresnel_weight_sg},
    {Fresnel::SgLagarde, "sg-lagarde", "exp2((-5.55473 h.v-6.98316) h.v)", fresnel_weight_sg_lagarde},
}};

/// The row of a variant.
[[nodiscard]] constexpr const FresnelTerm& term(Fresnel fresnel) noexcept {
  return kFresnelTerms[static_cast<std::size_t>(fresnel)];
}

/// The command-line name, and back; no value for a name that is not in the table (case matters).
[[nodiscard]] constexpr std::string_view to_string(Fresnel fresnel) noexcept { return term(fresnel).name; }
[[nodiscard]] constexpr std::optional<Fresnel> parse_fresnel(std::string_view name) noexcept {
  for (const FresnelTerm& row : kFresnelTerms)
    if (row.name == name) return row.id;
  return std::nullopt;
}

/// F = cspec + (1 - cspec) w(h.v). F(h.v = 0) = 1 in every variant: c + (1 - c) is exactly 1 for c in [0, 1]
/// in binary64 up to one rounding. h.v = h.l, so the term is symmetric in light and view.
[[nodiscard]] inline double fresnel(Fresnel variant, double cspec, double h_dot_v) noexcept {
  return cspec + (1.0 - cspec) * term(variant).weight(h_dot_v);
}

}  // namespace aluminate::brdf
