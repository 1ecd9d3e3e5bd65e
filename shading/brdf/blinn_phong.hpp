// The Blinn-Phong lobe and its three normalisations. In: gloss or power m, cosine n.h. Out: pure numbers,
// pi-folded where the name says norm (see specular.hpp for what pi-folded means). Never contains a Fresnel or
// visibility factor.
#pragma once

#include <cmath>
#include <numbers>

#include "shading/brdf/clamped.hpp"

namespace aluminate::brdf {

/// Range of the artists' power: 2^(13 g) over g in [0, 1] [McAuley12].
inline constexpr double kMinPower = 1.0;
inline constexpr double kMaxPower = 8192.0;
inline constexpr double kLog2MaxPower = 13.0;

/// [McAuley12] m = 2^(13 g). g in [0, 1] gives 1 .. 8192; exact at both ends. One step of an 8-bit gloss map
/// multiplies m by 2^(13/255) = 1.036. Not clamped: the formula holds for every real g.
[[nodiscard]] inline double power_from_gloss(double gloss) noexcept {
  return std::exp2(kLog2MaxPower * gloss);
}

/// Inverse of power_from_gloss, g = log2(m) / 13. m > 0; m = 0 (a completely filtered lobe) gives -infinity.
[[nodiscard]] inline double gloss_from_power(double m) noexcept { return std::log2(m) / kLog2MaxPower; }

/// [Blinn77] (n.h)^m, in [0, 1] for m >= 0. 0^0 = 1: a lobe of power 0 is constant. Underflow to 0 is the
/// right value.
[[nodiscard]] inline double blinn_phong_lobe(double m, double n_dot_h) noexcept {
  return std::pow(clamped(n_dot_h), m);
}

/// [Hoffman10] D(h) = (m + 2) / (2 pi) (n.h)^m, m >= 0; per steradian. The factor normalises projected area,
/// int D (n.h) dw = 1 over the hemisphere. (m + 1) / (2 pi), which normalises int D dw, and (m + 8) / (8 pi),
/// the reflected energy of a lobe without V, are different normalisations and do not go with a microfacet V.
[[nodiscard]] inline double blinn_phong_distribution(double m, double n_dot_h) noexcept {
  return (m + 2.0) / (2.0 * std::numbers::pi) * blinn_phong_lobe(m, n_dot_h);
}

/// [Hoffman10] pi * (1/4) * (m + 2) / (2 pi) = (m + 2) / 8: what multiplies F V (n.h)^m when the light
/// carries pi. 0.25 at m = 0, 0.375 at m = 1, 1024.25 at m = 8192.
[[nodiscard]] constexpr double norm_m_plus_2(double m) noexcept { return (m + 2.0) / 8.0; }

/// [McAuley12] (2 m + 1) / 8: (m + 2) / 8 times the visibility (2 m + 1) / (m + 2), which runs from 1 at m =
/// 1 to 2. At the same price as (m + 2) / 8, one multiply-add. Equal to it at m = 1.
[[nodiscard]] constexpr double norm_2m_plus_1(double m) noexcept { return (2.0 * m + 1.0) / 8.0; }

/// (3 m) / 8: another line through 3/8 at m = 1, for comparison only. Like 2 m + 1 it stays below the
/// integrated curve for every m >= 1, which the published plot leaves out (docs/shading.md).
[[nodiscard]] constexpr double norm_3m(double m) noexcept { return (3.0 * m) / 8.0; }

}  // namespace aluminate::brdf
