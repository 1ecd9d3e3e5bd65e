#include "shading/brdf/energy.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>

#include "shading/brdf/quadrature.hpp"

namespace aluminate::brdf {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180.0;

double exact_energy(double m) noexcept { return norm_m_plus_2(m) * visibility_integrated(m, 0, 0); }

}  // namespace

EnergyCurves energy_curves(double gloss) noexcept {
  EnergyCurves c;
  c.gloss = gloss;
  c.m = power_from_gloss(gloss);
  c.exact = exact_energy(c.m);
  c.m_plus_2 = norm_m_plus_2(c.m);
  c.two_m_plus_1 = norm_2m_plus_1(c.m);
  c.three_m = norm_3m(c.m);
  c.cheap_error = c.two_m_plus_1 / c.exact - 1.0;
  return c;
}

SteepestLine steepest_admissible_line() {
  // The chord from (1, 3/8) to (m, E(m)) has slope (8 E(m) - 3) / (m - 1) in eighths; the smallest is the
  // tangent. It falls from m = 1 to one minimum and rises after it, so golden-section search in m finds it.
  const auto slope = [](double m) { return (8.0 * exact_energy(m) - 3.0) / (m - 1.0); };
  constexpr double kGolden = 1.0 / std::numbers::phi;
  double low = 1.01, high = 100.0;
  for (int i = 0; i < 80; ++i) {
    const double x1 = high - (high - low) * kGolden;
    const double x2 = low + (high - low) * kGolden;
    (slope(x1) < slope(x2) ? high : low) = slope(x1) < slope(x2) ? x2 : x1;
  }
  const double m = 0.5 * (low + high);
  return {slope(m), m};
}

double directional_albedo(double m, double n_dot_v, double cspec, Variant variant) {
  const double cos_v = clamped(n_dot_v);
  const double view = std::acos(cos_v);
  const double sin_v = std::sqrt((1.0 - cos_v) * (1.0 + cos_v));

  // h = (sin t cos p, sin t sin p, cos t), v in the plane p = 0. Then n.l = 2 (h.v) cos t - cos v, and n.l >
  // 0 is cos p > -cos v cos 2t / (sin v sin 2t): all p while t < (pi/2 - v) / 2, none once t > (pi/2 + v)
  // / 2.
  const auto over_azimuth = [&](double theta) {
    const double cos_t = std::cos(theta), sin_t = std::sin(theta);
    const double across = sin_v * std::sin(2.0 * theta), along = cos_v * std::cos(2.0 * theta);
    double last = kPi;
    if (across + along <= 0.0) return 0.0;
    if (along < across) last = std::acos(std::min(1.0, -along / across));
    return integrate(
        [&](double phi) {
          const double h_dot_v = sin_v * sin_t * std::cos(phi) + cos_v * cos_t;
          const double n_dot_l = 2.0 * h_dot_v * cos_t - cos_v;
          if (n_dot_l <= 0.0) return 0.0;  // rounding at the end of the arc
          return fresnel(variant.fresnel, cspec, h_dot_v) *
                 term(variant.visibility).visibility(m, n_dot_l, cos_v) * n_dot_l * h_dot_v;
        },
        0.0, last, 1e-11);
  };
  const auto integrand = [&](double theta) {
    return blinn_phong_lobe(m, std::cos(theta)) * std::sin(theta) * over_azimuth(theta);
  };
  // (1/pi) norm 4 int int, twice half the azimuth. Where the lobe is below e^-46 of its peak nothing is left
  // to add.
  const double reach = m > 0.0 ? std::acos(std::exp(-46.0 / m)) : kPi / 2.0;
  const double full = std::min(0.5 * (kPi / 2.0 - view), reach);
  const double part = std::min(0.5 * (kPi / 2.0 + view), reach);
  const double scale = 8.0 / kPi * term(variant.visibility).norm(m);
  return scale *
         (integrate(integrand, 0.0, full, 1e-10 / scale) + integrate(integrand, full, part, 1e-10 / scale));
}

double head_on_albedo_closed_form(double m, double constant_v) noexcept {
  return constant_v * (m + 2.0) *
         (2.0 / (m + 4.0) * (1.0 - std::exp2(-0.5 * (m + 4.0))) -
          1.0 / (m + 2.0) * (1.0 - std::exp2(-0.5 * (m + 2.0))));
}

