// The tiling table: render target sets against frame sizes, tile counts and passes.
#include "platform/console/edram.hpp"
#include "platform/console/platform_file.hpp"
#include "platform/host/error.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace aluminate::test {
namespace {

const console::GpuModel& xenos() {
  static const console::GpuModel gpu = console::load_platform("xenos");
  return gpu;
}

/// n colour targets of `bits` and one 32-bit depth buffer.
std::vector<console::SurfaceShape> targets(int n, int bits, int width, int height, int samples) {
  std::vector<console::SurfaceShape> surfaces(static_cast<std::size_t>(n), {width, height, bits, samples});
  surfaces.push_back({width, height, 32, samples});
  return surfaces;
}

int tiles(const std::vector<console::SurfaceShape>& surfaces) {
  int sum = 0;
  for (const auto& surface : surfaces) sum += console::edram_tiles(xenos(), surface);
  return sum;
}

struct Column {
  int width, height, samples;
};
constexpr Column kColumns[] = {{1280, 720, 1}, {1280, 720, 2}, {1280, 720, 4}, {1152, 720, 1},
                               {1280, 672, 1}, {1024, 600, 1}, {1024, 576, 2}};

TEST(Edram, HoldsTenMebibytesOf80x16Tiles) { EXPECT_EQ(console::edram_capacity_tiles(xenos()), 2048); }

TEST(Edram, PassesMatchTheTable) {
  struct Row {
    int targets, bits;
    int passes[7];
  };
  constexpr Row kRows[] = {
      {1, 32, {1, 2, 3, 1, 1, 1, 1}}, {1, 64, {2, 3, 5, 1, 1, 1, 2}}, {2, 32, {2, 3, 5, 1, 1, 1, 2}},
      {3, 32, {2, 3, 6, 2, 2, 1, 2}}, {4, 32, {2, 4, 8, 2, 2, 2, 3}},
  };
  for (const Row& row : kRows) {
    for (std::size_t c = 0; c < 7; ++c) {
      const auto surfaces =
          targets(row.targets, row.bits, kColumns[c].width, kColumns[c].height, kColumns[c].samples);
      EXPECT_EQ(console::tiling_passes(xenos(), surfaces), row.passes[c])
          << row.targets << " x " << row.bits << " at " << kColumns[c].width << "x" << kColumns[c].height
          << " " << kColumns[c].samples << "x";
    }
  }
}

TEST(Edram, TileCountsMatchTheTable) {
  EXPECT_EQ(tiles(targets(1, 32, 1280, 720, 1)), 1440);
  EXPECT_EQ(tiles(targets(1, 32, 1280, 720, 2)), 2880);
  EXPECT_EQ(tiles(targets(1, 32, 1280, 720, 4)), 5760);
  EXPECT_EQ(tiles(targets(2, 32, 1280, 720, 1)), 2160);
  EXPECT_EQ(tiles(targets(1, 64, 1280, 720, 4)), 8640);
  EXPECT_EQ(tiles(targets(2, 32, 1152, 720, 1)), 2025);
  EXPECT_EQ(tiles(targets(2, 32, 1280, 672, 1)), 2016);
  EXPECT_EQ(tiles(targets(3, 32, 1024, 600, 1)), 1976);
  EXPECT_EQ(tiles(targets(4, 32, 1280, 720, 1)), 3600);
}

TEST(Edram, RefusesWhatTheMemoryCannotHold) {
  EXPECT_THROW(console::edram_tiles(xenos(), {0, 720, 32, 1}), UserError);
  EXPECT_THROW(console::edram_tiles(xenos(), {1280, 720, 128, 1}), UserError);
  EXPECT_THROW(console::edram_tiles(xenos(), {1280, 720, 32, 3}), UserError);
  EXPECT_THROW(console::edram_tiles(console::load_platform("rsx"), {1280, 720, 32, 1}), UserError);
}

}  // namespace
}  // namespace aluminate::test
