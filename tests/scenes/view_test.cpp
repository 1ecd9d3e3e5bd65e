// Cameras and the clip matrix against numbers worked out by hand.
#include "scenes/view.hpp"

#include "platform/host/error.hpp"
#include "scenes/trigonometry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace aluminate::scenes {
namespace {

using testing::HasSubstr;

// The trigonometry's error (1.5 ulp) times a few operations on numbers near 1.
constexpr double kTight = 4e-15;

Scene box(const glm::dvec3& low, const glm::dvec3& high) {
  Scene scene;
  scene.file = "box.glb";
  scene.bounds_min = low;
  scene.bounds_max = high;
  return scene;
}

glm::dvec3 project(const glm::dmat4& m, const glm::dvec3& p) {
  const glm::dvec4 clip = m * glm::dvec4(p, 1);
  return glm::dvec3(clip) / clip.w;
}

TEST(Trigonometry, AgreesWithLibmToAnUlpOfOne) {
  double worst = 0;
  for (int i = -200000; i <= 200000; ++i) {
    const double x = i * 0.00173;
    const SinCos ours = sin_cos(x);
    worst = std::max({worst, std::fabs(ours.sin - std::sin(x)), std::fabs(ours.cos - std::cos(x))});
  }
  EXPECT_LE(worst, 3.4e-16);  // 1.5 * 2^-52
  EXPECT_EQ(sin_cos(0).sin, 0);
  EXPECT_EQ(sin_cos(0).cos, 1);
  EXPECT_EQ(sin_cos(kPi / 2).sin, 1);
  EXPECT_TRUE(std::isnan(sin_cos(std::nan("")).sin));
}

TEST(NormalisedSpace, RadiusLiesInOneToTwoForScenesOfAnySize) {
  for (int power = -200; power <= 200; power += 7) {
    for (const double mantissa : {1.0, 1.37, 1.999}) {
      const double size = std::ldexp(mantissa, power);
      const glm::dvec3 low(-size, size, 3 * size), high(size, 2 * size, 4 * size);
      const NormalisedSpace space = normalised_space(low, high);
      EXPECT_GE(space.radius, 1);
      EXPECT_LT(space.radius, 2);
      EXPECT_EQ(space.scale, std::ldexp(1.0, space.exponent));
      EXPECT_EQ(space.radius, space.radius_world * space.scale);
      EXPECT_NEAR(space.radius_world / (size * std::sqrt(6.0) / 2), 1, kTight);
      EXPECT_EQ(space.centre, glm::dvec3(0, 1.5 * size, 3.5 * size));
      EXPECT_EQ(space.point(space.centre), glm::dvec3(0));
      EXPECT_EQ(space.half_extent, (high - low) * 0.5 * space.scale);
    }
  }
}

TEST(NormalisedSpace, ScenesWithoutExtentAndOfExtremeExtentAreUsable) {
  EXPECT_EQ(normalised_space(glm::dvec3(5), glm::dvec3(5)).scale, 1);
  EXPECT_EQ(normalised_space(glm::dvec3(5), glm::dvec3(5)).radius, 1);
  const NormalisedSpace huge = normalised_space(glm::dvec3(-1e100), glm::dvec3(1e100));
  EXPECT_TRUE(huge.radius >= 1 && huge.radius < 2);
  const NormalisedSpace tiny = normalised_space(glm::dvec3(0), glm::dvec3(0x1p-800));
  EXPECT_TRUE(tiny.radius >= 1 && tiny.radius < 2 && std::isfinite(tiny.scale));
}

TEST(ParseCamera, AcceptsEveryForm) {
  using Kind = CameraChoice::Kind;
  EXPECT_EQ(parse_camera("auto").kind, Kind::Auto);
  EXPECT_EQ(parse_camera("outside").kind, Kind::Outside);
  EXPECT_EQ(parse_camera("inside").kind, Kind::Inside);
  EXPECT_EQ(parse_camera("gltf").index, 0);
  EXPECT_EQ(parse_camera("gltf:3").index, 3);
  const CameraChoice c = parse_camera("1,-2.5,3e1:0,0.5,0:60");
  EXPECT_EQ(c.kind, Kind::Explicit);
  EXPECT_EQ(c.eye, glm::dvec3(1, -2.5, 30));
  EXPECT_EQ(c.target, glm::dvec3(0, 0.5, 0));
  EXPECT_EQ(c.fovy_degrees, 60);
}

TEST(ParseCamera, SaysWhatWasExpectedAtThePartThatIsWrong) {
  const auto error_of = [](const char* text) -> std::string {
    try {
      parse_camera(text);
    } catch (const UserError& error) {
      EXPECT_THAT(error.hint(), HasSubstr("outside, inside"));
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(error_of("side"), HasSubstr("camera 'side': not a known camera"));
  EXPECT_THAT(error_of(""), HasSubstr("not a known camera"));
  EXPECT_THAT(error_of("gltf:x"), HasSubstr("expected a camera number from 0, found 'x'"));
  EXPECT_THAT(error_of("gltf:-1"), HasSubstr("expected a camera number from 0"));
  EXPECT_THAT(error_of("gltf:"), HasSubstr("expected a camera number"));
  EXPECT_THAT(error_of("1,2:0,0,0:45"), HasSubstr("expected three numbers x,y,z for the eye"));
  EXPECT_THAT(error_of("1,2,3,4:0,0,0:45"), HasSubstr("three numbers"));
  EXPECT_THAT(error_of("1,2,3:0,a,0:45"), HasSubstr("expected a number for the target's y, found 'a'"));
  EXPECT_THAT(error_of("1,2,3:0,0,0"), HasSubstr("not a known camera"));
  EXPECT_THAT(error_of("1,2,3:0,0,0:45:6"), HasSubstr("not a known camera"));
  EXPECT_THAT(error_of("1,2,3:0,0,0:180"), HasSubstr("between 0 and 180"));
  EXPECT_THAT(error_of("1,2,3:0,0,0:0"), HasSubstr("between 0 and 180"));
  EXPECT_THAT(error_of("1,2,nan:0,0,0:45"), HasSubstr("the eye's z, found 'nan'"));
  EXPECT_THAT(error_of("1,2,3 :0,0,0:45"), HasSubstr("found '3 '"));
}

TEST(View, OutsideIsWhereTheContractPutsIt) {
  // A cube of half diagonal sqrt(12) about (1,2,3).
  const Scene scene = box(glm::dvec3(-1, 0, 1), glm::dvec3(3, 4, 5));
  const NormalisedSpace space = normalised_space(scene);
  const View view = make_view(scene, space, {}, 16.0 / 9);
  const double r = std::sqrt(12.0);
  const glm::dvec3 eye = glm::dvec3(1, 2, 3) + 2.2 * r * glm::normalize(glm::dvec3(0.6, 0.45, 1));
  EXPECT_NEAR(glm::length(space.world(view.eye) - eye), 0, 1e-14);
  EXPECT_EQ(view.near_plane, 0.01 * space.radius);
  EXPECT_EQ(view.far_plane, 10 * space.radius);
  EXPECT_NEAR(view.tan_half_fovy, std::tan(0.39269908169872414), kTight);
  EXPECT_FALSE(view.inside);
  EXPECT_EQ(view.description, "outside");
  // The centre of the scene is the centre of the picture.
  const glm::dvec3 centre = project(view.world_to_clip(), glm::dvec3(0));
  EXPECT_NEAR(centre.x, 0, kTight);
  EXPECT_NEAR(centre.y, 0, kTight);
}

TEST(View, InsideIsWhereTheContractPutsIt) {
  const Scene scene = box(glm::dvec3(-10, 0, -5), glm::dvec3(10, 8, 5));
  const NormalisedSpace space = normalised_space(scene);
  const View view = make_view(scene, space, parse_camera("inside"), 1);
  EXPECT_NEAR(glm::length(space.world(view.eye) - glm::dvec3(-10 + 20 * 0.06, 8 * 0.36, -5 + 10 * 0.42)), 0,
              1e-14);
  const glm::dvec3 target = space.point(glm::dvec3(-10 + 20 * 0.75, 8 * 0.33, -5 + 10 * 0.62));
  EXPECT_NEAR(project(view.world_to_clip(), target).x, 0, kTight);
  EXPECT_NEAR(project(view.world_to_clip(), target).y, 0, kTight);
  EXPECT_NEAR(view.tan_half_fovy, std::sqrt(1.0 / 3), kTight);
  EXPECT_TRUE(view.inside);
  EXPECT_EQ(view.far_plane, 4 * space.radius);
}

TEST(View, PerspectiveMatrixMapsTheFrustumToD3DClip) {
  Scene scene = box(glm::dvec3(-1), glm::dvec3(1));
  const NormalisedSpace space = normalised_space(scene);
  const View view = make_view(scene, space, parse_camera("0,0,4:0,0,0:90"), 2);  // looks along -z, tan = 1
  const glm::dmat4 m = view.world_to_clip();
  const double n = view.near_plane, f = view.far_plane;
  const glm::dvec3 eye = view.eye;
  EXPECT_EQ(view.right, glm::dvec3(1, 0, 0));
  EXPECT_EQ(view.up, glm::dvec3(0, 1, 0));
  const auto near_corner = project(m, eye + glm::dvec3(2 * n, n, -n));
  constexpr double kNearTight =
      1e-12;  // the eye's coordinates are 1000 n: their rounding is 1000 times larger here
  EXPECT_NEAR(near_corner.x, 1, kNearTight);
  EXPECT_NEAR(near_corner.y, 1, kNearTight);
  EXPECT_NEAR(near_corner.z, 0, kNearTight);
  EXPECT_NEAR(project(m, eye + glm::dvec3(0, -f, -f)).z, 1, kTight);
  EXPECT_NEAR(project(m, eye + glm::dvec3(0, -f, -f)).y, -1, kTight);
  EXPECT_LT((m * glm::dvec4(eye + glm::dvec3(0, 0, 1), 1)).w, 0) << "behind the eye";
}

TEST(View, ScaledScenesHaveTheSameMatrixBitForBit) {
  const Scene unit = box(glm::dvec3(-1, -2, -3), glm::dvec3(2, 1, 4));
  for (const int power : {-40, -13, 9, 60}) {
    const double s = std::ldexp(1.0, power);
    const Scene scaled = box(unit.bounds_min * s, unit.bounds_max * s);
    for (const char* camera : {"outside", "inside"}) {
      const glm::dmat4 a = make_view(unit, normalised_space(unit), parse_camera(camera), 1.5).world_to_clip();
      const glm::dmat4 b =
          make_view(scaled, normalised_space(scaled), parse_camera(camera), 1.5).world_to_clip();
      EXPECT_EQ(a, b) << power << camera;
    }
  }
}

Scene with_camera(const Camera& camera) {
  Scene scene = box(glm::dvec3(-4), glm::dvec3(4));
  scene.cameras.push_back(camera);
  return scene;
}

TEST(View, AutoTakesTheFilesFirstCamera) {
  Camera camera;
  camera.name = "lens";
  camera.fovy = kPi / 2;
  camera.near_plane = 0.5;
  // Turned a quarter about y (looks along -x), scaled by 3: the scale must not matter. At (10, 1, 2).
  camera.camera_to_world = glm::dmat4(glm::dvec4(0, 0, -3, 0), glm::dvec4(0, 3, 0, 0), glm::dvec4(3, 0, 0, 0),
                                      glm::dvec4(10, 1, 2, 1));
  const Scene scene = with_camera(camera);
  const NormalisedSpace space = normalised_space(scene);
  const View view = make_view(scene, space, {}, 1);
  EXPECT_EQ(space.world(view.eye), glm::dvec3(10, 1, 2));
  EXPECT_EQ(view.back, glm::dvec3(1, 0, 0));
  EXPECT_EQ(view.right, glm::dvec3(0, 0, -1));
  EXPECT_EQ(view.up, glm::dvec3(0, 1, 0));
  EXPECT_EQ(view.near_plane, 0.5 * space.scale);
  EXPECT_NEAR(view.tan_half_fovy, 1, kTight);
  // No zfar: behind the farthest possible point of the bounds.
  EXPECT_GT(view.far_plane, glm::length(view.eye) + space.radius);
  EXPECT_EQ(view.description, "gltf:0 'lens'");
  const glm::dvec3 ahead =
      project(view.world_to_clip(), space.point(glm::dvec3(0, 1, 2 - 10)));  // 10 ahead, 10 to the right
  EXPECT_NEAR(ahead.x, 1, kTight);
}

TEST(View, OrthographicCameraUsesItsHeightAndTheImagesAspect) {
  Camera camera;
  camera.perspective = false;
  camera.xmag = 99;
  camera.ymag = 2;
  camera.near_plane = 1;
  camera.far_plane = 21;
  camera.camera_to_world[3] = glm::dvec4(0, 0, 11, 1);
  const Scene scene = with_camera(camera);
  const NormalisedSpace space = normalised_space(scene);
  const glm::dmat4 m = make_view(scene, space, parse_camera("gltf"), 1.5).world_to_clip();
  const glm::dvec3 corner = project(m, space.point(glm::dvec3(3, 2, 0)));
  EXPECT_NEAR(corner.x, 1, kTight);
  EXPECT_NEAR(corner.y, 1, kTight);
  EXPECT_NEAR(corner.z, 0.5, kTight);
  EXPECT_NEAR(project(m, space.point(glm::dvec3(0, 0, 10))).z, 0, kTight);
  EXPECT_NEAR(project(m, space.point(glm::dvec3(0, 0, -10))).z, 1, kTight);
}

TEST(View, ImpossibleCamerasAreErrors) {
  const Scene scene = box(glm::dvec3(-1), glm::dvec3(1));
  const NormalisedSpace space = normalised_space(scene);
  EXPECT_THROW(make_view(scene, space, parse_camera("gltf"), 1), UserError);
  EXPECT_THROW(make_view(with_camera({}), space, parse_camera("gltf:1"), 1), UserError);
  EXPECT_THROW(make_view(scene, space, parse_camera("1,1,1:1,1,1:45"), 1), UserError);
  const Scene point = box(glm::dvec3(0), glm::dvec3(0));
  EXPECT_THROW(make_view(point, normalised_space(point), parse_camera("inside"), 1), UserError);
  EXPECT_NO_THROW(make_view(point, normalised_space(point), parse_camera("outside"), 1));
  Camera flat;
  flat.camera_to_world = glm::dmat4(0);
  EXPECT_THROW(make_view(with_camera(flat), space, parse_camera("gltf"), 1), UserError);
}

TEST(View, LookingStraightDownHasABasis) {
  const Scene scene = box(glm::dvec3(-1), glm::dvec3(1));
  for (const char* camera : {"0,5,0:0,0,0:45", "0,-5,0:0,0,0:45"}) {
    const View view = make_view(scene, normalised_space(scene), parse_camera(camera), 1);
    EXPECT_NEAR(glm::dot(glm::cross(view.right, view.up), view.back), 1, kTight) << camera;
  }
}

}  // namespace
}  // namespace aluminate::scenes
