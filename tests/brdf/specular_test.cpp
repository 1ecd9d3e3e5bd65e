// The product of the terms: against an independent spelling over a grid, and its symmetries and limits.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/glm.hpp>
#include <limits>

#include "shading/brdf/punctual.hpp"
#include "shading/brdf/specular.hpp"

namespace aluminate::brdf {
namespace {

// The contract's formulas once more, in long double and in one piece, from other algebra: a from the Beckmann
// roughness, powers through exp and log, Schlick through pow.
long double second_opinion(double g, const Cosines& c, double cspec, Visibility visibility, Fresnel variant) {
  const long double pi = acosl(-1.0L);
  const long double m = powl(8192.0L, g);
  const long double a = sqrtl(2.0L / (m + 2.0L)) * sqrtl(2.0L / pi);
  const auto mixed = [&](long double x) { return a + x - a * x; };
  long double v_norm = 0.0L;
  switch (visibility) {
    case Visibility::None:
      v_norm = 0.125L * m + 0.25L;
      break;
    case Visibility::SchlickSmith:
      v_norm = (0.125L * m + 0.25L) / mixed(c.n_dot_l) / mixed(c.n_dot_v);
      break;
    case Visibility::Integrated:
      v_norm = (0.125L * m + 0.25L) * powl(logl(a) / (1.0L - a), 2.0L);
      break;
    case Visibility::Cheap:
      v_norm = 0.25L * m + 0.125L;
      break;
  }
  const long double x = c.h_dot_v;
  long double w = 0.0L;
  switch (variant) {
    case Fresnel::Schlick:
      w = powl(1.0L - x, 5.0L);
      break;
    case Fresnel::Sg:
      w = expl(-6.0L * x);
      break;
    case Fresnel::SgLagarde:
      w = exp2l(-5.55473L * x * x - 6.98316L * x);
      break;
  }
  const long double lobe = c.n_dot_h > 0.0 ? expl(m * logl(c.n_dot_h)) : 0.0L;
  return (cspec * (1.0L - w) + w) * v_norm * lobe;
}

TEST(Specular, EqualsASecondSpellingOverAGrid) {
  for (const VisibilityTerm& visibility : kVisibilityTerms)
    for (const FresnelTerm& fresnel_row : kFresnelTerms)
      for (const double g : {0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0})
        for (const double n_dot_l : {0.0, 0.05, 0.5, 1.0})
          for (const double n_dot_v : {0.0, 0.3, 1.0})
            for (const double n_dot_h : {0.0, 0.2, 0.7, 0.99, 0.9999, 1.0})
              for (const double h_dot_v : {0.0, 0.4, 0.97, 1.0})
                for (const double cspec : {0.0, 0.04, 1.0}) {
                  const Cosines c{n_dot_l, n_dot_v, n_dot_h, h_dot_v};
                  const double value = specular(g, c, cspec, {visibility.id, fresnel_row.id});
                  const double expected =
                      static_cast<double>(second_opinion(g, c, cspec, visibility.id, fresnel_row.id));
                  // exp2(13 g) carries a relative error of 13 g ln2 2^-53 into the exponent of the lobe,
                  // which multiplies it by m |ln n.h| <= 745 before underflow: 745 * 9.01 * 1.1e-16 < 1e-12.
                  EXPECT_NEAR(value, expected, 1e-12 * (std::fabs(expected) + 1e-300))
                      << visibility.name << ' ' << fresnel_row.name << " g=" << g << " nl=" << n_dot_l
                      << " nv=" << n_dot_v << " nh=" << n_dot_h << " hv=" << h_dot_v << " c=" << cspec;
                }
}

TEST(Specular, IsFiniteAndNotNegativeAtEveryCornerOfItsDomain) {
  const double cosines[] = {-1.0, -1e-300, 0.0,         1e-300,
                            0.5,  1.0,     1.0 + 1e-12, std::numeric_limits<double>::quiet_NaN()};
  for (const VisibilityTerm& visibility : kVisibilityTerms)
    for (const FresnelTerm& fresnel_row : kFresnelTerms)
      for (const double m : {0.0, 1e-300, 1.0, 8192.0})
        for (const double nl : cosines)
          for (const double nv : cosines)
            for (const double nh : cosines)
              for (const double hv : cosines)
                for (const double cspec : {0.0, 1.0}) {
                  const double value =
                      specular_from_power(m, {nl, nv, nh, hv}, cspec, {visibility.id, fresnel_row.id});
                  EXPECT_TRUE(std::isfinite(value) && value >= 0.0) << visibility.name << " m=" << m;
                }
}

TEST(Specular, LargestValueExceedsAHalfFloat) {
  const double most = specular(1.0, {0.0, 0.0, 1.0, 0.0}, 1.0, {});
  EXPECT_NEAR(most, 6.59e6, 0.01e6);
  EXPECT_GT(most, 65504.0);
}

TEST(Specular, IsReciprocal) {
  const glm::dvec3 n(0, 0, 1);
  for (const VisibilityTerm& visibility : kVisibilityTerms)
    for (int i = 0; i < 200; ++i) {
      const double u = std::fmod(0.618033988749895 * i, 1.0), w = std::fmod(0.754877666246693 * i, 1.0);
      const glm::dvec3 l = glm::normalize(glm::dvec3(std::cos(6.3 * u), std::sin(6.3 * u), 0.02 + 2.0 * w));
      const glm::dvec3 v = glm::normalize(glm::dvec3(std::cos(5.0 * w), std::sin(9.0 * u), 0.01 + 1.5 * u));
      const double forward = specular(0.4, cosines(n, l, v), 0.04, {visibility.id, Fresnel::Schlick});
      const double backward = specular(0.4, cosines(n, v, l), 0.04, {visibility.id, Fresnel::Schlick});
      EXPECT_NEAR(forward, backward, 1e-13 * forward);  // h.v and h.l round differently
    }
}

TEST(Specular, CheapVisibilityAgainstSchlickSmithTendsToTwiceTheProductOfCosines) {
  for (const double nl : {0.2, 0.5, 1.0})
    for (const double nv : {0.2, 0.5, 1.0}) {
      const double cheap = scaled_visibility(Visibility::Cheap, 1e12, nl, nv);
      const double full = scaled_visibility(Visibility::SchlickSmith, 1e12, nl, nv);
      EXPECT_NEAR(cheap / full, 2.0 * nl * nv, 1e-4);  // a(1e12) = 1.1e-6, over nl >= 0.2
    }
}

}  // namespace
}  // namespace aluminate::brdf
