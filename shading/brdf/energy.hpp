// How much of the light comes back: curves of the lobe's scale, the white furnace, and where a variant
// returns more than it receives. In: gloss or power, cosine of the view, cspec, variant. Out: reflectances
// and plain rows for a table. cspec = 1 makes F = 1 in every Fresnel variant: the white furnace proper.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shading/brdf/specular.hpp"

namespace aluminate::brdf {

/// The scale of the lobe against gloss, pi-folded.
struct EnergyCurves {
  double gloss = 0, m = 1;
  double exact = 0;         // E(g) = (m + 2) / 8 * (-ln a / (1 - a))^2 [McAuley12]
  double m_plus_2 = 0;      // (m + 2) / 8
  double two_m_plus_1 = 0;  // (2 m + 1) / 8, the cheap variant
  double three_m = 0;       // 3 m / 8
  double cheap_error = 0;   // two_m_plus_1 / exact - 1
};
[[nodiscard]] EnergyCurves energy_curves(double gloss) noexcept;

/// Steepest line (A m + B) / 8 with A + B = 3 (3/8 at m = 1) that stays beneath E for all m >= 1, and where
/// it touches.
struct SteepestLine {
  double slope = 0, touches_at_m = 0;
};
[[nodiscard]] SteepestLine steepest_admissible_line();

/// Directional-hemispherical reflectance of the specular term, R(v) = (1/pi) int F V norm(m) (n.h)^m (n.l) dl
/// over the hemisphere, by quadrature over half vectors (dl = 4 (h.v) dh) split where l meets the horizon. m
/// >= 0, n_dot_v in [0, 1], cspec in [0, 1]. Absolute error below 1e-8 (energy_test compares with a closed
/// form and with brute force).
[[nodiscard]] double directional_albedo(double m, double n_dot_v, double cspec, Variant variant);

/// Closed form of directional_albedo at n.v = 1 for F = 1 and a constant V (norm (m + 2) / 8):
/// R = V (m + 2) (2 / (m + 4) (1 - 2^-((m + 4) / 2)) - 1 / (m + 2) (1 - 2^-((m + 2) / 2))).
[[nodiscard]] double head_on_albedo_closed_form(double m, double constant_v) noexcept;

/// Bihemispherical albedo A = 2 int_0^1 R(mu) mu dmu: the share of a uniform sky that comes back. For
/// constant V and F = 1 the mirror limit is R = V mu^2, A = V / 2.
[[nodiscard]] double bihemispherical_albedo(double m, double cspec, Variant variant);

/// A range of view angles over which R > 1, in degrees from the normal, found to 1e-4 degrees.
struct AngleRange {
  double from_deg = 0, to_deg = 0;
};

/// Where one gloss of one variant gains energy.
struct EnergyGain {
  double gloss = 0, m = 1;
  double max_albedo = 0, max_at_deg = 0;  // over the view angle, on a half-degree grid
  std::vector<AngleRange> gains;          // empty: never more out than in
};
[[nodiscard]] EnergyGain energy_gain(double gloss, double cspec, Variant variant);

/// The lowest gloss at which R exceeds 1 for some view on a 15-degree grid, to 1e-6; no value when no gloss
/// in [0, 1] does.
[[nodiscard]] std::optional<double> gain_threshold_gloss(double cspec, Variant variant);

/// One row of the furnace table.
struct FurnaceRow {
  double gloss = 0, view_deg = 0;
  Variant variant{};
  double cspec = 1, albedo = 0;
};

/// Every gloss x view (degrees from the normal, [0, 90]) x visibility, one Fresnel and cspec; visibility
/// outermost.
[[nodiscard]] std::vector<FurnaceRow> furnace_table(std::span<const double> glosses,
                                                    std::span<const double> views_deg, double cspec,
                                                    Fresnel fresnel);

/// CSV with a header line; numbers with 9 significant digits.
[[nodiscard]] std::string furnace_csv(std::span<const FurnaceRow> rows);
[[nodiscard]] std::string energy_curves_csv(std::span<const EnergyCurves> rows);

}  // namespace aluminate::brdf
