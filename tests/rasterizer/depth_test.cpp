// Depth against exact rational arithmetic, and the sides of its definition.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "rasterizer/canonical.hpp"
#include "rasterizer/reference_raster.hpp"
#include "tests/rasterizer/candidate.hpp"

namespace aluminate::raster::test {
namespace {

__extension__ using Wide = __int128;

std::uint32_t depth_of_pixel(const SetupTriangle& t, int x, int y) {
  const TileOrigin tile{x & ~(kTilePx - 1), y & ~(kTilePx - 1)};
  const DepthSteps s = depth_steps(t, tile);
  const std::uint32_t lanes = anchor_of(centre_plane(s, (x - tile.x) & ~3, (y - tile.y) & ~3)) + s.lane_x * static_cast<std::uint32_t>(x & 3) + s.lane_y * static_cast<std::uint32_t>(y & 3);
  return static_cast<std::uint32_t>(std::clamp(static_cast<std::int32_t>(lanes) >> kStampDepthBits, s.z_min, s.z_max));
}

/// Depth minus the exact plane through the snapped corners, in D24 steps.
double depth_error(const SetupTriangle& t, int x, int y) {
  const Wide px = Wide{x} * 256 + 128, py = Wide{y} * 256 + 128;
  Wide sum = 0, area = 0;
  for (int k = 0; k < 3; ++k) {
    const int a = (k + 1) % 3, b = (k + 2) % 3;
    const Wide edge = Wide{t.x[b] - t.x[a]} * (py - t.y[a]) - Wide{t.y[b] - t.y[a]} * (px - t.x[a]);
    sum += edge * t.z4[k];
    area += edge;
  }
  const Wide difference = Wide{depth_of_pixel(t, x, y)} * 16 * area - sum;  // exact, below 2^28 * 2^47
  return static_cast<double>(difference) / static_cast<double>(area) / 16;
}

SetupTriangle make(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c) {
  const ScreenVertex v[3] = {a, b, c};
  const CanonicalOrder order = canonical_order(a, b, c);
  SetupTriangle t{};
  fill_corners(v[order.corner[0]], v[order.corner[1]], v[order.corner[2]], t);
  return t;
}

TEST(Depth, IsWithinItsBoundOfTheExactPlane) {
  // The documented bound: 1/2 + 2^-7 + 6 * 2^-8 + 2^-13.
  constexpr double kBound = 0.5 + 0x1p-7 + 6 * 0x1p-8 + 0x1p-13;
  std::mt19937 random(5);
  std::size_t pixels = 0;
  double worst = 0;
  for (int i = 0; i < 400; ++i) {
    const int extent = i % 4 == 0 ? 16000 : 200;  // px, on either side of the sampled window
    ScreenVertex v[3];
    for (ScreenVertex& corner : v) {
      corner.x = static_cast<std::int32_t>(random() % static_cast<unsigned>(2 * extent * 256)) - extent * 256 + 100 * 256;
      corner.y = static_cast<std::int32_t>(random() % static_cast<unsigned>(2 * extent * 256)) - extent * 256 + 100 * 256;
      corner.z4 = static_cast<std::int32_t>(random() % (kDepthMax * 16 + 1));
    }
    if (twice_area(v[0], v[1], v[2]) == 0) continue;
    const SetupTriangle t = make(v[0], v[1], v[2]);
    for (int y = 0; y < 200; y += 3)
      for (int x = 0; x < 200; x += 3)
        if (covers_pixel<1>(t, x, y)) {
          const double error = std::fabs(depth_error(t, x, y));
          worst = std::max(worst, error);
          ASSERT_LE(error, kBound) << "triangle " << i << " at " << x << ", " << y;
          ++pixels;
        }
  }
  EXPECT_GT(pixels, 20000u);
  EXPECT_GT(worst, 0.49);  // the bound is not idle
}

TEST(Depth, OfAConstantTriangleIsThatDepthAtEveryPixel) {
  std::mt19937 random(6);
  for (int i = 0; i < 200; ++i) {
    const auto z4 = static_cast<std::int32_t>(random() % (kDepthMax + 1)) * 16;
    ScreenVertex v[3];
    for (ScreenVertex& corner : v) corner = {static_cast<std::int32_t>(random() % 60000), static_cast<std::int32_t>(random() % 60000), z4, 0};
    if (twice_area(v[0], v[1], v[2]) == 0) continue;
    const SetupTriangle t = make(v[0], v[1], v[2]);
    for (int y = 0; y < 230; y += 7)
      for (int x = 0; x < 230; x += 7) ASSERT_EQ(depth_of_pixel(t, x, y), static_cast<std::uint32_t>(z4) / 16);  // outside as well
  }
}

TEST(Depth, OfASliverStaysWithinItsCorners) {
  // Twice the area is 1 sub^2 and depth spans the whole range: slopes saturate.
  const SetupTriangle t = make({0, 0, 0, 0}, {2584, 1597, static_cast<std::int32_t>(kDepthMax) * 16, 0}, {4181, 2584, 160, 0});
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 18; ++x) {
      const std::uint32_t z = depth_of_pixel(t, x, y);
      EXPECT_LE(z, kDepthMax);
    }
}

TEST(Depth, DoesNotDependOnTheOrderOfCorners) {
  std::mt19937 random(8);
  for (int i = 0; i < 100; ++i) {
    ScreenVertex v[3];
    for (ScreenVertex& corner : v) corner = {static_cast<std::int32_t>(random() % 20000), static_cast<std::int32_t>(random() % 20000), static_cast<std::int32_t>(random() % (kDepthMax * 16)), 0};
    if (twice_area(v[0], v[1], v[2]) == 0) continue;
    const SetupTriangle first = make(v[0], v[1], v[2]);
    int order[3] = {0, 1, 2};
    while (std::next_permutation(order, order + 3)) {
      const SetupTriangle other = make(v[order[0]], v[order[1]], v[order[2]]);
      for (int k = 0; k < 3; ++k) ASSERT_TRUE(first.x[k] == other.x[k] && first.y[k] == other.y[k] && first.z4[k] == other.z4[k]);
    }
  }
}

TEST(Depth, OrthographicVerticesSnapExactly) {
  const ScreenMap map({640, 480});
  const ScreenVertex v = project_vertex(map, 0.25, -0.5, 0.5, 1);
  EXPECT_EQ(v.x, 400 * 256);
  EXPECT_EQ(v.y, 360 * 256);
  EXPECT_EQ(v.z4, static_cast<std::int32_t>(kDepthMax) * 8);
  EXPECT_EQ(v.flags, 0u);
}

TEST(Depth, FarPlaneItselfIsNotDrawnOverTheClearedBuffer) {
  Geometry g;
  const std::uint32_t a = g.add_pixel_vertex(0, 0, 1), b = g.add_pixel_vertex(64, 0, 1), c = g.add_pixel_vertex(0, 64, 1);
  g.add_triangle(a, b, c);
  g.end_draw();
  const Picture picture = draw_candidate(g, {});
  for (const std::uint32_t id : picture.planes.visibility) EXPECT_EQ(id, kNoTriangle);
}

}  // namespace
}  // namespace aluminate::raster::test
