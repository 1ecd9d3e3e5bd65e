// Visibility V = G / ((n.l)(n.v)) in the four variants whose price this project measures. In: power m, n.l,
// n.v. Out: V, finite and positive everywhere, symmetric in l and v. Each variant brings the normalisation it
// was published with. Variants are rows of kVisibilityTerms: to add one, add a row.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string_view>

#include "shading/brdf/blinn_phong.hpp"
#include "shading/brdf/clamped.hpp"

namespace aluminate::brdf {

enum class Visibility : std::uint8_t { None, SchlickSmith, Integrated, Cheap };

/// [Lazarov11] [McAuley12] a = 1 / sqrt(pi m / 4 + pi / 2) = k sqrt(2 / pi) with k = sqrt(2 / (m + 2)), the
/// Beckmann roughness of power m; the root covers 2 / pi only (the published text puts k under it). m >= 0:
/// 0.798 at m = 0, 0.651470 at m = 1, 0.0124654 at m = 8192, so 0 < a < 1 always.
[[nodiscard]] inline double schlick_smith_a(double m) noexcept {
  return 1.0 / std::sqrt(std::numbers::pi * m / 4.0 + std::numbers::pi / 2.0);
}

/// Implicit geometry G = (n.l)(n.v): V = 1.
[[nodiscard]] inline double visibility_none(double, double, double) noexcept { return 1.0; }

/// [Schlick94] [Lazarov11] V = 1 / (((n.l)(1 - a) + a)((n.v)(1 - a) + a)). From 1 at n.l = n.v = 1 up to 1 /
/// a^2 with both at 0: 2.36 at m = 1, 6435 at m = 8192. 8 shader instructions, 4 of them independent of the
/// light.
[[nodiscard]] inline double visibility_schlick_smith(double m, double n_dot_l, double n_dot_v) noexcept {
  const double a = schlick_smith_a(m);
  const double light = clamped(n_dot_l) * (1.0 - a) + a;
  const double view = clamped(n_dot_v) * (1.0 - a) + a;
  return 1.0 / (light * view);
}

/// [McAuley12] V = (-ln a / (1 - a))^2: Schlick-Smith averaged over l and over v, two independent hemispheres
/// of uniform solid angle (the published text shows one integral; docs/shading.md). 1.5117 at m = 1, 19.715
/// at m = 8192.
[[nodiscard]] inline double visibility_integrated(double m, double, double) noexcept {
  const double a = schlick_smith_a(m);
  const double average = -std::log(a) / (1.0 - a);  // 1 - a > 0.2: never 0/0
  return average * average;
}

/// [McAuley12] V = 1 under the normalisation (2 m + 1) / 8, which folds (2 m + 1) / (m + 2), 1 .. 2, into the
/// lobe's scale.
[[nodiscard]] inline double visibility_cheap(double, double, double) noexcept { return 1.0; }

/// One variant as data; `name` is the value of --visibility. Pi-folded specular = F * visibility * norm *
/// (n.h)^m.
struct VisibilityTerm {
  Visibility id;
  std::string_view name;
  std::string_view formula;
  double (*visibility)(double m, double n_dot_l, double n_dot_v) noexcept;
  double (*norm)(double m) noexcept;
  bool constant;  // V does not depend on n.l and n.v
};

inline constexpr std::array<VisibilityTerm, 4> kVisibilityTerms{{
    {Visibility::None, "none", "V=1, (m+2)/8", visibility_none, norm_m_plus_2, true},
    {Visibility::SchlickSmith, "schlick-smith",
     "V=1/(((n.l)(1-a)+a)((n.v)(1-a)+a)), a=1/sqrt(pi m/4+pi/2), (m+2)/8", visibility_schlick_smith,
     norm_m_plus_2, false},
    {Visibility::Integrated, "integrated", "V=(-ln a/(1-a))^2, (m+2)/8", visibility_integrated, norm_m_plus_2,
     true},
    {Visibility::Cheap, "cheap", "V=1, (2m+1)/8", visibility_cheap, norm_2m_plus_1, true},
}};

/// The row of a variant.
[[nodiscard]] constexpr const VisibilityTerm& term(Visibility visibility) noexcept {
  return kVisibilityTerms[static_cast<std::size_t>(visibility)];
}

/// The command-line name, and back; no value for a name that is not in the table (case matters).
[[nodiscard]] constexpr std::string_view to_string(Visibility visibility) noexcept {
  return term(visibility).name;
}
[[nodiscard]] constexpr std::optional<Visibility> parse_visibility(std::string_view name) noexcept {
  for (const VisibilityTerm& row : kVisibilityTerms)
    if (row.name == name) return row.id;
  return std::nullopt;
}

/// V * norm(m): the whole scale of the lobe, pi-folded, without F.
[[nodiscard]] inline double scaled_visibility(Visibility variant, double m, double n_dot_l,
                                              double n_dot_v) noexcept {
  const VisibilityTerm& row = term(variant);
  return row.visibility(m, n_dot_l, n_dot_v) * row.norm(m);
}

}  // namespace aluminate::brdf
