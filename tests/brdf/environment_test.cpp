// The shader's one-line environment reflectance against the integral it stands for.
#include "shading/brdf/environment.hpp"

#include <gtest/gtest.h>

#include "shading/brdf/energy.hpp"

namespace aluminate::brdf {
namespace {

double worst_error(double cspec, double least_n_dot_v, int least_gloss_5) {
  double worst = 0;
  for (int g = least_gloss_5; g <= 5; ++g)
    for (double n_dot_v = least_n_dot_v; n_dot_v <= 1; n_dot_v += 0.15) {
      const double gloss = g / 5.0;
      const double exact = directional_albedo(std::exp2(13 * gloss), n_dot_v, cspec,
                                              {Visibility::SchlickSmith, Fresnel::Schlick});
      worst = std::max(worst, std::abs(environment_reflectance(gloss, n_dot_v, cspec) - exact));
    }
  return worst;
}

TEST(EnvironmentReflectance, StaysNearTheIntegral) {
  EXPECT_LT(worst_error(0.04, 0.05, 0), 0.05);
  EXPECT_LT(worst_error(1.0, 0.5, 3), 0.12);
}

TEST(EnvironmentReflectance, KeepsOfMetalsWhatSchlickSmithLoses) {
  const double lost =
      directional_albedo(std::exp2(13 * 0.6), 0.05, 1.0, {Visibility::SchlickSmith, Fresnel::Schlick});
  EXPECT_NEAR(lost, 0.316, 1e-3);
  EXPECT_NEAR(environment_reflectance(0.6, 0.05, 1.0), 0.9, 1e-12);
}

}  // namespace
}  // namespace aluminate::brdf