double bihemispherical_albedo(double m, double cspec, Variant variant) {
  return 2.0 *
         integrate([&](double mu) { return directional_albedo(m, mu, cspec, variant) * mu; }, 0.0, 1.0, 1e-8);
}

EnergyGain energy_gain(double gloss, double cspec, Variant variant) {
  EnergyGain result;
  result.gloss = gloss;
  result.m = power_from_gloss(gloss);
  const auto albedo = [&](double view_deg) {
    return directional_albedo(result.m, std::cos(view_deg * kDegree), cspec, variant);
  };
  const auto crossing = [&](double below_deg, double above_deg) {  // R <= 1 at the first, R > 1 at the second
    while (std::fabs(above_deg - below_deg) > 1e-4) {
      const double middle = 0.5 * (below_deg + above_deg);
      (albedo(middle) > 1.0 ? above_deg : below_deg) = middle;
    }
    return above_deg;
  };
  constexpr int kSteps = 180;
  bool gaining = false;
  for (int i = 0; i <= kSteps; ++i) {
    const double view_deg = 90.0 * i / kSteps;
    const double r = albedo(view_deg);
    if (i == 0 || r > result.max_albedo) result.max_albedo = r, result.max_at_deg = view_deg;
    const bool gains = r > 1.0;
    const double previous_deg = 90.0 * (i - 1) / kSteps;
    if (gains && !gaining) result.gains.push_back({i == 0 ? 0.0 : crossing(previous_deg, view_deg), 90.0});
    if (!gains && gaining) result.gains.back().to_deg = crossing(view_deg, previous_deg);
    gaining = gains;
  }
  return result;
}

std::optional<double> gain_threshold_gloss(double cspec, Variant variant) {
  const auto most = [&](double gloss) {
    const double m = power_from_gloss(gloss);
    double best = 0.0;
    for (int view_deg = 0; view_deg <= 90; view_deg += 15)
      best = std::max(best, directional_albedo(m, std::cos(view_deg * kDegree), cspec, variant));
    return best;
  };
  constexpr int kSteps = 32;
  for (int i = 0; i <= kSteps; ++i) {
    double above = static_cast<double>(i) / kSteps;
    if (most(above) <= 1.0) continue;
    if (i == 0) return 0.0;
    double below = static_cast<double>(i - 1) / kSteps;
    while (above - below > 1e-6) {
      const double middle = 0.5 * (below + above);
      (most(middle) > 1.0 ? above : below) = middle;
    }
    return above;
  }
  return std::nullopt;
}

std::vector<FurnaceRow> furnace_table(std::span<const double> glosses, std::span<const double> views_deg,
                                      double cspec, Fresnel fresnel) {
  std::vector<FurnaceRow> rows;
  rows.reserve(kVisibilityTerms.size() * glosses.size() * views_deg.size());
  for (const VisibilityTerm& visibility : kVisibilityTerms)
    for (const double gloss : glosses)
      for (const double view_deg : views_deg) {
        const Variant variant{visibility.id, fresnel};
        const double m = power_from_gloss(gloss);
        rows.push_back({gloss, view_deg, variant, cspec,
                        directional_albedo(m, std::cos(view_deg * kDegree), cspec, variant)});
      }
  return rows;
}

std::string furnace_csv(std::span<const FurnaceRow> rows) {
  std::string csv = "visibility,fresnel,cspec,gloss,view_deg,albedo\n";
  char line[160];
  for (const FurnaceRow& row : rows) {
    const std::string_view visibility = to_string(row.variant.visibility),
                           fresnel = to_string(row.variant.fresnel);
    std::snprintf(line, sizeof line, "%.*s,%.*s,%.9g,%.9g,%.9g,%.9g\n", static_cast<int>(visibility.size()),
                  visibility.data(), static_cast<int>(fresnel.size()), fresnel.data(), row.cspec, row.gloss,
                  row.view_deg, row.albedo);
    csv += line;
  }
  return csv;
}

std::string energy_curves_csv(std::span<const EnergyCurves> rows) {
  std::string csv = "gloss,m,exact,m_plus_2_over_8,2m_plus_1_over_8,3m_over_8,cheap_relative_error\n";
  char line[200];
  for (const EnergyCurves& row : rows) {
    std::snprintf(line, sizeof line, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", row.gloss, row.m, row.exact,
                  row.m_plus_2, row.two_m_plus_1, row.three_m, row.cheap_error);
    csv += line;
  }
  return csv;
}

}  // namespace aluminate::brdf
