// DXT5 layout: channels where they belong, and gloss disturbing y but never x.
#include "shading/filter/dxt5_pack.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/filter/bumpy_map.hpp"

namespace aluminate::filter {
namespace {

BakedLevel base_level(int size, double steepness) {
  const auto pixels = bumpy_map(size, steepness, 200);
  return bake_gloss({pixels, size, size}, {.footprint_sigma = 0.7}).front();
}

TEST(Dxt5Pack, PutsGlossInRedYInGreenXInAlpha) {
  BakedLevel level;
  level.length = level.gloss = level.filtered_gloss = {1, 1, {0.5}};
  level.normal = {
      1, 1, {0.5 * glm::normalize(glm::dvec3(0.28, -0.96, 0.0))}};  // un-normalised means pack as directions
  const auto rgba = pack_texels(level, level.filtered_gloss);
  EXPECT_EQ(rgba, (std::vector<std::uint8_t>{128, 5, 0, 163}));
}

TEST(Dxt5Pack, ConstantPictureSurvivesWithinTheEndpointGrid) {
  const std::vector<std::uint8_t> texel{132, 130, 0,
                                        77};  // exact in 5:6:5: 132 = 16 (16 << 3 | 16 >> 2), 130 = 32
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 16; ++i) rgba.insert(rgba.end(), texel.begin(), texel.end());
  const PackError error = pack_error(rgba, decode_dxt5(encode_dxt5(rgba, 4, 4), 4, 4));
  EXPECT_EQ(error.gloss, 0.0);
  EXPECT_EQ(error.normal_y, 0.0);
  EXPECT_EQ(error.normal_x, 0.0);
}

TEST(Dxt5Pack, SizesThatAreNotMultiplesOfFourDecodeToTheirOwnSize) {
  std::vector<std::uint8_t> rgba(5 * 3 * 4, 255);
  const auto blocks = encode_dxt5(rgba, 5, 3);
  EXPECT_EQ(blocks.size(), 2u * 16u);
  EXPECT_EQ(decode_dxt5(blocks, 5, 3), rgba);
}

TEST(CrossTalk, GlossDetailWorsensYAndNeverTouchesX) {
  const auto rows = cross_talk(base_level(128, 0.5));
  ASSERT_EQ(rows.size(), 5u);
  const double without = rows[0].error.normal_y;
  EXPECT_GT(without, 0.0);
  EXPECT_LT(rows[1].error.normal_y, 1.2 * without);  // smooth gloss is nearly free
  for (std::size_t i = 2; i < rows.size(); ++i)
    EXPECT_GT(rows[i].error.normal_y, 1.2 * without) << rows[i].content;
  EXPECT_GT(rows[4].error.normal_y, rows[1].error.normal_y * 2.0);
  for (const CrossTalkRow& row : rows) EXPECT_EQ(row.error.normal_x, rows[0].error.normal_x) << row.content;
}

TEST(CrossTalk, WeightingRedDownGivesYBackAtTheExpenseOfGloss) {
  const BakedLevel level = base_level(128, 0.5);
  const auto even = cross_talk(level), weighted = cross_talk(level, {0.1f, 1.0f, 1.0f});
  for (std::size_t i = 2; i < even.size(); ++i) {
    EXPECT_LT(weighted[i].error.normal_y, even[i].error.normal_y) << even[i].content;
    EXPECT_GT(weighted[i].error.gloss, even[i].error.gloss) << even[i].content;
    EXPECT_EQ(weighted[i].error.normal_x, even[i].error.normal_x);
  }
}

}  // namespace
}  // namespace aluminate::filter
