#include "platform/host/hash.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace aluminate::host {
namespace {

// From the xxhsum program (xxhsum -H2) over the same bytes.
TEST(Hash, KnownVectors) {
  EXPECT_EQ(hash_text("").hex(), "99aa06d3014798d86001c324468d497f");
  EXPECT_EQ(hash_text("a").hex(), "a96faf705af16834e6c632b61e964e1f");
  EXPECT_EQ(hash_text("aluminate").hex(), "e38ddc770808e757534b8b43ca478e3d");
  std::vector<std::uint8_t> thousand(1000);
  for (std::size_t i = 0; i < thousand.size(); ++i) thousand[i] = static_cast<std::uint8_t>(i * 7 & 0xff);
  EXPECT_EQ(hash_bytes(thousand).hex(), "abee229cdadad76d10ad30264426c830");
}

TEST(Hash, PiecesGiveTheHashOfTheWhole) {
  std::vector<std::uint8_t> bytes(5000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * i >> 3);
  for (const std::size_t step : {1u, 63u, 64u, 240u, 241u, 1024u, 5000u}) {
    Hasher hasher;
    for (std::size_t at = 0; at < bytes.size(); at += step) {
      hasher.add(std::span(bytes).subspan(at, std::min(step, bytes.size() - at)));
    }
    EXPECT_EQ(hasher.finish(), hash_bytes(bytes)) << "step " << step;
  }
}

TEST(Hash, NumbersAreLittleEndianBytes) {
  const std::vector<std::uint8_t> bytes{0x04, 0x03, 0x02, 0x01, 0x18, 0x17, 0x16, 0x15, 0x14, 0x13, 0x12, 0x11};
  EXPECT_EQ(Hasher().add_u32(0x01020304u).add_u64(0x1112131415161718u).finish(), hash_bytes(bytes));
  const std::vector<std::uint32_t> words{0x01020304u, 0x15161718u, 0x11121314u};
  EXPECT_EQ(Hasher().add(words).finish(), hash_bytes(bytes));
}

TEST(Hash, TextsDoNotRunIntoEachOther) {
  EXPECT_NE(Hasher().add_text("ab").add_text("c").finish(), Hasher().add_text("a").add_text("bc").finish());
}

TEST(Hash, FinishCanBeFollowedByMore) {
  Hasher hasher;
  hasher.add_u32(1);
  const Hash128 first = hasher.finish();
  EXPECT_EQ(hasher.finish(), first);
  EXPECT_NE(hasher.add_u32(2).finish(), first);
}

}  // namespace
}  // namespace aluminate::host
