// Cube maps filtered by gloss: the grid of directions, the lobe, what a chain must keep.
#include "shading/filter/cube_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "shading/vm/cube_map.hpp"

namespace aluminate::filter {
namespace {

CubeLevel filled(int size, const glm::dvec4& value) {
  return {size, std::vector<glm::dvec4>(6 * static_cast<std::size_t>(size * size), value)};
}

TEST(CubeFilter, TexelsLieWhereTheTextureUnitLooksForThem) {
  double sphere = 0;
  for (int face = 0; face < 6; ++face)
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) {
        const glm::dvec3 d = cube_direction(face, x, y, 16);
        EXPECT_NEAR(glm::length(d), 1.0, 1e-15);
        const vm::FacePoint at = vm::face_point({d.x, d.y, d.z});
        EXPECT_EQ(at.face, face);
        EXPECT_NEAR(at.u * 16, x + 0.5, 1e-12);
        EXPECT_NEAR(at.v * 16, y + 0.5, 1e-12);
        sphere += cube_solid_angle(x, y, 16);
      }
  // A midpoint rule: 3.0792 / n^2 too much, to fourth order.
  EXPECT_NEAR((sphere - 4 * std::numbers::pi) * (16 * 16), 3.0792, 1e-3);
}

TEST(CubeFilter, OneColourStaysInEveryLevel) {
  const glm::dvec4 value(0.25, 3, 0.5, 0.75);
  const auto chain = prefilter(filled(16, value));
  ASSERT_EQ(chain.size(), 5u);
  for (const CubeLevel& level : chain)
    for (const glm::dvec4& texel : level.texels)
      for (int c = 0; c < 4; ++c) EXPECT_NEAR(texel[c], value[c], 1e-12 * value[c]);
}

TEST(CubeFilter, ALitTexelSpreadsAsTheLobeOfTheLevelsPower) {
  CubeLevel capture = filled(32, glm::dvec4(0));
  const glm::dvec3 light = cube_direction(2, 9, 20, 32);
  capture.texels[capture.index(2, 9, 20)] = glm::dvec4(1);
  const auto chain = prefilter(capture);
  for (int k = 1; k < 6; ++k) {
    const CubeLevel& level = chain[static_cast<std::size_t>(k)];
    const double m = cube_level_power(k, 32);
    EXPECT_EQ(m, std::exp2(13.0 - 2 * (k + 1)));
    const auto weight = [&](const glm::dvec3& r, const glm::dvec3& l) {
      const double n_dot_l = glm::dot(r, l);
      return n_dot_l <= 0 ? 0.0 : std::pow(glm::dot(r, glm::normalize(r + l)), m) * n_dot_l;
    };
    for (int y = 0; y < level.size; ++y)
      for (int x = 0; x < level.size; ++x) {
        const glm::dvec3 r = cube_direction(2, x, y, level.size);
        double all = 0;
        for (int face = 0; face < 6; ++face)
          for (int j = 0; j < 32; ++j)
            for (int i = 0; i < 32; ++i)
              all += weight(r, cube_direction(face, i, j, 32)) * cube_solid_angle(i, j, 32);
        const double want = weight(r, light) * cube_solid_angle(9, 20, 32) / all;
        // What is left out: weights below 2^-30 of the greatest, fewer than 2^13 of them.
        EXPECT_NEAR(level.texels[level.index(2, x, y)].x, want, 0x1p-17 * 1e-3 + 1e-9 * want)
            << k << " " << x << "," << y;
      }
  }
}

TEST(CubeFilter, LevelOfAPowerIsWhereThatPowerIsKept) {
  for (const int size : {16, 64, 128})
    for (int k = 1; size >> k > 0; ++k) {
      const double power = cube_level_power(k, size);
      if (power <= 8192) {
        EXPECT_DOUBLE_EQ(cube_level_bias(size) - 0.5 * std::log2(power), k);
      }
    }
  EXPECT_EQ(cube_level_power(0, 64), 8192);
  EXPECT_TRUE(is_cube_size(64));
  for (const int size : {0, 8, 48, 256}) EXPECT_FALSE(is_cube_size(size));
}

}  // namespace
}  // namespace aluminate::filter
