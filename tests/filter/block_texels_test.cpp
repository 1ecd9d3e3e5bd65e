// Block compression at import: what must survive it, what may not, and how many bytes it takes.
#include "shading/filter/block_texels.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace aluminate::filter {
namespace {

TEST(BlockTexels, TakeHalfOrOneByteATexel) {
  EXPECT_EQ(block_bytes(64, 32, BlockFormat::Dxt1), 64u * 32 / 2);
  EXPECT_EQ(block_bytes(64, 32, BlockFormat::Dxt5), 64u * 32);
  EXPECT_EQ(block_bytes(64, 32, BlockFormat::Dxt5nm), 64u * 32);
  EXPECT_EQ(block_bytes(1, 1, BlockFormat::Dxt1), 8u);  // never less than a block
}

TEST(BlockTexels, AConstantColourKeepsItsBitsOnTheGridOfItsEndpoints) {
  const std::vector<std::uint8_t> texel = {255, 0, 132, 255};  // 5:6:5 holds it: 132 = 16 << 3 | 16 >> 2
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 5 * 3; ++i) rgba.insert(rgba.end(), texel.begin(), texel.end());
  EXPECT_EQ(through_blocks(rgba, 5, 3, BlockFormat::Dxt1), rgba);
  EXPECT_EQ(through_blocks(rgba, 5, 3, BlockFormat::Dxt5), rgba);
}

TEST(BlockTexels, FourUnrelatedColoursOfABlockBecomeAnotherFour) {
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 16; ++i)
    for (int code : {i % 4 == 0 ? 255 : 0, i % 4 == 1 ? 255 : 0, i % 4 == 2 ? 255 : 0, 255})
      rgba.push_back(static_cast<std::uint8_t>(code));
  EXPECT_NE(through_blocks(rgba, 4, 4, BlockFormat::Dxt1), rgba);  // they do not lie on a line
}

TEST(BlockTexels, NormalsKeepXAndYInChannelsOfTheirOwn) {
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 16; ++i)
    for (int code : {100 + i, 160 - 2 * i, 220, 255}) rgba.push_back(static_cast<std::uint8_t>(code));
  const std::vector<std::uint8_t> out = through_blocks(rgba, 4, 4, BlockFormat::Dxt5nm);
  for (std::size_t i = 0; i < 64; i += 4) {
    EXPECT_LE(std::abs(out[i + 3] - rgba[i]), 2) << i;      // eight levels between the block's extremes
    EXPECT_LE(std::abs(out[i + 1] - rgba[i + 1]), 8) << i;  // four
    EXPECT_EQ(out[i], 0);
    EXPECT_EQ(out[i + 2], 0);
  }
}

}  // namespace
}  // namespace aluminate::filter
