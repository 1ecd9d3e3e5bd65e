// Mips of normals: means kept exactly, lengths only ever shrink, odd sizes covered, footprint normalised.
#include "shading/filter/normal_mips.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "platform/host/error.hpp"
#include "tests/filter/bumpy_map.hpp"

namespace aluminate::filter {
namespace {

glm::dvec3 mean(const NormalLevel& level) {
  glm::dvec3 sum(0.0);
  for (const glm::dvec3& n : level.texels) sum += n;
  return sum / static_cast<double>(level.texels.size());
}

TEST(NormalMips, EveryStoredTexelDecodesToUnitLength) {
  for (int r = 0; r <= 255; r += 5)
    for (int g = 0; g <= 255; g += 5)
      for (int b = 0; b <= 255; b += 5)
        EXPECT_NEAR(glm::length(decode_normal(static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g),
                                              static_cast<std::uint8_t>(b))),
                    1.0, 4e-16);  // two roundings of a normalisation
  EXPECT_EQ(decode_normal(0, 0, 0), glm::dvec3(0, 0, 1));
}

TEST(NormalMips, KeepTheMeanOfThePictureAtEverySizeAlsoOdd) {
  for (const int size : {1, 2, 3, 5, 7, 12, 16, 31}) {
    const auto pixels = bumpy_map(size, 2.0, 255);
    const auto chain = mip_chain(decode_normal_map({pixels, size, size}));
    const glm::dvec3 expected = mean(chain.front());
    for (const NormalLevel& level : chain)
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(mean(level)[k], expected[k], 1e-14) << size << ' ' << level.width;
    EXPECT_EQ(chain.back().width, 1);
    EXPECT_EQ(chain.back().height, 1);
  }
}

TEST(NormalMips, EvenSizesAreTwoByTwoBoxes) {
  const auto pixels = bumpy_map(8, 2.0, 255);
  const NormalLevel base = decode_normal_map({pixels, 8, 8}), half = halve(base);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) {
      const glm::dvec3 box = 0.25 * (base.at(2 * x, 2 * y) + base.at(2 * x + 1, 2 * y) +
                                     base.at(2 * x, 2 * y + 1) + base.at(2 * x + 1, 2 * y + 1));
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(half.at(x, y)[k], box[k], 1e-16);
    }
}

TEST(NormalMips, OddWidthSplitsTheMiddleTexel) {
  ScalarLevel three{3, 1, {1.0, 10.0, 100.0}};
  EXPECT_NEAR(halve(three).texels[0], 37.0, 1e-14);
  ScalarLevel five{5, 1, {1.0, 10.0, 100.0, 1000.0, 10000.0}};
  const ScalarLevel two = halve(five);
  ASSERT_EQ(two.width, 2);
  EXPECT_NEAR(two.texels[0], (1.0 + 10.0 + 50.0) / 2.5, 1e-13);
  EXPECT_NEAR(two.texels[1], (50.0 + 1000.0 + 10000.0) / 2.5, 1e-11);
}

TEST(NormalMips, LengthsNeverExceedOne) {
  const auto pixels = bumpy_map(32, 2.0, 255);
  for (const NormalLevel& level : mip_chain(decode_normal_map({pixels, 32, 32})))
    for (const glm::dvec3& n : level.texels) EXPECT_LE(glm::length(n), 1.0 + 1e-15);
}

TEST(NormalMips, FootprintKeepsTheMeanAndShortensNeighboursThatDiffer) {
  const auto pixels = bumpy_map(16, 2.0, 255);
  const NormalLevel base = decode_normal_map({pixels, 16, 16}), blurred = gaussian(base, 0.5);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(mean(blurred)[k], mean(base)[k], 1e-14);
  EXPECT_LT(glm::length(blurred.at(12, 12)), 0.999);
  EXPECT_NEAR(glm::length(blurred.at(4, 4)), 1.0, 1e-14);  // inside the flat quarter
  EXPECT_EQ(gaussian(base, 0.0).texels, base.texels);
}

TEST(NormalMips, RefusesAnEmptyMap) { EXPECT_THROW((void)decode_normal_map({{}, 0, 4}), UserError); }

}  // namespace
}  // namespace aluminate::filter
