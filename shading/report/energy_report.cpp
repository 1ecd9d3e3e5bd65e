#include "shading/report/energy_report.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "platform/host/text_table.hpp"
#include "shading/brdf/energy.hpp"

namespace aluminate::report {
namespace {

constexpr std::array kGlosses{0.0, 0.25, 0.5, 0.75, 1.0};
constexpr std::array kViewsDeg{0.0, 45.0, 60.0, 75.0, 85.0};

std::string gain_sentence(const brdf::VisibilityTerm& term, double cspec, brdf::Fresnel fresnel) {
  const brdf::Variant variant{term.id, fresnel};
  const auto threshold = brdf::gain_threshold_gloss(cspec, variant);
  if (!threshold) return fmt::format("{}: never returns more than it receives\n", term.name);
  const brdf::EnergyGain gain = brdf::energy_gain(1.0, cspec, variant);
  const double to = gain.gains.empty() ? 0.0 : gain.gains.back().to_deg;
  return fmt::format(
      "{}: gains energy from gloss {:.3f} up; at gloss 1 up to {:.1f} degrees from the normal, {:.2f} times "
      "what arrives at worst\n",
      term.name, *threshold, to, gain.max_albedo);
}

}  // namespace

std::string energy_text(double cspec, brdf::Fresnel fresnel) {
  using host::Align;
  host::TextTable curves({{"gloss"},
                          {"m", Align::Right},
                          {"E exact", Align::Right},
                          {"(m+2)/8", Align::Right},
                          {"(2m+1)/8", Align::Right},
                          {"3m/8", Align::Right},
                          {"cheap error", Align::Right}});
  for (int i = 0; i <= 8; ++i) {
    const brdf::EnergyCurves row = brdf::energy_curves(i / 8.0);
    curves.add_row({fmt::format("{:.3f}", row.gloss), fmt::format("{:.1f}", row.m),
                    fmt::format("{:.4f}", row.exact), fmt::format("{:.4f}", row.m_plus_2),
                    fmt::format("{:.4f}", row.two_m_plus_1), fmt::format("{:.4f}", row.three_m),
                    fmt::format("{:+.1f} %", 100 * row.cheap_error)});
  }
  host::TextTable furnace({{fmt::format("reflectance, cspec {}", cspec)},
                           {"gloss", Align::Right},
                           {"0 deg", Align::Right},
                           {"45", Align::Right},
                           {"60", Align::Right},
                           {"75", Align::Right},
                           {"85", Align::Right},
                           {"uniform sky", Align::Right}});
  std::string sentences;
  for (const brdf::VisibilityTerm& term : brdf::kVisibilityTerms) {
    for (const double gloss : kGlosses) {
      const double m = brdf::power_from_gloss(gloss);
      std::vector<std::string> cells{std::string(term.name), fmt::format("{}", gloss)};
      for (const double view : kViewsDeg)
        cells.push_back(fmt::format(
            "{:.4f}",
            brdf::directional_albedo(m, std::cos(view * std::numbers::pi / 180), cspec, {term.id, fresnel})));
      cells.push_back(fmt::format("{:.4f}", brdf::bihemispherical_albedo(m, cspec, {term.id, fresnel})));
      furnace.add_row(std::move(cells));
    }
    sentences += gain_sentence(term, cspec, fresnel);
  }
  return curves.text() + "\n" + furnace.text() + "\n" + sentences;
}

std::string energy_csv() {
  std::vector<brdf::EnergyCurves> rows;
  for (int i = 0; i <= 64; ++i) rows.push_back(brdf::energy_curves(i / 64.0));
  return brdf::energy_curves_csv(rows);
}

}  // namespace aluminate::report
