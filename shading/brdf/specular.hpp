// pi times the specular BRDF: the number behind `eval brdf` and behind every light's highlight. In: power,
// four cosines, cspec and the variant. Out: F * V * norm(m) * (n.h)^m. Never multiplied by n.l: that belongs
// to the reflectance integral.
//
// Pi-folded: a punctual light is given by the colour that a white Lambert surface facing it returns, so it
// carries pi [LagardePI] [Hoffman10], and cdiff / pi + F V D / 4 becomes cdiff + F V (m + 2) / 8 (n.h)^m.
#pragma once

#include "shading/brdf/blinn_phong.hpp"
#include "shading/brdf/fresnel.hpp"
#include "shading/brdf/visibility.hpp"

namespace aluminate::brdf {

/// Which specular model; the defaults are the program's.
struct Variant {
  Visibility visibility = Visibility::SchlickSmith;
  Fresnel fresnel = Fresnel::Schlick;
  bool operator==(const Variant&) const = default;
};

/// The cosines of one light, view and half vector; clamped to [0, 1] by every term.
struct Cosines {
  double n_dot_l = 1, n_dot_v = 1, n_dot_h = 1, h_dot_v = 1;
};

/// [TorranceSparrow67] [Hoffman10] [McAuley12] pi f_specular = F(h.v) V(m, n.l, n.v) norm(m) (n.h)^m. m >= 0.
/// Finite for all cosines, also all zero: the largest value is norm(8192) / a^2 = 6.6e6 (schlick-smith at
/// double grazing), beyond a half float. No test of n.l here: the term is a ratio, and light from below the
/// horizon is dropped by its factor n.l = 0.
[[nodiscard]] inline double specular_from_power(double m, const Cosines& c, double cspec,
                                                Variant variant) noexcept {
  return fresnel(variant.fresnel, cspec, c.h_dot_v) *
         scaled_visibility(variant.visibility, m, c.n_dot_l, c.n_dot_v) * blinn_phong_lobe(m, c.n_dot_h);
}

/// The same by gloss, m = 2^(13 g): one row of `eval brdf`.
[[nodiscard]] inline double specular(double gloss, const Cosines& c, double cspec, Variant variant) noexcept {
  return specular_from_power(power_from_gloss(gloss), c, cspec, variant);
}

}  // namespace aluminate::brdf
