// The furnace: against a closed form, against brute force over light directions, and against the published
// findings.
#include "shading/brdf/energy.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shading/brdf/punctual.hpp"

namespace aluminate::brdf {
namespace {

constexpr double kPi = std::numbers::pi;
double cos_deg(double degrees) { return std::cos(degrees * kPi / 180.0); }

TEST(Furnace, HeadOnMatchesTheClosedFormForEveryConstantVisibility) {
  for (const VisibilityTerm& row : kVisibilityTerms) {
    if (!row.constant) continue;
    for (const double m : {0.0, 1.0, 2.7, 60.0, 700.0, 8192.0}) {
      const double v = row.visibility(m, 1, 1) * row.norm(m) / norm_m_plus_2(m);
      EXPECT_NEAR(directional_albedo(m, 1.0, 1.0, {row.id, Fresnel::Schlick}),
                  head_on_albedo_closed_form(m, v), 1e-8);
    }
  }
}

// Midpoint rule over light directions, nothing in common with the half-vector quadrature but the BRDF.
double brute_force_albedo(double m, double n_dot_v, double cspec, Variant variant) {
  const glm::dvec3 n(0, 0, 1), v(std::sqrt(1.0 - n_dot_v * n_dot_v), 0, n_dot_v);
  constexpr int kPolar = 800, kAzimuth = 800;
  double sum = 0.0;
  for (int i = 0; i < kPolar; ++i) {
    const double mu = (i + 0.5) / kPolar, s = std::sqrt(1.0 - mu * mu);
    for (int j = 0; j < kAzimuth; ++j) {
      const double phi = kPi * (j + 0.5) / kAzimuth;
      const glm::dvec3 l(s * std::cos(phi), s * std::sin(phi), mu);
      sum += specular_from_power(m, cosines(n, l, v), cspec, variant) * mu;
    }
  }
  return sum * 2.0 / (kPolar * static_cast<double>(kAzimuth));  // (1/pi) * pi * 2 / (N M)
}

TEST(Furnace, MatchesBruteForceOverLightDirections) {
  for (const VisibilityTerm& visibility : kVisibilityTerms)
    for (const Fresnel fresnel_id : {Fresnel::Schlick, Fresnel::SgLagarde})
      for (const double m : {1.0, 25.0})
        for (const double n_dot_v : {0.97, 0.5, 0.1}) {
          const Variant variant{visibility.id, fresnel_id};
          const double expected = brute_force_albedo(m, n_dot_v, 0.04, variant);
          // Midpoint error of the 800 x 800 grid on these smooth lobes is of order (1 / 800)^2 = 1.6e-6
          // relative.
          EXPECT_NEAR(directional_albedo(m, n_dot_v, 0.04, variant), expected, 4e-6 * (1.0 + expected));
        }
}

struct PublishedRow {
  Visibility visibility;
  double at_deg[5];  // 0, 45, 60, 75, 85
  double bihemispherical;
};

TEST(Furnace, HighGlossTableOfTheSources) {
  const PublishedRow rows[] = {
      {Visibility::None, {.9995, .500, .250, .067, .0078}, .4999},
      {Visibility::SchlickSmith, {1.0000, .990, .975, .932, .779}, .9775},
      {Visibility::Integrated, {19.71, 9.86, 4.93, 1.32, .154}, 9.86},
      {Visibility::Cheap, {1.999, .9996, .500, .134, .0157}, .9996},
  };
  const double views_deg[] = {0, 45, 60, 75, 85};
  const auto last_digit = [](double x) { return x >= 1.0 ? 5.1e-3 : 5.1e-4; };  // the table's rounding
  for (const PublishedRow& row : rows) {
    for (int i = 0; i < 5; ++i)
      EXPECT_NEAR(directional_albedo(8192.0, cos_deg(views_deg[i]), 1.0, {row.visibility, {}}), row.at_deg[i],
                  last_digit(row.at_deg[i]))
          << to_string(row.visibility) << ' ' << views_deg[i];
    EXPECT_NEAR(bihemispherical_albedo(8192.0, 1.0, {row.visibility, {}}), row.bihemispherical,
                last_digit(row.bihemispherical));
  }
}

// Composite five-point Gauss-Legendre with sin^2 grading towards both ends, where the integrand has square
// roots.
template <class Function>
double gauss_legendre(const Function& f, double a, double b, int panels) {
  constexpr double kNodes[] = {0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr double kWeights[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  double sum = 0.0;
  const double width = kPi / 2.0 / panels;
  const auto add = [&](double u, double weight) {
    sum += weight * 0.5 * width * (b - a) * std::sin(2.0 * u) * f(a + (b - a) * std::sin(u) * std::sin(u));
  };
  for (int i = 0; i < panels; ++i) {
    const double middle = (i + 0.5) * width;
    add(middle, kWeights[0]);
    for (int k = 1; k < 3; ++k) {
      add(middle - 0.5 * width * kNodes[k], kWeights[k]);
      add(middle + 0.5 * width * kNodes[k], kWeights[k]);
    }
  }
  return sum;
}

TEST(Furnace, HighGlossAgreesWithAnotherQuadratureRule) {
  const double m = 8192.0;
  for (const Visibility visibility : {Visibility::SchlickSmith, Visibility::Integrated})
    for (const double view_deg : {0.0, 45.0, 60.0, 75.0, 85.0, 89.5}) {
      const double v = view_deg * kPi / 180.0, cos_v = std::cos(v), sin_v = std::sin(v);
      const auto ring = [&](double t) {
        const double across = sin_v * std::sin(2.0 * t), along = cos_v * std::cos(2.0 * t);
        if (across + along <= 0.0) return 0.0;
        const double last = along < across ? std::acos(-along / across) : kPi;
        const auto arc = [&](double p) {
          const double h_dot_v = sin_v * std::sin(t) * std::cos(p) + cos_v * std::cos(t);
          const double n_dot_l = std::max(0.0, 2.0 * h_dot_v * std::cos(t) - cos_v);
          return scaled_visibility(visibility, m, n_dot_l, cos_v) * n_dot_l * h_dot_v;
        };
        return std::pow(std::cos(t), m) * std::sin(t) * gauss_legendre(arc, 0.0, last, 60);
      };
      const double split = 0.5 * (kPi / 2.0 - v), end = 0.5 * (kPi / 2.0 + v),
                   reach = 0.11;  // cos(0.11)^8192 = 2e-22
      const double expected = 8.0 / kPi *
                              (gauss_legendre(ring, 0.0, std::min(split, reach), 60) +
                               gauss_legendre(ring, std::min(split, reach), std::min(end, reach), 60));
      EXPECT_NEAR(directional_albedo(m, cos_v, 1.0, {visibility, {}}), expected, 1e-8)
          << view_deg;  // the promise
    }
}

TEST(Furnace, MirrorLimitOfAConstantVisibilityIsVTimesCosineSquared) {
  for (const double mu : {0.2, 0.6, 1.0})
    EXPECT_NEAR(directional_albedo(8192.0, mu, 1.0, {Visibility::None, {}}), mu * mu,
                6e-4);  // first order 4 / m
}

TEST(Furnace, SchlickSmithAndNoneNeverGainEnergy) {
  for (const Visibility visibility : {Visibility::SchlickSmith, Visibility::None})
    for (const double g : {0.0, 0.125, 0.25, 0.5, 0.75, 1.0})
      for (const double view_deg : {0.0, 30.0, 60.0, 80.0, 88.0, 90.0})
        EXPECT_LE(directional_albedo(power_from_gloss(g), cos_deg(view_deg), 1.0, {visibility, {}}),
                  1.0 + 1e-8);
}

TEST(Furnace, NothingGainsEnergyAtFourPercent) {
  for (const VisibilityTerm& row : kVisibilityTerms)
    for (const double g : {0.0, 0.5, 1.0})
      for (const double view_deg : {0.0, 60.0, 85.0})
        EXPECT_LT(directional_albedo(power_from_gloss(g), cos_deg(view_deg), 0.04, {row.id, {}}), 0.79);
  EXPECT_NEAR(directional_albedo(8192.0, 1.0, 0.04, {Visibility::Integrated, {}}), 0.788, 5e-4);
}

TEST(Furnace, EnergyGainStartsBetweenAnEighthAndAQuarterOfGloss) {
  for (const Visibility visibility : {Visibility::Integrated, Visibility::Cheap}) {
    const auto gloss = gain_threshold_gloss(1.0, {visibility, {}});
    ASSERT_TRUE(gloss);
    EXPECT_GT(*gloss, 0.125);
    EXPECT_LT(*gloss, 0.25);
    // Head on decides: there the closed form must cross 1 at the same gloss.
    const double m = power_from_gloss(*gloss);
    const VisibilityTerm& row = term(visibility);
    const double v = row.visibility(m, 1, 1) * row.norm(m) / norm_m_plus_2(m);
    EXPECT_NEAR(head_on_albedo_closed_form(m, v), 1.0, 2e-5);  // 1e-6 of gloss times dR/dg of about 10
  }
  EXPECT_FALSE(gain_threshold_gloss(1.0, {Visibility::None, {}}));
  EXPECT_FALSE(gain_threshold_gloss(0.04, {Visibility::Cheap, {}}));
}

TEST(Furnace, AnglesOfGainMatchThePublishedRanges) {
  const EnergyGain integrated = energy_gain(1.0, 1.0, {Visibility::Integrated, {}});
  ASSERT_EQ(integrated.gains.size(), 1u);
  EXPECT_EQ(integrated.gains[0].from_deg, 0.0);
  EXPECT_NEAR(integrated.gains[0].to_deg, 77.0, 0.5);
  EXPECT_NEAR(integrated.max_albedo, 19.705, 1e-3);
  EXPECT_EQ(integrated.max_at_deg, 0.0);
  const EnergyGain cheap = energy_gain(0.6, 1.0, {Visibility::Cheap, {}});
  ASSERT_EQ(cheap.gains.size(), 1u);
  EXPECT_NEAR(cheap.gains[0].to_deg, 44.5, 0.1);
  EXPECT_TRUE(energy_gain(0.5, 1.0, {Visibility::SchlickSmith, {}}).gains.empty());
}

TEST(Furnace, ConstantVisibilityOfEqualEnergyToSchlickSmith) {
  const auto constant = [](double gloss, double cspec) {
    const double m = power_from_gloss(gloss);
    return bihemispherical_albedo(m, cspec, {Visibility::SchlickSmith, {}}) /
           bihemispherical_albedo(m, cspec, {Visibility::None, {}});
  };
  EXPECT_NEAR(constant(0.0, 1.0), 1.277, 5.1e-4);  // published to these digits
  EXPECT_NEAR(constant(1.0, 1.0), 1.956, 5.1e-4);
  EXPECT_NEAR(constant(0.0, 0.04), 1.31, 5.1e-3);
  EXPECT_NEAR(constant(1.0, 0.04), 3.34, 5.1e-3);
}

TEST(EnergyCurves, CheapErrorAgainstTheIntegratedCurve) {
  // Published to a tenth of a percent.
  EXPECT_NEAR(energy_curves(0.0).cheap_error, -0.338, 6e-4);
  EXPECT_NEAR(energy_curves(0.109).cheap_error, -0.266, 6e-4);
  EXPECT_NEAR(energy_curves(0.25).cheap_error, -0.36, 6e-3);
  EXPECT_NEAR(energy_curves(0.5).cheap_error, -0.67, 6e-3);
  EXPECT_NEAR(energy_curves(0.75).cheap_error, -0.83, 6e-3);
  EXPECT_NEAR(energy_curves(1.0).cheap_error, -0.899, 6e-4);
}

TEST(EnergyCurves, EveryComparedLineStaysBeneathTheIntegratedCurve) {
  for (int i = 0; i <= 1000; ++i) {
    const EnergyCurves c = energy_curves(i / 1000.0);
    EXPECT_LT(c.m_plus_2, c.exact);
    EXPECT_LT(c.two_m_plus_1, c.exact);
    EXPECT_LT(c.three_m, c.exact);
  }
}

TEST(EnergyCurves, SteepestLineThroughThreeEighthsTouchesOnce) {
  const SteepestLine line = steepest_admissible_line();
  EXPECT_NEAR(line.slope, 3.11238, 5e-6);
  EXPECT_NEAR(line.touches_at_m, 4.757, 1e-3);
  const auto crosses = [](double slope) {
    for (double m = 1.0; m < 9000.0; m *= 1.001)
      if ((slope * m + 3.0 - slope) / 8.0 > norm_m_plus_2(m) * visibility_integrated(m, 0, 0)) return true;
    return false;
  };
  EXPECT_FALSE(crosses(line.slope - 1e-9));
  EXPECT_TRUE(crosses(line.slope + 1e-4));
  EXPECT_TRUE(crosses(4.0));
}

TEST(FurnaceTable, HasOneRowPerCombinationAndOneLinePerRow) {
  const double glosses[] = {0.0, 1.0}, views[] = {0.0, 60.0, 90.0};
  const auto rows = furnace_table(glosses, views, 1.0, Fresnel::Sg);
  ASSERT_EQ(rows.size(), 24u);
  EXPECT_EQ(rows[4].gloss, 1.0);
  EXPECT_EQ(rows[4].view_deg, 60.0);
  const std::string csv = furnace_csv(rows);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 25);
  EXPECT_EQ(csv.substr(csv.find('\n') + 1, 17), "none,sg,1,0,0,0.3");
}

}  // namespace
}  // namespace aluminate::brdf
