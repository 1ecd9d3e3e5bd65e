// Four samples a pixel: where they lie, what is shaded once, what is billed, and where attributes are taken.
#include <gtest/gtest.h>

#include <bit>
#include <random>

#include "rasterizer/interpolate.hpp"
#include "rasterizer/quads.hpp"
#include "tests/rasterizer/suites.hpp"

namespace aluminate::raster::test {
namespace {

void rectangle(Geometry& g, double x0, double y0, double x1, double y1, double depth) {
  const std::uint32_t a = g.add_pixel_vertex(x0, y0, depth), b = g.add_pixel_vertex(x1, y0, depth),
                      c = g.add_pixel_vertex(x0, y1, depth), d = g.add_pixel_vertex(x1, y1, depth);
  g.add_triangle(a, b, c);
  g.add_triangle(b, d, c);
}

/// Samples of pixel (8, 8) inside a rectangle whose left top corner lies (x, y) sixteenths of a pixel from
/// the pixel's.
unsigned covered_samples(int x, int y) {
  Geometry g;
  g.viewport = {16, 16};
  g.samples = 4;
  rectangle(g, 8 + x / 16.0, 8 + y / 16.0, 16, 16, 0.5);
  g.end_draw();
  const Picture picture = draw_candidate(g, {});
  unsigned covered = 0;
  for (unsigned s = 0; s < 4; ++s)
    covered |= static_cast<unsigned>(picture.planes.visibility[(8 * 16 + 8) * 4 + s] != kNoTriangle) << s;
  return covered;
}

TEST(FourSamples, LieWhereTheStandardPatternPutsThem) {
  // From the top left corner: (6,2) (14,6) (2,10) (10,14) sixteenths. Edges through a sample own it on the
  // left and top.
  constexpr int kX[] = {6, 14, 2, 10}, kY[] = {2, 6, 10, 14};
  for (int y = 0; y <= 16; ++y)
    for (int x = 0; x <= 16; ++x) {
      unsigned expected = 0;
      for (unsigned s = 0; s < 4; ++s) expected |= static_cast<unsigned>(x <= kX[s] && y <= kY[s]) << s;
      EXPECT_EQ(covered_samples(x, y), expected) << x << " " << y;
    }
}

TEST(FourSamples, ShadeAPixelOncePerTriangle) {
  Geometry g;
  g.viewport = {128, 64};
  rectangle(g, 0, 0, 128, 64, 0.5);
  g.end_draw();
  CandidateOptions options;
  options.bill = {BillRule::Kind::Everything, 4};
  const Picture one = draw_candidate(g, options);
  g.samples = 4;
  const Picture four = draw_candidate(g, options);
  std::size_t shared = 0;  // pixels on the diagonal, where both triangles hold samples, are shaded for both
  for (std::size_t pixel = 0; pixel < one.planes.covered.size(); ++pixel) {
    const auto* id = &four.planes.visibility[pixel * 4];
    const std::uint32_t triangles = id[0] == id[1] && id[1] == id[2] && id[2] == id[3] ? 1 : 2;
    EXPECT_EQ(four.planes.covered[pixel], triangles);
    EXPECT_EQ(one.planes.covered[pixel], 1u);
    shared += triangles - 1;
  }
  EXPECT_GT(shared, 32u);
  EXPECT_LT(shared, 256u);
}

TEST(FourSamples, NothingTinyIsLost) {
  // Triangles around one sample that miss every pixel centre: the cull of small triangles has to know all
  // samples.
  constexpr int kX[] = {96, 224, 32, 160}, kY[] = {32, 96, 160, 224};
  for (int s = 0; s < 4; ++s) {
    Geometry g;
    g.viewport = {16, 16};
    g.samples = 4;
    const double x = 5 + kX[s] / 256.0, y = 9 + kY[s] / 256.0, d = 2 / 256.0;
    g.add_triangle(g.add_pixel_vertex(x - d, y - d, 0.5), g.add_pixel_vertex(x + d, y - d, 0.5),
                   g.add_pixel_vertex(x, y + d, 0.5));
    g.end_draw();
    const Picture picture = draw_candidate(g, {});
    EXPECT_EQ(picture.setup.small, 0u);
    for (int other = 0; other < 4; ++other)
      EXPECT_EQ(picture.planes.visibility[static_cast<std::size_t>((9 * 16 + 5) * 4 + other)],
                other == s ? 0u : kNoTriangle);
  }
}

TEST(FourSamples, QuadOfSixteenSamplesIsTheConsolesGrain) {
  // A near rectangle hides the left quad of a stamp; a far triangle over the stamp is then billed for the
  // other quads alone.
  Geometry g;
  g.viewport = {4, 4};
  g.samples = 4;
  rectangle(g, 0, 0, 2, 2, 0.25);
  g.end_draw();
  g.add_triangle(g.add_pixel_vertex(-1, -1, 0.5), g.add_pixel_vertex(12, -1, 0.5),
                 g.add_pixel_vertex(-1, 12, 0.5));
  g.end_draw();
  CandidateOptions options;
  options.bill = {BillRule::Kind::Hierarchical, 2};
  EXPECT_EQ(draw_candidate(g, options).planes.billed_per_draw[1], 12u);
  options.bill.block_px = 4;
  EXPECT_EQ(draw_candidate(g, options).planes.billed_per_draw[1], 16u);
}

TEST(FourSamples, VisibleQuadsHoldEverySampleOnce) {
  Geometry g;
  g.viewport = {100, 70};
  g.samples = 4;
  std::mt19937 random(5);
  for (int i = 0; i < 80; ++i) {
    std::uint32_t v[3];
    for (std::uint32_t& corner : v)
      corner = g.add_pixel_vertex(random() % 120 - 10.0, random() % 90 - 10.0, random() * 0x1p-32);
    g.add_triangle(v[0], v[1], v[2]);
    if (i % 20 == 19) g.end_draw();
  }
  Frame frame;
  frame.set_up(g.input(), serial());
  TileRasterizer tiles(frame, {});
  std::vector<VisibleQuad> quads;
  std::size_t samples = 0;
  for (const std::uint32_t tile : frame.tile_order()) {
    tiles.begin(static_cast<int>(tile));
    tiles.draw_opaque(nullptr);
    const TileView view = tiles.view();
    gather_visible_quads(frame, view, quads);
    std::vector<int> seen(view.visibility.size(), 0);
    for (const VisibleQuad& quad : quads) {
      EXPECT_EQ(quad.lanes,
                (quad.samples | quad.samples >> 4 | quad.samples >> 8 | quad.samples >> 12) & 0xf);
      for (int bit = 0; bit < 16; ++bit) {
        if ((quad.samples >> bit & 1) == 0) continue;
        const auto element = static_cast<std::size_t>(view.element(
            quad.x + (bit & 1) - view.origin.x, quad.y + (bit >> 1 & 1) - view.origin.y, bit >> 2));
        EXPECT_EQ(view.visibility[element], quad.triangle);
        ++seen[element];
      }
    }
    for (std::size_t i = 0; i < seen.size(); ++i)
      EXPECT_EQ(seen[i], view.visibility[i] == kNoTriangle ? 0 : 1);
    for (const int n : seen) samples += static_cast<std::size_t>(n);
  }
  EXPECT_GT(samples, 15000u);
}

TEST(FourSamples, AttributesAreNeverExtrapolatedWhereSomethingIsSeen) {
  // Slivers through a picture: most of their pixels are covered beside the centre.
  Geometry g;
  g.viewport = {96, 64};
  g.samples = 4;
  std::mt19937 random(17);
  const auto real = [&](double low, double high) { return low + (high - low) * (random() * 0x1p-32); };
  for (int i = 0; i < 200; ++i) {
    std::uint32_t v[3];
    const double x = real(0, 90), y = real(0, 60);
    for (std::uint32_t& corner : v)
      corner = g.add_pixel_vertex(x + real(-3, 3), y + real(-20, 20), real(0, 1), real(0.3, 3));
    g.add_triangle(v[0], v[1], v[2]);
  }
  g.end_draw();
  Frame frame, single;
  frame.set_up(g.input(), serial());
  g.samples = 1;
  single.set_up(g.input(), serial());
  TileRasterizer tiles(frame, {});
  std::vector<VisibleQuad> quads;
  int off_centre = 0, at_centre = 0;
  for (const std::uint32_t tile : frame.tile_order()) {
    tiles.begin(static_cast<int>(tile));
    tiles.draw_opaque(nullptr);
    gather_visible_quads(frame, tiles.view(), quads);
    for (const VisibleQuad& quad : quads) {
      const QuadPosition position{quad.triangle, quad.x, quad.y};
      BarycentricRows rows, centres;
      interpolate_barycentrics(frame, {&position, 1}, rows);
      interpolate_barycentrics(single, {&position, 1}, centres);
      for (std::size_t lane = 0; lane < 4; ++lane) {
        const double c1 = centres.b1[lane], c2 = centres.b2[lane];
        const bool centre_inside = c1 > 0 && c2 > 0 && c1 + c2 < 1;
        if ((quad.lanes >> lane & 1) == 0) continue;
        const double b1 = rows.b1[lane], b2 = rows.b2[lane];
        EXPECT_GE(b1, 0);
        EXPECT_GE(b2, 0);
        EXPECT_LE(b1 + b2, 1 + 0x1p-31);  // each was rounded to the grid of 2^-31 once
        const bool moved = b1 != c1 || b2 != c2;
        EXPECT_FALSE(moved && centre_inside);
        ++(moved ? off_centre : at_centre);
      }
    }
  }
  EXPECT_GT(off_centre, 500);
  EXPECT_GT(at_centre, 500);
}

}  // namespace
}  // namespace aluminate::raster::test
