#include "rasterizer/interpolate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "rasterizer/quads.hpp"
#include "rasterizer/vector_target.hpp"
#include "tests/rasterizer/candidate.hpp"

namespace aluminate::raster {
namespace {

using test::Geometry;
__extension__ using Wide = __int128;

/// A frame of one triangle and its visible quads.
struct OneTriangle {
  Geometry geometry;
  Frame frame;
  std::vector<VisibleQuad> quads;

  void draw(CullMode cull = CullMode::None) {
    geometry.end_draw(cull);
    frame.set_up(geometry.input(), serial());
    TileRasterizer tiles(frame, {});
    std::vector<VisibleQuad> tile_quads;
    for (const std::uint32_t tile : frame.tile_order()) {
      tiles.begin(static_cast<int>(tile));
      tiles.draw_opaque(nullptr);
      gather_visible_quads(frame, tiles.view(), tile_quads);
      quads.insert(quads.end(), tile_quads.begin(), tile_quads.end());
    }
  }
};

/// visit(quad, lane, b1, b2) for every lane, helpers included.
template <class Visit>
void for_each_lane(const OneTriangle& t, Visit&& visit) {
  BarycentricRows rows;
  for (std::size_t first = 0; first < t.quads.size(); first += kBatchQuads) {
    std::vector<QuadPosition> batch;
    for (std::size_t q = first; q < std::min(first + kBatchQuads, t.quads.size()); ++q)
      batch.push_back({t.quads[q].triangle, t.quads[q].x, t.quads[q].y});
    interpolate_barycentrics(t.frame, batch, rows);
    for (std::size_t q = 0; q < batch.size(); ++q)
      for (std::size_t lane = 0; lane < 4; ++lane) visit(t.quads[first + q], lane, rows.b1[4 * q + lane], rows.b2[4 * q + lane]);
  }
}

bool on_grid(double value) { return value * 0x1p31 == std::nearbyint(value * 0x1p31) && std::fabs(value) < 0x1p20; }

/// Exact perspective barycentrics of the snapped triangle with integer w, as a quotient of integers.
struct Exact {
  Wide numerator[3];
  Wide sum;
};
Exact exact_at(const TriangleInfo& t, const long long (&w)[3], int px, int py) {
  const Wide x = Wide{px} * 256 + 128, y = Wide{py} * 256 + 128;
  Exact exact{{}, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
    const Wide edge = Wide{t.x[b] - t.x[a]} * (y - t.y[a]) - Wide{t.y[b] - t.y[a]} * (x - t.x[a]);
    exact.numerator[t.corner[k]] = edge * w[t.corner[a]] * w[t.corner[b]];  // E / w times the product of all w
    exact.sum += exact.numerator[t.corner[k]];
  }
  return exact;
}

/// |value - numerator / sum| in units of 2^-60, exactly enough: the quotient is expanded in integers.
double error_of(double value, Wide numerator, Wide sum) {
  const Wide whole = numerator / sum, rest = numerator % sum;
  const double exact = static_cast<double>(whole) + static_cast<double>(rest) / static_cast<double>(sum);
  return std::fabs(value - exact);
}

class EveryVectorUnit : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { use_vector_target(GetParam()); }
  void TearDown() override { use_vector_target(""); }
};
INSTANTIATE_TEST_SUITE_P(Units, EveryVectorUnit, testing::ValuesIn(vector_targets()), [](const auto& unit) { return unit.param; });

TEST_P(EveryVectorUnit, BarycentricsAgreeWithRationalArithmetic) {
  std::mt19937 random(7);
  std::size_t lanes = 0;
  for (int i = 0; i < 60; ++i) {
    OneTriangle t;
    t.geometry.viewport = {200, 150};
    // w ratios up to 10^6: what a near plane at 0.001 makes of a scene of 1 km.
    const long long top = i % 3 == 0 ? 1000000 : i % 3 == 1 ? 1000 : 4;
    long long w[3];
    for (long long& v : w) v = 1 + static_cast<long long>(random() % static_cast<std::uint32_t>(top));
    if (i == 0) w[0] = 1, w[1] = 1000000, w[2] = 1000000;
    std::uint32_t v[3];
    for (std::size_t k = 0; k < 3; ++k)
      v[k] = t.geometry.add_pixel_vertex(random() % 300 - 50.0 + (random() % 256) / 256.0, random() % 250 - 50.0, 0.5, static_cast<double>(w[k]));
    t.geometry.add_triangle(v[0], v[1], v[2]);
    t.draw();
    for_each_lane(t, [&](const VisibleQuad& quad, std::size_t lane, double b1, double b2) {
      ASSERT_TRUE(on_grid(b1) && on_grid(b2));
      if ((quad.lanes >> lane & 1) == 0) return;
      const Exact exact = exact_at(t.frame.triangle(quad.triangle), w, quad.x + static_cast<int>(lane & 1), quad.y + static_cast<int>(lane >> 1));
      // Half a grid step, twice for the corner that is one minus the others, plus a few roundings of 2^-53.
      constexpr double kBound = 0x1p-31 + 0x1p-49;
      ASSERT_LE(error_of(b1, exact.numerator[1], exact.sum), kBound);
      ASSERT_LE(error_of(b2, exact.numerator[2], exact.sum), kBound);
      ++lanes;
    });
  }
  EXPECT_GT(lanes, 50000u);
}

TEST_P(EveryVectorUnit, AttributeErrorStaysBelow2ToMinus28OfItsRange) {
  std::mt19937 random(11);
  double worst = 0;
  for (int i = 0; i < 30; ++i) {
    OneTriangle t;
    t.geometry.viewport = {160, 160};
    long long w[3];
    for (long long& v : w) v = 1 + static_cast<long long>(random() % 50);
    std::uint32_t v[3];
    for (std::size_t k = 0; k < 3; ++k) v[k] = t.geometry.add_pixel_vertex(random() % 200 - 20.0, random() % 200 - 20.0, 0.5, static_cast<double>(w[k]));
    t.geometry.add_triangle(v[0], v[1], v[2]);
    t.draw();
    // Attributes on the grid with a range of about 1 to 1000.
    const double scale = std::ldexp(1.0, i % 11);
    double a[3];
    for (double& value : a) value = to_fx31((random() * 0x1p-32 - 0.5) * scale);
    const double range = std::max({a[0], a[1], a[2]}) - std::min({a[0], a[1], a[2]});
    if (range < 0.25 * scale) continue;
    BarycentricRows rows;
    std::array<double, kBatchQuads> a0, d1, d2;
    a0.fill(a[0]), d1.fill(a[1] - a[0]), d2.fill(a[2] - a[0]);
    std::array<double, kBatchLanes> out;
    for (const VisibleQuad& quad : t.quads) {
      const QuadPosition position{quad.triangle, quad.x, quad.y};
      interpolate_barycentrics(t.frame, {&position, 1}, rows);
      interpolate_attribute(rows, a0, d1, d2, out);
      for (std::size_t lane = 0; lane < 4; ++lane) {
        if ((quad.lanes >> lane & 1) == 0) continue;
        const Exact exact = exact_at(t.frame.triangle(quad.triangle), w, quad.x + static_cast<int>(lane & 1), quad.y + static_cast<int>(lane >> 1));
        const double sum = static_cast<double>(exact.sum);
        const double expected = a[0] + (a[1] - a[0]) * (static_cast<double>(exact.numerator[1]) / sum) + (a[2] - a[0]) * (static_cast<double>(exact.numerator[2]) / sum);
        ASSERT_TRUE(on_grid(out[lane]));
        worst = std::max(worst, std::fabs(out[lane] - expected) / range);
      }
    }
  }
  EXPECT_GT(worst, 0.0);
  EXPECT_LT(worst, 0x1p-28);
}

TEST_P(EveryVectorUnit, ConstantsStayConstantInEveryLaneHelpersIncluded) {
  std::mt19937 random(3);
  std::size_t lanes = 0;
  for (int i = 0; i < 40; ++i) {
    OneTriangle t;
    t.geometry.viewport = {64, 64};
    std::uint32_t v[3];
    for (std::uint32_t& corner : v) corner = t.geometry.add_pixel_vertex(random() % 64, random() % 64, 0.5, 1 + random() % 100);
    t.geometry.add_triangle(v[0], v[1], v[2]);
    t.draw();
    BarycentricRows rows;
    std::array<double, kBatchQuads> a0, zero{};
    const double constant = to_fx31(random() * 0x1p-30);
    a0.fill(constant);
    std::array<double, kBatchLanes> out;
    for (const VisibleQuad& quad : t.quads) {
      const QuadPosition position{quad.triangle, quad.x, quad.y};
      interpolate_barycentrics(t.frame, {&position, 1}, rows);
      interpolate_attribute(rows, a0, zero, zero, out);
      for (std::size_t lane = 0; lane < 4; ++lane, ++lanes) ASSERT_EQ(out[lane], constant);
    }
  }
  EXPECT_GT(lanes, 1000u);
}

TEST_P(EveryVectorUnit, AllAttributesAtOnceAreTheSameBits) {
  std::mt19937 random(17);
  for (std::size_t quads = 1; quads <= kBatchQuads; ++quads) {
    BarycentricRows rows;
    for (std::size_t lane = 0; lane < kBatchLanes; ++lane) {
      rows.b1[lane] = to_fx31(random() * 0x1p-30 - 2);
      rows.b2[lane] = to_fx31(random() * 0x1p-30 - 2);
    }
    constexpr std::size_t kAttributes = 5;
    std::array<std::array<std::array<double, kAttributes>, 3>, kBatchQuads> values;
    std::array<AttributeCorners, kBatchQuads> corners;
    for (std::size_t q = 0; q < kBatchQuads; ++q)
      for (std::size_t k = 0; k < 3; ++k) {
        for (double& value : values[q][k]) value = to_fx31(random() * 0x1p-26 - 32);
        corners[q][k] = values[q][k].data();
      }
    // Two attributes are read by nobody, and the rows of the others are in another order.
    const std::array<AttributeRow, 3> wanted{{{4, 0}, {0, 3}, {2, 1}}};
    alignas(64) std::array<double, 4 * kBatchLanes> out;
    out.fill(77);
    const double greatest = interpolate_attributes(rows, {corners.data(), quads}, wanted, out.data());
    double expected_greatest = 0;
    for (const AttributeRow& row : wanted) {
      std::array<double, kBatchQuads> a0, d1, d2;
      for (std::size_t q = 0; q < kBatchQuads; ++q) {
        a0[q] = corners[q][0][row.attribute];
        d1[q] = corners[q][1][row.attribute] - a0[q];
        d2[q] = corners[q][2][row.attribute] - a0[q];
      }
      std::array<double, kBatchLanes> expected;
      interpolate_attribute(rows, a0, d1, d2, expected);
      for (std::size_t lane = 0; lane < kBatchLanes; ++lane) {
        const bool inside = lane < 4 * quads;
        ASSERT_EQ(out[row.row * kBatchLanes + lane], inside ? expected[lane] : 0.0);
        if (inside) expected_greatest = std::max(expected_greatest, std::fabs(expected[lane]));
      }
    }
    ASSERT_EQ(greatest, expected_greatest);
    for (std::size_t lane = 0; lane < kBatchLanes; ++lane) ASSERT_EQ(out[2 * kBatchLanes + lane], 77);
  }
}

TEST_P(EveryVectorUnit, HelperLanesExtrapolateThePlane) {
  // Orthographic: b is linear in the pixel, inside and outside, as long as it stays within the limit.
  OneTriangle t;
  t.geometry.viewport = {32, 32};
  const std::uint32_t a = t.geometry.add_pixel_vertex(4, 4, 0.5), b = t.geometry.add_pixel_vertex(12, 4, 0.5), c = t.geometry.add_pixel_vertex(4, 20, 0.5);
  t.geometry.add_triangle(a, b, c);
  t.draw();
  bool helper_seen = false;
  for_each_lane(t, [&](const VisibleQuad& quad, std::size_t lane, double b1, double b2) {
    const double x = quad.x + static_cast<double>(lane & 1) + 0.5, y = quad.y + static_cast<double>(lane >> 1) + 0.5;
    EXPECT_EQ(b1, (x - 4) / 8);   // multiples of 1/16 and 1/32: exact
    EXPECT_EQ(b2, (y - 4) / 16);
    helper_seen = helper_seen || (quad.lanes >> lane & 1) == 0;
  });
  EXPECT_TRUE(helper_seen);
}

TEST_P(EveryVectorUnit, ExtrapolationIsLimitedBeyondTheHorizon) {
  OneTriangle t;
  t.geometry.viewport = {64, 64};
  // w falls from 1000 to 0.001 across a few pixels: helper lanes of the near corner lie behind the eye.
  const std::uint32_t a = t.geometry.add_pixel_vertex(2, 2, 0.5, 1000), b = t.geometry.add_pixel_vertex(60, 3, 0.5, 1000), c = t.geometry.add_pixel_vertex(30.2, 40.6, 0.5, 0.001);
  t.geometry.add_triangle(a, b, c);
  t.draw();
  ASSERT_FALSE(t.quads.empty());
  for_each_lane(t, [&](const VisibleQuad& quad, std::size_t lane, double b1, double b2) {
    ASSERT_TRUE(on_grid(b1) && on_grid(b2));
    ASSERT_LE(std::fabs(b1), kBarycentricLimit);
    ASSERT_LE(std::fabs(b2), kBarycentricLimit);
    if (quad.lanes >> lane & 1) {
      ASSERT_GE(std::min({b1, b2, 1 - b1 - b2}), 0.0 - 0x1p-30);
    }
  });
}

TEST_P(EveryVectorUnit, BeyondTheHorizonOnAnEdgeThereIsNoDivisionByZero) {
  // Lane 2 of the quad at (2, 10) lies half a pixel beyond corner c, where 1/w is negative, on the line of the left edge,
  // where b1 is 0: unguarded, 0 / 0.
  OneTriangle t;
  t.geometry.viewport = {32, 32};
  const std::uint32_t a = t.geometry.add_pixel_vertex(2.5, 2.5, 0.5, 1), b = t.geometry.add_pixel_vertex(10.5, 2.5, 0.5, 1), c = t.geometry.add_pixel_vertex(2.5, 11, 0.5, 1000);
  t.geometry.add_triangle(a, b, c);
  t.draw();
  bool seen = false;
  for_each_lane(t, [&](const VisibleQuad& quad, std::size_t lane, double b1, double b2) {
    ASSERT_TRUE(on_grid(b1) && on_grid(b2));
    if (quad.x != 2 || quad.y != 10 || lane != 2) return;
    EXPECT_EQ(b1, 0);
    EXPECT_EQ(b2, kBarycentricLimit);
    seen = true;
  });
  EXPECT_TRUE(seen);
}

TEST_P(EveryVectorUnit, CornersKeepTheirSubmittedNumbersInEveryOrderAndWinding) {
  int order[3] = {0, 1, 2};
  const double px[3] = {3, 40, 10}, py[3] = {5, 12, 50};
  do {
    OneTriangle t;
    t.geometry.viewport = {64, 64};
    for (const int k : order) t.geometry.add_pixel_vertex(px[k], py[k], 0.5);
    t.geometry.add_triangle(0, 1, 2);
    t.draw();
    for_each_lane(t, [&](const VisibleQuad& quad, std::size_t lane, double b1, double b2) {
      const double b0 = 1 - b1 - b2;
      const double x = b0 * px[order[0]] + b1 * px[order[1]] + b2 * px[order[2]], y = b0 * py[order[0]] + b1 * py[order[1]] + b2 * py[order[2]];
      ASSERT_NEAR(x, quad.x + static_cast<double>(lane & 1) + 0.5, 1e-6);  // 3 * 64 px * 2^-32
      ASSERT_NEAR(y, quad.y + static_cast<double>(lane >> 1) + 0.5, 1e-6);
    });
    ASSERT_FALSE(t.quads.empty());
  } while (std::next_permutation(order, order + 3));
}

TEST(ClippedFragments, InterpolateTheSubmittedTriangle) {
  // One corner behind the eye. Attribute = w: at every pixel 1/w is linear on the screen, so w can be recomputed from z/w.
  OneTriangle t;
  t.geometry.viewport = {64, 64};
  const double near = 0.1, far = 100;
  const auto add = [&](double x, double y, double w) { return t.geometry.add_vertex(x, y, (w - near) * far / (far - near), w); };
  const std::uint32_t a = add(-1, -1, 3), b = add(2, -1, 4), c = add(0.5, -0.2, -2);
  t.geometry.add_triangle(a, b, c);
  t.draw();
  ASSERT_EQ(t.frame.counters().clipped, 1u);
  ASSERT_FALSE(t.quads.empty());
  const double x[3] = {-1, 2, 0.5}, y[3] = {-1, -1, -0.2}, w[3] = {3, 4, -2};
  for_each_lane(t, [&](const VisibleQuad& quad, std::size_t lane, double b1, double b2) {
    if ((quad.lanes >> lane & 1) == 0) return;
    const double b0 = 1 - b1 - b2;
    const double clip_x = b0 * x[0] + b1 * x[1] + b2 * x[2], clip_y = b0 * y[0] + b1 * y[1] + b2 * y[2], clip_w = b0 * w[0] + b1 * w[1] + b2 * w[2];
    // The corners moved by up to half a sub when they were snapped, at w near 0.1 and far out: a tenth of a pixel at most here.
    ASSERT_NEAR((clip_x / clip_w + 1) * 32, quad.x + static_cast<double>(lane & 1) + 0.5, 0.1);
    ASSERT_NEAR((1 - clip_y / clip_w) * 32, quad.y + static_cast<double>(lane >> 1) + 0.5, 0.1);
  });
}

}  // namespace
}  // namespace aluminate::raster
