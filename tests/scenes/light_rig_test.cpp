// The light rig and the files' lights against numbers worked out by hand.
#include "scenes/light_rig.hpp"

#include "platform/host/error.hpp"
#include "scenes/trigonometry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace aluminate::scenes {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr double kTight = 4e-15;  // a few roundings of numbers near 1

Scene box(const glm::dvec3& low, const glm::dvec3& high) {
  Scene scene;
  scene.file = "box.glb";
  scene.bounds_min = low;
  scene.bounds_max = high;
  return scene;
}

/// The light that reaches a point, as light_rig.hpp states it.
glm::dvec3 arriving(const ShadingLight& light, const glm::dvec3& p) {
  const glm::dvec3 to_light = glm::dvec3(light.position) - p * light.position.w;
  const double d2 = glm::dot(to_light, to_light);
  const glm::dvec3 l = to_light / std::sqrt(d2);
  const double att = 1 / (light.k0 + d2 * light.k1);
  const double window = std::max(0.0, 1 - (d2 * light.inv_range2) * (d2 * light.inv_range2));
  const double cone =
      std::clamp(glm::dot(l, light.spot_axis) * light.spot_scale + light.spot_offset, 0.0, 1.0);
  return light.color * (att * window * cone * cone);
}

LightSet lights_of(const Scene& scene, const char* choice, const char* camera = "outside") {
  const NormalisedSpace space = normalised_space(scene);
  return make_lights(scene, space, make_view(scene, space, parse_camera(camera), 1), parse_lights(choice));
}

TEST(ParseLights, AcceptsEveryFormAndNamesMistakes) {
  EXPECT_EQ(parse_lights("auto").kind, LightChoice::Kind::Auto);
  EXPECT_EQ(parse_lights("scene").kind, LightChoice::Kind::Scene);
  EXPECT_EQ(parse_lights("none").kind, LightChoice::Kind::None);
  EXPECT_EQ(parse_lights("rig:12").count, 12);
  for (const char* wrong : {"rig:0", "rig:257", "rig:", "rig:4x", "rig", "all", ""})
    EXPECT_THROW(parse_lights(wrong), UserError) << wrong;
}

TEST(LightRig, FollowsTheContractsFormulas) {
  const Scene scene = box(glm::dvec3(1, 2, 3), glm::dvec3(5, 4, 9));
  const NormalisedSpace space = normalised_space(scene);
  const double r = std::sqrt(4.0 + 1 + 9);
  const LightSet set = lights_of(scene, "rig:5");
  ASSERT_THAT(set.lights, SizeIs(5));
  EXPECT_EQ(set.description, "rig:5");
  const double s = 3 / std::sqrt(5.0);
  const ShadingLight& sun = set.lights[0];
  const glm::dvec3 to_sun = glm::normalize(glm::dvec3(0.5, 1, 0.3));
  EXPECT_NEAR(glm::length(glm::dvec3(sun.position) - to_sun), 0, kTight);
  EXPECT_EQ(sun.position.w, 0);
  EXPECT_NEAR(glm::length(sun.color - glm::dvec3(1, 0.95, 0.85) * s), 0, kTight);
  for (int i = 1; i < 5; ++i) {
    const ShadingLight& light = set.lights[static_cast<std::size_t>(i)];
    const double t = 0.61803399 * i - std::floor(0.61803399 * i), phi = 2.39996323 * i, y = 0.2 + 0.6 * t,
                 q = std::sqrt(1 - y * y);
    const glm::dvec3 d(std::cos(phi) * q, y, std::sin(phi) * q);
    EXPECT_EQ(light.position.w, 1);
    EXPECT_NEAR(glm::length(space.world(glm::dvec3(light.position)) - (glm::dvec3(3, 3, 6) + 1.2 * r * d)), 0,
                1e-14);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(light.color[k], (0.6 + 0.4 * std::cos(2 * kPi * (t + k / 3.0))) * 3 * s, 2 * kTight);
    // At the scene's centre d = 1.2 r: att = 1 / (1 + 1.44 * 4), in any units.
    EXPECT_NEAR(arriving(light, glm::dvec3(0)).r / light.color.r, 1 / (1 + 1.44 * 4), kTight);
  }
}

TEST(LightRig, InsideFillsTheBox) {
  const Scene scene = box(glm::dvec3(-10, 0, -5), glm::dvec3(10, 8, 5));
  const NormalisedSpace space = normalised_space(scene);
  const LightSet set = lights_of(scene, "rig:3", "inside");
  for (int i = 1; i < 3; ++i) {
    const double t = 0.61803399 * i - std::floor(0.61803399 * i), phi = 2.39996323 * i, y = 0.2 + 0.6 * t,
                 q = std::sqrt(1 - y * y);
    const glm::dvec3 expected =
        glm::dvec3(0, 4, 0) +
        0.8 * glm::dvec3(10, 4, 5) * glm::dvec3(std::cos(phi) * q, 2 * y - 1, std::sin(phi) * q);
    EXPECT_NEAR(
        glm::length(space.world(glm::dvec3(set.lights[static_cast<std::size_t>(i)].position)) - expected), 0,
        1e-14);
  }
}

TEST(LightRig, IsTheSameBitForBitAtAnyPowerOfTwoScale) {
  const Scene unit = box(glm::dvec3(-1, -2, -3), glm::dvec3(2, 1, 4));
  for (const int power : {-30, 17}) {
    const double s = std::ldexp(1.0, power);
    const LightSet a = lights_of(unit, "rig:7"),
                   b = lights_of(box(unit.bounds_min * s, unit.bounds_max * s), "rig:7");
    for (std::size_t i = 0; i < 7; ++i) {
      EXPECT_EQ(a.lights[i].position, b.lights[i].position);
      EXPECT_EQ(a.lights[i].color, b.lights[i].color);
      EXPECT_EQ(a.lights[i].k1, b.lights[i].k1);
    }
  }
}

