// glTF factors to BRDF terms, and the sRGB curve.
#include <gtest/gtest.h>

#include <cmath>

#include "shading/brdf/material.hpp"
#include "shading/brdf/srgb.hpp"

namespace aluminate::brdf {
namespace {

TEST(Material, RoughnessMapsToTheWholeRangeOfPowers) {
  EXPECT_EQ(power_from_roughness(0.0), 8192.0);
  EXPECT_EQ(power_from_roughness(1.0), 1.0);
  EXPECT_NEAR(power_from_roughness(0.5), 30.0, 1e-13);  // alpha = 1/4: 2 * 16 - 2
  EXPECT_NEAR(power_from_roughness(std::pow(2.0 / 8194.0, 0.25) * (1.0 + 1e-9)), 8192.0, 1e-4);
}

TEST(Material, RoughnessAndPowerInvertEachOtherInsideTheRange) {
  for (double m = 1.0; m <= 8192.0; m *= 1.7)
    EXPECT_NEAR(power_from_roughness(roughness_from_power(m)), m, 1e-11 * m);
}

TEST(Material, PowerNeverRisesWithRoughness) {
  for (int i = 1; i <= 1000; ++i)
    EXPECT_LE(power_from_roughness(i / 1000.0), power_from_roughness((i - 1) / 1000.0));
}

TEST(Material, DielectricAndMetalAreTheEndsOfTheMix) {
  const glm::dvec3 base(0.8, 0.4, 0.2);
  const Reflectance dielectric = from_metallic_roughness(base, 0.0, 1.0);
  EXPECT_EQ(dielectric.cdiff, base);
  EXPECT_EQ(dielectric.cspec, glm::dvec3(0.04));
  EXPECT_EQ(dielectric.gloss, 0.0);
  const Reflectance metal = from_metallic_roughness(base, 1.0, 0.0);
  EXPECT_EQ(metal.cdiff, glm::dvec3(0.0));
  EXPECT_EQ(metal.cspec, base);
  EXPECT_EQ(metal.gloss, 1.0);
}

TEST(Material, SpecularGlossinessMapsOneToOne) {
  const Reflectance r = from_specular_glossiness({0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}, 0.5);
  EXPECT_EQ(r.cdiff, glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_EQ(r.cspec, glm::dvec3(0.4, 0.5, 0.6));
  EXPECT_NEAR(r.m, std::sqrt(8192.0), 1e-12);
}

TEST(Srgb, EightBitRoundTripIsTheIdentity) {
  for (int b = 0; b <= 255; ++b) EXPECT_EQ(linear_to_srgb8(srgb8_to_linear(static_cast<std::uint8_t>(b))), b);
}

TEST(Srgb, KnownValues) {
  EXPECT_EQ(srgb_to_linear(0.0), 0.0);
  EXPECT_EQ(srgb_to_linear(1.0), 1.0);
  EXPECT_NEAR(srgb8_to_linear(188), 0.5, 0.003);  // byte 188 is the middle grey of light: one step is 0.005
  EXPECT_NEAR(linear_to_srgb(0.5), 0.735356983052449, 1e-14);
  // Bytes on both sides of the joint, from the published table of the curve.
  EXPECT_NEAR(srgb8_to_linear(10), 0.003035269835488375, 1e-17);
  EXPECT_NEAR(srgb8_to_linear(11), 0.003346535763899161, 1e-17);
  for (const double s : {0.01, 0.04, 0.042, 0.3, 0.99}) EXPECT_NEAR(linear_to_srgb(srgb_to_linear(s)), s, 4e-16);
}

TEST(Srgb, PiecesMeetAndTheCurveRises) {
  // The standard's constants are rounded: its two pieces differ by 3e-8 at the joint.
  EXPECT_NEAR(srgb_to_linear(0.04045), srgb_to_linear(std::nextafter(0.04045, 1.0)), 4e-8);
  for (int i = 1; i <= 4096; ++i) EXPECT_GT(srgb_to_linear(i / 4096.0), srgb_to_linear((i - 1) / 4096.0));
}

TEST(Srgb, EncodeClampsOutOfRange) {
  EXPECT_EQ(linear_to_srgb8(-3.0), 0);
  EXPECT_EQ(linear_to_srgb8(7.0), 255);
  EXPECT_EQ(linear_to_srgb8(std::nan("")), 0);
}

}  // namespace
}  // namespace aluminate::brdf
