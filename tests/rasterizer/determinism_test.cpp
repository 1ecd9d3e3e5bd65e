// One picture, one bill, whatever the threads, the order of tiles, the skips and the vector unit.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <numeric>
#include <random>
#include <thread>

#include "rasterizer/vector_target.hpp"
#include "tests/rasterizer/suites.hpp"

namespace aluminate::raster::test {
namespace {

/// Really runs on n threads, and hands indices out in a shuffled order.
ParallelFor threads(int n) {
  return {n, [n](std::int64_t count, const ParallelFor::Item& item) {
            std::vector<std::int64_t> order(static_cast<std::size_t>(count));
            std::iota(order.begin(), order.end(), 0);
            std::shuffle(order.begin(), order.end(), std::mt19937(static_cast<unsigned>(n)));
            std::atomic<std::size_t> next{0};
            std::vector<std::thread> pool;
            for (int worker = 0; worker < n; ++worker)
              pool.emplace_back([&, worker] {
                for (std::size_t i; (i = next++) < order.size();) item(order[i], worker);
              });
            for (std::thread& t : pool) t.join();
          }};
}

/// Several chunks of mixed draws: opaque layers with equal depths, masked and blended ones.
Geometry busy_frame() {
  Geometry g;
  g.viewport = {333, 217};
  std::mt19937 random(99);
  const auto real = [&](double low, double high) { return low + (high - low) * (random() * 0x1p-32); };
  const auto soup = [&](int count, double size) {
    for (int i = 0; i < count; ++i) {
      const double cx = real(-10, 343), cy = real(-10, 227), depth = static_cast<double>(random() % 16) / 16;
      std::uint32_t v[3];
      for (std::uint32_t& corner : v) corner = g.add_pixel_vertex(cx + real(-size, size), cy + real(-size, size), depth + (random() % 2 ? real(0, 0.05) : 0), real(0.2, 3));
      g.add_triangle(v[0], v[1], v[2]);
    }
  };
  soup(3000, 12);
  g.end_draw();
  soup(300, 80);
  g.end_draw(CullMode::Back);
  soup(1500, 20);
  g.end_draw(CullMode::None, DrawClass::InOrder, true).execute_billed = true;
  soup(800, 30);
  g.end_draw(CullMode::None, DrawClass::InOrder, false);
  return g;
}

constexpr BillRule kRules[] = {{BillRule::Kind::Everything, 4}, {BillRule::Kind::Hierarchical, 4}, {BillRule::Kind::Hierarchical, 8},
                               {BillRule::Kind::Hierarchical, 16}, {BillRule::Kind::PerPixel, 4}};

class Samples : public testing::TestWithParam<int> {
 protected:
  static Geometry frame() {
    Geometry g = busy_frame();
    g.samples = GetParam();
    return g;
  }
};
INSTANTIATE_TEST_SUITE_P(Samples, Samples, testing::Values(1, 4), [](const auto& count) { return std::to_string(count.param) + "x"; });

TEST_P(Samples, ThreadCountAndTileOrderDoNotMatter) {
  const Geometry g = frame();
  const Picture expected = draw_expected(g, {});
  SetupCounters setup;
  TileCounters tiles;
  for (const int n : {1, 2, 3, 7, 16, 64}) {
    CandidateOptions options;
    options.threads = threads(n);
    options.tile_order_seed = static_cast<std::uint32_t>(n);
    const Picture picture = draw_candidate(g, options);
    EXPECT_EQ(difference(picture, expected), "") << n << " threads";
    if (n == 1) setup = picture.setup, tiles = picture.tiles;
    EXPECT_EQ(picture.setup, setup) << n << " threads";
    EXPECT_EQ(picture.tiles, tiles) << n << " threads";
  }
}

TEST(Determinism, AFrameCanBeReusedForAnotherViewport) {
  const Geometry big = busy_frame();
  Geometry small = busy_frame();
  small.viewport = {61, 40};
  Frame reused, fresh;
  reused.set_up(big.input(), serial());
  reused.set_up(small.input(), serial());
  fresh.set_up(small.input(), serial());
  ASSERT_EQ(reused.counters().bin_entries, fresh.counters().bin_entries);
  for (int tile = 0; tile < small.viewport.tile_count(); ++tile) {
    ASSERT_EQ(reused.tile_runs(tile).size(), fresh.tile_runs(tile).size());
    for (std::size_t run = 0; run < fresh.tile_runs(tile).size(); ++run)
      ASSERT_TRUE(std::ranges::equal(reused.tile_runs(tile)[run].records, fresh.tile_runs(tile)[run].records,
                                     [](const SetupTriangle& a, const SetupTriangle& b) { return a.id == b.id && a.z_min == b.z_min; }));
  }
}

TEST_P(Samples, AnySkipOffLeavesPictureAndBillAlone) {
  const Geometry g = frame();
  for (const BillRule& rule : kRules) {
    const Picture expected = draw_expected(g, rule);
    for (std::size_t skip = 0; skip <= kSkipNames.size(); ++skip) {
      CandidateOptions options;
      options.bill = rule;
      if (skip == kSkipNames.size()) options.skips = SkipSet::none();
      else options.skips.disable(static_cast<Skip>(skip));
      EXPECT_EQ(difference(draw_candidate(g, options), expected), "") << (skip < kSkipNames.size() ? kSkipNames[skip] : "all off") << " rule " << static_cast<int>(rule.kind);
    }
  }
}

TEST(Skips, EachOneSavesWorkAndCountsIt) {
  Geometry g = busy_frame();
  const std::uint32_t a = g.add_pixel_vertex(-500, 10, 0.5), b = g.add_pixel_vertex(-400, 10, 0.5), c = g.add_pixel_vertex(-450, 90, 0.5);
  g.add_triangle(a, b, c);
  const std::uint32_t d = g.add_pixel_vertex(20.6, 20.6, 0.5), e = g.add_pixel_vertex(20.7, 20.6, 0.5), f = g.add_pixel_vertex(20.6, 20.7, 0.5);
  g.add_triangle(d, e, f);
  g.end_draw(CullMode::None, DrawClass::InOrder, false);
  const Picture on = draw_candidate(g, {});
  CandidateOptions options;
  options.skips = SkipSet::none();
  const Picture off = draw_candidate(g, options);
  EXPECT_GT(on.setup.frustum, 0u);
  EXPECT_GT(on.setup.facing, 0u);
  EXPECT_GT(on.setup.small, 0u);
  EXPECT_GT(on.tiles.tile_hiz + on.tiles.block_hiz, 0u);
  EXPECT_GT(on.tiles.block_hiz, 0u);
  EXPECT_GT(on.tiles.early_z, 0u);
  EXPECT_EQ(off.setup.facing + off.setup.small + off.tiles.tile_hiz + off.tiles.block_hiz + off.tiles.early_z + off.tiles.occluded, 0u);
  EXPECT_GT(off.setup.bin_entries, on.setup.bin_entries);
  EXPECT_GT(off.tiles.quads_shaded, on.tiles.quads_shaded);
}

TEST(Skips, RunsBehindEverythingAreNotRead) {
  // A near wall, then a mesh of many chunks behind it.
  for (const int samples : {1, 4}) {
    Geometry g;
    g.viewport = {128, 128};
    g.samples = samples;
    const auto rectangle = [&g](double x0, double y0, double x1, double y1, double depth) {
      const std::uint32_t a = g.add_pixel_vertex(x0, y0, depth), b = g.add_pixel_vertex(x1, y0, depth), c = g.add_pixel_vertex(x0, y1, depth), d = g.add_pixel_vertex(x1, y1, depth);
      g.add_triangle(a, b, c);
      g.add_triangle(b, d, c);
    };
    rectangle(0, 0, 128, 128, 0.25);
    g.end_draw();
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x) rectangle(2 * x, 2 * y, 2 * x + 2, 2 * y + 2, 0.5);
    g.end_draw();
    rectangle(10, 10, 20, 20, 0.75);
    g.end_draw(CullMode::None, DrawClass::InOrder, false);
    const Picture expected = draw_expected(g, {}), on = draw_candidate(g, {});
    CandidateOptions options;
    options.skips.disable(Skip::Occluded);
    const Picture off = draw_candidate(g, options);
    EXPECT_EQ(difference(on, expected), "");
    EXPECT_EQ(difference(off, expected), "");
    EXPECT_EQ(off.tiles.occluded, 0u);
    EXPECT_GT(on.tiles.occluded, 7000u);  // all but those in the chunk of the wall
    EXPECT_EQ(on.tiles.occluded + on.tiles.tile_hiz, off.tiles.tile_hiz);
  }
}

TEST_P(Samples, WhatIsOneStepNearerThanTheFarthestIsSeen) {
  // A wall, a nearer speck at the pixel that stands for each block (and for the tile) when maxima are recomputed, then cells one
  // step before the wall: their least depth is the farthest stored one minus 1, so hierarchical depth has to let them pass.
  constexpr double kStep = 1.0 / kDepthMax, kWall = 9000000 * kStep;
  for (const double cell : {1.0, 7.0, 20.0, 64.0}) {
    Geometry g;
    g.viewport = {64, 64};
    g.samples = GetParam();
    const auto rectangle = [&g](double x0, double y0, double x1, double y1, double depth) {
      const std::uint32_t a = g.add_pixel_vertex(x0, y0, depth), b = g.add_pixel_vertex(x1, y0, depth), c = g.add_pixel_vertex(x0, y1, depth), d = g.add_pixel_vertex(x1, y1, depth);
      g.add_triangle(a, b, c);
      g.add_triangle(b, d, c);
    };
    rectangle(0, 0, 64, 64, kWall);
    for (int y = 8; y < 64; y += 16)
      for (int x = 0; x < 64; x += 16) rectangle(x, y, x + 1, y + 1, 0.25);
    rectangle(0, 32, 1, 33, 0.25);
    for (int y = 16; y < 64; y += 32)  // of the quarters: the smallest cells make it a hot tile
      for (int x = 0; x < 64; x += 32) rectangle(x, y, x + 1, y + 1, 0.25);
    g.end_draw(CullMode::None);
    constexpr int kSpecks = 21;
    constexpr std::uint32_t kFirstCell = 2 * (1 + kSpecks);
    for (double y = 0; y < 64; y += cell)
      for (double x = 0; x < 64; x += cell) rectangle(x, y, x + cell, y + cell, kWall - kStep);
    g.end_draw(CullMode::None);
    const Picture picture = draw_candidate(g, {});
    EXPECT_EQ(difference(picture, draw_expected(g, {})), "") << cell;
    for (const std::uint32_t id : picture.planes.visibility) ASSERT_TRUE(id >= 2 && id != kNoTriangle);  // nothing is left of the wall
    ASSERT_EQ(std::count_if(picture.planes.visibility.begin(), picture.planes.visibility.end(), [&](std::uint32_t id) { return id >= kFirstCell; }),
              static_cast<std::ptrdiff_t>(g.samples) * std::ptrdiff_t{64 * 64 - kSpecks});
  }
}

TEST_P(Samples, AHotTileIsDrawnInQuartersAndGivesTheSamePictureAndBill) {
  // Most of the triangles are in one corner tile that the viewport cuts; one layer covers everything.
  Geometry g;
  g.viewport = {150, 90};
  g.samples = GetParam();
  std::mt19937 random(7);
  const auto real = [&](double low, double high) { return low + (high - low) * (random() * 0x1p-32); };
  const auto soup = [&](int count, double x, double y, double width, double height, double size) {
    for (int i = 0; i < count; ++i) {
      const double cx = x + real(0, width), cy = y + real(0, height), depth = real(0.1, 0.9);
      std::uint32_t v[3];
      for (std::uint32_t& corner : v) corner = g.add_pixel_vertex(cx + real(-size, size), cy + real(-size, size), depth + real(0, 0.05), real(0.5, 2));
      g.add_triangle(v[0], v[1], v[2]);
    }
  };
  soup(3000, 66, 66, 62, 24, 5);
  soup(20, 0, 0, 150, 90, 60);
  g.end_draw(CullMode::None);
  soup(300, 60, 60, 80, 30, 12);
  g.end_draw(CullMode::None, DrawClass::InOrder, true);
  for (const BillRule& rule : kRules) {
    const Picture expected = draw_expected(g, rule);
    CandidateOptions options;
    options.bill = rule;
    EXPECT_EQ(difference(draw_candidate(g, options), expected), "") << static_cast<int>(rule.kind);
    options.skips = SkipSet::none();
    EXPECT_EQ(difference(draw_candidate(g, options), expected), "") << static_cast<int>(rule.kind) << " no skips";
  }
  Frame frame;
  frame.set_up(g.input(), serial());
  std::vector<int> quarters;
  for (const std::uint32_t number : frame.tile_order())
    if (number >= static_cast<std::uint32_t>(g.viewport.tile_count())) quarters.push_back(static_cast<int>(number));
  std::sort(quarters.begin(), quarters.end());
  EXPECT_EQ(quarters, (std::vector<int>{quarter_task(g.viewport, 4, 0), quarter_task(g.viewport, 4, 1)}));  // 26 px high: no lower quarters
  EXPECT_EQ(frame.tile_order().size() + static_cast<std::size_t>(frame.empty_tiles()), 7u);
}

TEST(Bill, NoSinkMeansNoBillAndTheSamePicture) {
  const Geometry g = busy_frame();
  Picture expected = draw_expected(g, {BillRule::Kind::Off, 4});
  CandidateOptions options;
  options.with_bill = false;
  EXPECT_EQ(difference(draw_candidate(g, options), expected), "");
}

TEST(Bill, StampsOfATriangleMeetALargeBlockInAscendingOrder) {
  // Everything but stamp 2 of a 16x16 block is at 0.5; a triangle at 0.6 over all of it is billed until it has filled stamp 2
  // itself: from then on the farthest depth is its own.
  Geometry g;
  g.viewport = {16, 16};
  const auto rectangle = [&g](double x0, double y0, double x1, double y1, double depth) {
    const std::uint32_t a = g.add_pixel_vertex(x0, y0, depth), b = g.add_pixel_vertex(x1, y0, depth), c = g.add_pixel_vertex(x0, y1, depth), d = g.add_pixel_vertex(x1, y1, depth);
    g.add_triangle(a, b, c);
    g.add_triangle(b, d, c);
  };
  rectangle(0, 0, 16, 4, 0.5);
  rectangle(4, 4, 16, 8, 0.5);
  rectangle(0, 8, 16, 16, 0.5);
  g.end_draw();
  const std::uint32_t a = g.add_pixel_vertex(-1, -1, 0.6), b = g.add_pixel_vertex(40, -1, 0.6), c = g.add_pixel_vertex(-1, 40, 0.6);
  g.add_triangle(a, b, c);
  g.end_draw();
  CandidateOptions options;
  options.bill = {BillRule::Kind::Hierarchical, 16};
  const Picture picture = draw_candidate(g, options);
  EXPECT_EQ(picture.planes.billed_per_draw[1], 3u * 16);
  EXPECT_EQ(difference(picture, draw_expected(g, options.bill)), "");
}

TEST(Bill, RulesOrderTheirTotals) {
  const Geometry g = busy_frame();
  std::vector<std::uint64_t> totals;
  for (const BillRule& rule : kRules) {
    CandidateOptions options;
    options.bill = rule;
    const Picture picture = draw_candidate(g, options);
    totals.push_back(std::accumulate(picture.planes.billed_per_draw.begin(), picture.planes.billed_per_draw.end(), std::uint64_t{0}));
  }
  // Coarser blocks reject less; a per-pixel test rejects most.
  EXPECT_GT(totals[0], totals[3]);
  EXPECT_GE(totals[3], totals[2]);
  EXPECT_GE(totals[2], totals[1]);
  EXPECT_GT(totals[1], totals[4]);
}

class VectorUnits : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { use_vector_target(GetParam()); }
  void TearDown() override { use_vector_target(""); }
};
INSTANTIATE_TEST_SUITE_P(Units, VectorUnits, testing::ValuesIn(vector_targets()), [](const auto& unit) { return unit.param; });

TEST_P(VectorUnits, DrawTheSamePictureAndBill) {
  const Geometry g = busy_frame();
  for (const BillRule& rule : kRules) {
    CandidateOptions options;
    options.bill = rule;
    EXPECT_EQ(difference(draw_candidate(g, options), draw_expected(g, rule)), "");
  }
}

TEST_P(VectorUnits, PassEveryConformanceSuiteOnItsFirstSeeds) {
  for (const Suite& suite : suites()) {
    if (suite.name == "large-viewport") continue;
    for (std::uint32_t seed = 0; seed < 3; ++seed) {
      const SuiteCase test = suite.make(seed);
      CandidateOptions options;
      options.bill = test.bill;
      EXPECT_EQ(difference(draw_candidate(test.geometry, options), draw_expected(test.geometry, test.bill)), "") << suite.name << " " << seed;
    }
  }
}

}  // namespace
}  // namespace aluminate::raster::test