TEST(LightRig, AutoTakesTheScenesLightsElseRigFour) {
  Scene scene = box(glm::dvec3(-1), glm::dvec3(1));
  EXPECT_EQ(lights_of(scene, "auto").description, "rig:4");
  EXPECT_THAT(lights_of(scene, "none").lights, IsEmpty());
  EXPECT_THAT(lights_of(scene, "scene").warnings, SizeIs(1));
  scene.lights.resize(2);
  EXPECT_EQ(lights_of(scene, "auto").description, "scene (2 lights)");
  EXPECT_THAT(lights_of(scene, "rig:1").lights, SizeIs(1));
}

TEST(SceneLights, DirectionalOfIntensityPiShowsWhiteAsOne) {
  Scene scene = box(glm::dvec3(-100), glm::dvec3(100));
  Light sun;
  sun.kind = LightKind::Directional;
  sun.intensity = kPi;
  sun.color = glm::dvec3(1, 0.5, 0.25);
  sun.direction = glm::dvec3(0, -2, 0);
  scene.lights.push_back(sun);
  const ShadingLight light = lights_of(scene, "scene").lights.at(0);
  EXPECT_EQ(light.position, glm::dvec4(0, 1, 0, 0));
  EXPECT_EQ(arriving(light, glm::dvec3(0.5)), glm::dvec3(1, 0.5, 0.25));
}

TEST(SceneLights, PointFallsWithTheSquareOfTheWorldDistance) {
  for (const double size : {1e-4, 1.0, 1e6}) {
    Scene scene = box(glm::dvec3(-size), glm::dvec3(size));
    Light lamp;
    lamp.kind = LightKind::Point;
    lamp.intensity = 300 * size * size;  // candela that suit the size
    lamp.position = glm::dvec3(0, size, 0);
    scene.lights.push_back(lamp);
    const NormalisedSpace space = normalised_space(scene);
    const ShadingLight light = lights_of(scene, "scene").lights.at(0);
    for (const double distance : {0.25, 0.5, 1.0, 3.0}) {
      const glm::dvec3 p = space.point(glm::dvec3(0, size * (1 - distance), 0));
      // Lux over pi; the lamp's radius adds 2^-16 to d^2 in normalised units.
      const double d = distance * size * space.scale, expected = 300 / (distance * distance) / kPi;
      EXPECT_NEAR(arriving(light, p).r / expected, 1, 0x1p-16 / (d * d) + kTight) << size << " " << distance;
    }
    EXPECT_TRUE(std::isfinite(arriving(light, glm::dvec3(light.position) + glm::dvec3(1e-9)).r));
  }
}

TEST(SceneLights, RangeEndsTheLight) {
  Scene scene = box(glm::dvec3(-10), glm::dvec3(10));
  Light lamp;
  lamp.range = 4;
  lamp.intensity = kPi;
  scene.lights.push_back(lamp);
  const NormalisedSpace space = normalised_space(scene);
  const ShadingLight light = lights_of(scene, "scene").lights.at(0);
  const auto at = [&](double distance) { return arriving(light, space.point(glm::dvec3(distance, 0, 0))).r; };
  EXPECT_NEAR(at(2), (1 - 1.0 / 16) / 4,
              1e-3);  // 1 - (d/range)^4; the lamp's radius is 2^-16 of a squared unit of 16
  EXPECT_NEAR(at(4), 0, 1e-15);
  EXPECT_EQ(at(5), 0);
}

TEST(SceneLights, SpotConeFollowsTheExtension) {
  Scene scene = box(glm::dvec3(-1), glm::dvec3(1));
  Light spot;
  spot.kind = LightKind::Spot;
  spot.intensity = kPi;
  spot.position = glm::dvec3(0, 1, 0);
  spot.direction = glm::dvec3(0, -1, 0);
  spot.inner_cone = 0.2;
  spot.outer_cone = 0.6;
  scene.lights.push_back(spot);
  const ShadingLight light = lights_of(scene, "scene").lights.at(0);
  const auto at_angle = [&](double angle) {
    const glm::dvec3 p = glm::dvec3(light.position) + glm::dvec3(std::sin(angle), -std::cos(angle), 0);
    return arriving(light, p).r / (light.color.r / (1 + 0x1p-16));
  };
  EXPECT_NEAR(at_angle(0), 1, kTight);
  EXPECT_NEAR(at_angle(0.19), 1, kTight);
  const double half = (std::cos(0.4) - std::cos(0.6)) / (std::cos(0.2) - std::cos(0.6));
  EXPECT_NEAR(at_angle(0.4), half * half, 1e-13);  // the difference of cosines loses a digit
  EXPECT_EQ(at_angle(0.61), 0);
  EXPECT_EQ(at_angle(3.0), 0);
}

TEST(SceneLights, BlindingLightsAreMentioned) {
  Scene scene = box(glm::dvec3(-1), glm::dvec3(1));
  Light sun;
  sun.kind = LightKind::Directional;
  sun.name = "Sun";
  sun.intensity = 100000;
  scene.lights.push_back(sun);
  EXPECT_THAT(lights_of(scene, "scene").warnings,
              testing::ElementsAre(HasSubstr("light 'Sun' brings 3.18e+04 times white")));
  scene.lights[0].intensity = 5;
  EXPECT_THAT(lights_of(scene, "scene").warnings, IsEmpty());
}

}  // namespace
}  // namespace aluminate::scenes
