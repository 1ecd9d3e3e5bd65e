// Set-up: what is dropped, what is counted, how cut edges meet, and that vectors project like the scalar definition.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>

#include "platform/host/error.hpp"
#include "rasterizer/canonical.hpp"
#include "rasterizer/clip.hpp"
#include "rasterizer/quads.hpp"
#include "rasterizer/triangle_setup.hpp"
#include "rasterizer/vector_target.hpp"
#include "tests/rasterizer/candidate.hpp"

namespace aluminate::raster::test {
namespace {

TEST(SetUp, DropsTrianglesWithNonFiniteCornersWholeAndCountsThem) {
  Geometry g;
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  const std::uint32_t a = g.add_pixel_vertex(1, 1, 0.5), b = g.add_pixel_vertex(60, 1, 0.5), c = g.add_pixel_vertex(1, 60, 0.5);
  for (const double bad : {inf, -inf, nan})
    for (int component = 0; component < 4; ++component) {
      double v[4] = {0, 0, 0.5, 1};
      v[component] = bad;
      g.add_triangle(a, b, g.add_vertex(v[0], v[1], v[2], v[3]));
    }
  g.add_triangle(a, b, c);
  g.end_draw();
  Frame frame;
  frame.set_up(g.input(), serial());
  EXPECT_EQ(frame.counters().dropped_nonfinite, 12u);
  EXPECT_EQ(frame.counters().binned, 1u);
}

TEST(SetUp, SharedCutEdgesGetBitIdenticalCorners) {
  std::mt19937 random(21);
  const ScreenMap map({640, 480});
  const auto real = [&](double low, double high) { return low + (high - low) * (random() * 0x1p-32); };
  int cut = 0;
  for (int i = 0; i < 2000; ++i) {
    ClipCorner shared[2], apex[2];
    for (ClipCorner* c : {&shared[0], &shared[1], &apex[0], &apex[1]}) *c = {real(-200, 200), real(-200, 200), real(-1, 2), real(-1, 2), 0, 0};
    const ClipPolygon left = clip_triangle(map, shared[0], shared[1], apex[0]), right = clip_triangle(map, apex[1], shared[1], shared[0]);
    // The shared edge seen from both sides: reclip it alone, as a flat triangle, and find its ends in both polygons.
    const auto on_edge = [&](const ClipPolygon& polygon) {
      std::vector<std::array<double, 4>> points;
      const ClipPolygon edge = clip_triangle(map, shared[0], shared[1], shared[0]);
      for (int e = 0; e < edge.count; ++e)
        for (int k = 0; k < polygon.count; ++k) {
          const ClipCorner &p = edge.corner[static_cast<std::size_t>(e)], &q = polygon.corner[static_cast<std::size_t>(k)];
          if (std::memcmp(&p, &q, 4 * sizeof(double)) == 0) points.push_back({p.x, p.y, p.z, p.w});
        }
      std::sort(points.begin(), points.end());
      points.erase(std::unique(points.begin(), points.end()), points.end());
      return points;
    };
    const auto l = on_edge(left), r = on_edge(right);
    EXPECT_EQ(l, r);
    const ClipPolygon edge = clip_triangle(map, shared[0], shared[1], shared[0]);
    if (edge.count != 0 && l.size() >= 2 && (l[0] != std::array{shared[0].x, shared[0].y, shared[0].z, shared[0].w})) ++cut;
  }
  EXPECT_GT(cut, 100);
}

TEST(SetUp, CutCornersLieExactlyOnTheDepthPlanes) {
  std::mt19937 random(23);
  const ScreenMap map({640, 480});
  int near = 0, far = 0;
  for (int i = 0; i < 500; ++i) {
    ClipCorner v[3];
    for (ClipCorner& c : v) c = {0, 0, (random() * 0x1p-32 - 0.3) * 1e6, 1 + random() * 0x1p-12, 0, 0};
    const ClipPolygon polygon = clip_triangle(map, v[0], v[1], v[2]);
    for (int k = 0; k < polygon.count; ++k) {
      const ClipCorner& c = polygon.corner[static_cast<std::size_t>(k)];
      const bool submitted = std::any_of(v, v + 3, [&](const ClipCorner& s) { return s.z == c.z && s.w == c.w; });
      if (submitted) continue;
      EXPECT_TRUE(c.z == 0 || c.z == c.w) << c.z << " " << c.w;
      near += c.z == 0;
      far += c.z == c.w;
    }
  }
  EXPECT_GT(near, 50);
  EXPECT_GT(far, 50);
}

TEST(SetUp, VectorProjectionIsTheScalarOneBitForBit) {
  std::mt19937 random(31);
  const ScreenMap map({1279, 717});
  std::vector<double> p[4];
  for (int i = 0; i < 5000; ++i) {
    // Groups wholly inside, groups wholly outside, and mixed ones; values whose quotients tie on a sub.
    const bool inside = i / 64 % 3 != 0, beside = i / 64 % 3 == 1;  // beside: beyond the sides, within the guard band
    const double w = inside ? 0.5 + random() * 0x1p-31 : random() * 0x1p-31 - 1, range = beside ? 3 * w : inside ? w : 3;
    for (int k = 0; k < 2; ++k) p[k].push_back(range * (random() * 0x1p-31 - 1));
    p[2].push_back(inside ? w * (random() * 0x1p-32) : random() * 0x1p-31 - 0.5);
    p[3].push_back(w);
  }
  p[0][100] = std::numeric_limits<double>::quiet_NaN();
  p[3][200] = 0;
  p[3][300] = 1e-320;
  for (const std::string& unit : vector_targets()) {
    use_vector_target(unit);
    std::vector<ScreenVertex> out(p[0].size());
    project_vertices(map, {p[0], p[1], p[2], p[3]}, 0, out.size(), out.data());
    for (std::size_t i = 0; i < out.size(); ++i) {
      const ScreenVertex expected = project_vertex(map, p[0][i], p[1][i], p[2][i], p[3][i]);
      ASSERT_EQ(std::memcmp(&out[i], &expected, sizeof expected), 0) << unit << " vertex " << i;
    }
  }
  use_vector_target("");
}

// Written out, because the reference rasterizer, the vectors and the exact coverage test all start from snap_vertex's integers:
// none of them would see another rule.
TEST(SetUp, CornersSnapToTheNearestSubAndTiesToTheEvenOne) {
  const ScreenMap map({512, 512});  // half of it is 2^16 sub: every tie below is exact in binary
  const auto sub_x = [&](double sub, double w) { return project_vertex(map, (sub / 65536 - 1) * w, 0, 0, w).x; };
  const auto sub_y = [&](double sub, double w) { return project_vertex(map, 0, (1 - sub / 65536) * w, 0, w).y; };
  for (const double w : {1.0, 0.25, 8.0})
    for (const int sub : {-70000, -3, -2, -1, 0, 1, 2, 1023, 1024, 131071, 4000001}) {
      const int even = sub % 2 == 0 ? sub : sub + 1;
      EXPECT_EQ(sub_x(sub, w), sub);
      EXPECT_EQ(sub_y(sub, w), sub);
      EXPECT_EQ(sub_x(sub + 0.5, w), even) << sub << " w " << w;
      EXPECT_EQ(sub_y(sub + 0.5, w), even) << sub << " w " << w;
      EXPECT_EQ(sub_x(sub + 0.5 - 0x1p-10, w), sub);
      EXPECT_EQ(sub_x(sub + 0.5 + 0x1p-10, w), sub + 1);
      EXPECT_EQ(sub_y(sub + 0.5 - 0x1p-10, w), sub);
      EXPECT_EQ(sub_y(sub + 0.5 + 0x1p-10, w), sub + 1);
    }
  // Depth: 2^28 - 16 steps, so odd multiples of 2^-5 lie half-way: (2^24 - 1)/2 times 1, 3, 5.
  for (const int odd : {1, 3, 5, 31}) {
    const std::int64_t twice = std::int64_t{odd} * ((1 << 24) - 1), below = (twice - 1) / 2;
    EXPECT_EQ(project_vertex(map, 0, 0, odd * 0x1p-5, 1).z4, below % 2 == 0 ? below : below + 1) << odd;
  }
}

TEST(SetUp, EightAtOnceAreTheScalarDefinition) {
  // Positions with many ties: equal corners, zero areas, shared rows and columns, one-pixel and empty bounds, guard band.
  std::mt19937 random(5);
  std::vector<ScreenVertex> vertices;
  for (int i = 0; i < 4000; ++i) {
    const int span = i % 4 == 0 ? 6 : i % 4 == 1 ? 700 : i % 4 == 2 ? 60 * kSubpixels : 2 * kGuardBandSub;
    const auto at = [&] { return static_cast<std::int32_t>(random() % static_cast<unsigned>(span + 1)) + (i % 4 == 3 ? -kGuardBandSub : 100 * kSubpixels); };
    const std::uint32_t flags = i % 50 == 0 ? kLeft : i % 211 == 0 ? kNonFinite : i % 333 == 0 ? kCut | kNear : 0;
    vertices.push_back({at(), at(), static_cast<std::int32_t>(random() & ((kDepthMax << kVertexDepthBits) | 15)), flags});
  }
  std::vector<std::uint32_t> indices;
  for (int i = 0; i < 3 * 5003; ++i) {
    const auto group = static_cast<std::uint32_t>(i / 3 % 4);  // the corners of one are of one kind
    indices.push_back(i % 17 == 1 ? indices.back() : static_cast<std::uint32_t>(random() % 1000) * 4 + group);
  }
  for (const std::string& unit : vector_targets()) {
    use_vector_target(unit);
    for (const CullMode mode : {CullMode::None, CullMode::Back, CullMode::Front})
      for (const int samples : {1, 4})
        for (const bool skips : {true, false}) {
          SetupRule rule{mode, skips, skips, skips, 200, 170, samples};
          const TriangleRange range{vertices.data(), indices.data(), 5003, 77, 9};
          std::vector<SetupTriangle> records(range.count + kSetupSlack);
          std::vector<TileBounds> bounds(records.size());
          SetupOutput out{records.data(), bounds.data(), 0};
          SetupCounters counters, expected;
          std::uint32_t kept = 0, cuts = 0;
          std::vector<std::uint32_t> stops;
          for (std::uint32_t next = 0; (next = set_up_triangles(range, next, rule, out, counters)) < range.count; ++next) stops.push_back(next);
          for (std::uint32_t t = 0; t < range.count; ++t) {
            const ScreenVertex *v[3] = {&vertices[indices[3 * t]], &vertices[indices[3 * t + 1]], &vertices[indices[3 * t + 2]]};
            const std::uint32_t any = v[0]->flags | v[1]->flags | v[2]->flags, all = v[0]->flags & v[1]->flags & v[2]->flags;
            if (any & kNonFinite) { ++expected.dropped_nonfinite; continue; }
            if (skips && (all & kSides) != 0) { ++expected.frustum; continue; }
            if (any & kCut) { ASSERT_LT(cuts, stops.size()); ASSERT_EQ(stops[cuts++], t) << unit; continue; }
            const CanonicalOrder order = canonical_order(*v[0], *v[1], *v[2]);
            if (order.area2 == 0) { ++expected.degenerate; continue; }
            const bool culled = (mode == CullMode::Back && !order.front_facing) || (mode == CullMode::Front && order.front_facing);
            if (culled && skips) { ++expected.facing; continue; }
            SetupTriangle triangle;
            fill_corners(*v[order.corner[0]], *v[order.corner[1]], *v[order.corner[2]], triangle);
            const auto [left, right] = std::minmax({v[0]->x, v[1]->x, v[2]->x});
            const auto [top, bottom] = std::minmax({v[0]->y, v[1]->y, v[2]->y});
            int x0 = samples == 1 ? first_pixel<1>(left) : first_pixel<4>(left), x1 = samples == 1 ? last_pixel<1>(right) : last_pixel<4>(right);
            int y0 = samples == 1 ? first_pixel<1>(top) : first_pixel<4>(top), y1 = samples == 1 ? last_pixel<1>(bottom) : last_pixel<4>(bottom);
            if (skips && (x0 > x1 || y0 > y1)) { ++expected.small; continue; }
            x1 = std::max(x0, x1), y1 = std::max(y0, y1);
            const bool single = x0 == x1 && y0 == y1;
            x0 = std::max(x0, 0), y0 = std::max(y0, 0), x1 = std::min(x1, 199), y1 = std::min(y1, 169);
            if (x0 > x1 || y0 > y1) { ++expected.frustum; continue; }
            if (skips && single && !(samples == 1 ? covers_pixel<1>(triangle, x0, y0) : covers_pixel<4>(triangle, x0, y0))) { ++expected.small; continue; }
            ASSERT_LT(kept, out.count);
            const SetupTriangle& got = records[kept];
            ASSERT_EQ(std::memcmp(&got, &triangle, offsetof(SetupTriangle, id)), 0) << unit << " triangle " << t;
            ASSERT_EQ(got.id, 77 + t);
            ASSERT_EQ(got.draw(), 9u);
            ASSERT_EQ(got.culled(), culled);
            ASSERT_EQ(bounds[kept].x0, x0 / kTilePx);
            ASSERT_EQ(bounds[kept].x1, x1 / kTilePx);
            ASSERT_EQ(bounds[kept].y0, y0 / kTilePx);
            ASSERT_EQ(bounds[kept].y1, y1 / kTilePx);
            ++kept;
          }
          EXPECT_EQ(kept, out.count);
          EXPECT_EQ(cuts, stops.size());
          EXPECT_EQ(counters, expected) << unit << " " << samples << " samples";
          EXPECT_GT(kept, 500u);
          EXPECT_GT(cuts, 5u);
          EXPECT_GT(expected.degenerate, 50u);
        }
  }
  use_vector_target("");
}

TEST(SetUp, ASurfaceOnTheFarPlaneIsNotSeen) {
  // LESS against a depth buffer cleared to the far plane, as in Direct3D and OpenGL; one step before it is.
  for (const bool before : {false, true}) {
    Geometry g;
    g.viewport = {64, 64};
    const double depth = before ? 1 - 0x1p-24 : 1;
    const std::uint32_t a = g.add_pixel_vertex(-1, -1, depth), b = g.add_pixel_vertex(150, -1, depth), c = g.add_pixel_vertex(-1, 150, depth);
    g.add_triangle(a, b, c);
    g.end_draw(CullMode::None);
    const Picture picture = draw_candidate(g, {});
    EXPECT_EQ(difference(picture, draw_expected(g, {})), "");
    for (const std::uint32_t id : picture.planes.visibility) ASSERT_EQ(id, before ? 0u : kNoTriangle);
    for (const std::uint32_t z : picture.planes.depth) ASSERT_EQ(z, before ? kDepthMax - 1 : kDepthMax);
  }
}

TEST(SetUp, NamesWhatIsWrongWithTheInput) {
  Frame frame;
  Geometry g;
  g.viewport = {0, 10};
  EXPECT_THROW(frame.set_up(g.input(), serial()), UserError);
  g.viewport = {16385, 10};
  EXPECT_THROW(frame.set_up(g.input(), serial()), UserError);
  g.viewport = {10, 10};
  g.add_vertex(0, 0, 0, 1);
  g.add_triangle(0, 0, 1);
  g.end_draw();
  EXPECT_THROW(frame.set_up(g.input(), serial()), InternalError);  // vertex 1 of 1
  g.indices = {0, 0, 0};
  g.draws[0].draw_class = DrawClass::InOrder;
  g.indices.insert(g.indices.end(), {0, 0, 0});
  g.end_draw();
  EXPECT_THROW(frame.set_up(g.input(), serial()), InternalError);  // opaque after in-order
  EXPECT_THROW(use_vector_target("abacus"), UserError);
}

TEST(SetUp, LargestViewportIsDrawn) {
  Geometry g;
  g.viewport = {16384, 16384};
  const std::uint32_t a = g.add_pixel_vertex(16383, 16383, 0.5), b = g.add_pixel_vertex(16384, 16383, 0.5), c = g.add_pixel_vertex(16383, 16384, 0.5), d = g.add_pixel_vertex(16384, 16384, 0.5);
  g.add_triangle(a, b, c);
  g.add_triangle(b, d, c);
  g.end_draw();
  Frame frame;
  frame.set_up(g.input(), serial());
  ASSERT_EQ(frame.tile_order().size(), 1u);
  TileRasterizer tiles(frame, {});
  tiles.begin(static_cast<int>(frame.tile_order()[0]));
  tiles.draw_opaque(nullptr);
  std::vector<VisibleQuad> quads;
  gather_visible_quads(frame, tiles.view(), quads);
  ASSERT_EQ(quads.size(), 1u);
  EXPECT_EQ(quads[0].x, 16382);
  EXPECT_EQ(quads[0].y, 16382);
  EXPECT_EQ(quads[0].lanes, 8);
}

TEST(VisibleQuads, HoldEveryVisiblePixelOnceGroupedByDraw) {
  Geometry g;
  g.viewport = {150, 100};
  std::mt19937 random(41);
  for (int draw = 0; draw < 5; ++draw) {
    for (int i = 0; i < 30; ++i) {
      std::uint32_t v[3];
      for (std::uint32_t& corner : v) corner = g.add_pixel_vertex(random() % 170 - 10.0, random() % 120 - 10.0, random() * 0x1p-32);
      g.add_triangle(v[0], v[1], v[2]);
    }
    g.end_draw();
  }
  Frame frame;
  frame.set_up(g.input(), serial());
  TileRasterizer tiles(frame, {});
  std::vector<VisibleQuad> quads;
  std::size_t pixels = 0;
  for (const std::uint32_t tile : frame.tile_order()) {
    tiles.begin(static_cast<int>(tile));
    tiles.draw_opaque(nullptr);
    const TileView view = tiles.view();
    gather_visible_quads(frame, view, quads);
    std::vector<int> seen(kTilePixels, 0);
    for (std::size_t q = 0; q < quads.size(); ++q) {
      if (q > 0) {
        EXPECT_LE(quads[q - 1].draw, quads[q].draw);
      }
      EXPECT_EQ(frame.triangle(quads[q].triangle).draw, quads[q].draw);
      EXPECT_EQ(quads[q].x % 2 + quads[q].y % 2, 0);
      for (int lane = 0; lane < 4; ++lane) {
        if ((quads[q].lanes >> lane & 1) == 0) continue;
        const auto element = static_cast<std::size_t>(TileView::element(quads[q].x + (lane & 1) - view.origin.x, quads[q].y + (lane >> 1) - view.origin.y));
        EXPECT_EQ(view.visibility[element], quads[q].triangle);
        ++seen[element];
      }
    }
    for (std::size_t i = 0; i < seen.size(); ++i) {
      EXPECT_EQ(seen[i], view.visibility[i] == kNoTriangle ? 0 : 1);
      pixels += static_cast<std::size_t>(seen[i]);
    }
  }
  EXPECT_GT(pixels, 5000u);
}

}  // namespace
}  // namespace aluminate::raster::test
