// A whole point under lights: units, the light list, edge geometry, falloff.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "shading/brdf/attenuation.hpp"
#include "shading/brdf/punctual.hpp"

namespace aluminate::brdf {
namespace {

TEST(Punctual, WhiteLambertFacingTheLightReturnsTheLightsColour) {
  SurfacePoint white;
  white.cdiff = glm::dvec3(1.0);
  white.m = 8192.0;
  const std::vector<IncidentLight> lights{{{0, 0, 1}, {0.25, 0.5, 2.0}}};
  // Eye at 90 degrees so that the highlight is nothing: 0.707^8192 underflows.
  white.to_eye = {1, 0, 0};
  EXPECT_EQ(outgoing_radiance(white, lights, {}), glm::dvec3(0.25, 0.5, 2.0));
}

TEST(Punctual, HeadOnSpecularIsCspecTimesTheNormalisation) {
  SurfacePoint metal;
  metal.cspec = {0.9, 0.5, 0.1};
  metal.m = 30.0;
  const std::vector<IncidentLight> lights{{{0, 0, 1}, {2, 2, 2}}};
  const glm::dvec3 lo = outgoing_radiance(metal, lights, {Visibility::SchlickSmith, Fresnel::Schlick});
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(lo[i], 2.0 * metal.cspec[i] * 32.0 / 8.0, 1e-14);
  const glm::dvec3 cheap = outgoing_radiance(metal, lights, {Visibility::Cheap, Fresnel::Schlick});
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(cheap[i], 2.0 * metal.cspec[i] * 61.0 / 8.0, 1e-14);
}

TEST(Punctual, SumsLightsAndAddsAmbientUnderOcclusionAndEmission) {
  SurfacePoint s;
  s.cdiff = {0.5, 0.25, 0.125};
  s.cspec = glm::dvec3(0.04);
  s.emissive = {0, 0, 1};
  s.occlusion = 0.5;
  s.m = 100.0;
  const IncidentLight a{glm::normalize(glm::dvec3(1, 0, 1)), {1, 2, 3}},
      b{glm::normalize(glm::dvec3(0, -1, 2)), {3, 1, 0}};
  const std::vector<IncidentLight> both{a, b};
  const glm::dvec3 ambient(0.2);
  const glm::dvec3 expected =
      light_radiance(s, a, {}) + light_radiance(s, b, {}) + s.emissive + 0.5 * ambient * (s.cdiff + s.cspec);
  const glm::dvec3 lo = outgoing_radiance(s, both, {}, ambient);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(lo[i], expected[i], 1e-15);
}

TEST(Punctual, OneLightEqualsTheScalarSpecularPerChannel) {
  SurfacePoint s;
  s.cdiff = glm::dvec3(0.3);
  s.cspec = {0.04, 0.5, 1.0};
  s.m = power_from_gloss(0.6);
  s.to_eye = glm::normalize(glm::dvec3(-0.3, 0.2, 1));
  const IncidentLight light{glm::normalize(glm::dvec3(0.5, 0.1, 1)), {1, 1, 1}};
  for (const VisibilityTerm& visibility : kVisibilityTerms)
    for (const FresnelTerm& row : kFresnelTerms) {
      const Variant variant{visibility.id, row.id};
      const Cosines c = cosines(s.normal, light.to_light, s.to_eye);
      const glm::dvec3 lo = light_radiance(s, light, variant);
      for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(lo[i], c.n_dot_l * (0.3 + specular(0.6, c, s.cspec[i], variant)), 1e-13 * lo[i]);
    }
}

TEST(Punctual, LightBelowTheHorizonAddsNothingEvenWithAHighlightAbove) {
  SurfacePoint s;
  s.cdiff = glm::dvec3(1.0);
  s.cspec = glm::dvec3(1.0);
  const IncidentLight below{glm::normalize(glm::dvec3(1, 0, -0.01)), {1e6, 1e6, 1e6}};
  EXPECT_EQ(light_radiance(s, below, {}), glm::dvec3(0.0));
}

TEST(Punctual, LightOppositeTheEyeIsFiniteWithoutHighlight) {
  SurfacePoint s;
  s.cspec = glm::dvec3(1.0);
  s.to_eye = {0, 0, -1};
  const glm::dvec3 lo = light_radiance(s, {{0, 0, 1}, {1, 1, 1}}, {});
  EXPECT_EQ(lo, glm::dvec3(0.0));
}

TEST(Attenuation, RigFallsToAFifthAtTheSceneRadius) {
  EXPECT_EQ(rig_attenuation(0.0, 3.0), 1.0);
  EXPECT_NEAR(rig_attenuation(9.0, 3.0), 0.2, 1e-16);
}

TEST(Attenuation, RangeWindowReachesZeroAtTheRangeAndIsInverseSquareWithout) {
  EXPECT_EQ(range_attenuation(4.0, 0.0), 0.25);
  EXPECT_EQ(range_attenuation(4.0, 2.0), 0.0);
  EXPECT_EQ(range_attenuation(9.0, 2.0), 0.0);
  EXPECT_NEAR(range_attenuation(1.0, 2.0), 1.0 - 1.0 / 16.0, 1e-15);
  EXPECT_DOUBLE_EQ(range_attenuation(0.0, 0.0), 1e5);  // 1e-5 is not a binary64 number
}

TEST(Attenuation, SpotIsOneInsideTheInnerConeAndZeroOutsideTheOuter) {
  EXPECT_EQ(spot_attenuation(std::cos(0.1), 0.2, 0.5), 1.0);
  EXPECT_EQ(spot_attenuation(std::cos(0.6), 0.2, 0.5), 0.0);
  const double half = 0.5 * (std::cos(0.2) + std::cos(0.5));
  EXPECT_NEAR(spot_attenuation(half, 0.2, 0.5), 0.25, 1e-14);
}

}  // namespace
}  // namespace aluminate::brdf
