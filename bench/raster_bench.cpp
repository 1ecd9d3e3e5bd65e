// Triangles and pixels per second of the rasterizer alone, on one thread: set-up, bins, tiles, depth, visibility; no shader.
// Rows with "bill" also make the Xenos bill and sum its invocations.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <random>
#include <vector>

#include "rasterizer/frame.hpp"
#include "rasterizer/interpolate.hpp"
#include "rasterizer/quads.hpp"
#include "rasterizer/tile.hpp"

namespace {

using namespace aluminate::raster;

constexpr int kWidth = 1280, kHeight = 720;

struct Geometry {
  std::vector<double> x, y, z, w;
  std::vector<std::uint32_t> indices;
  Draw draw;
  int samples = 1;

  std::uint32_t vertex(double px, double py, double depth) {
    x.push_back(2 * px / kWidth - 1);
    y.push_back(1 - 2 * py / kHeight);
    z.push_back(depth);
    w.push_back(1);
    return static_cast<std::uint32_t>(x.size() - 1);
  }
  FrameInput input() {
    draw.cull = CullMode::None;
    draw.triangle_count = static_cast<std::uint32_t>(indices.size() / 3);
    return {{kWidth, kHeight}, {x, y, z, w}, indices, {&draw, 1}, {}, samples};
  }
};

/// Right triangles with legs of `legs` px at random places: three vertices each, no locality.
Geometry soup(int count, double legs) {
  Geometry g;
  std::mt19937 engine(1);
  const auto real = [&engine](double high) { return high * (engine() * 0x1p-32); };
  for (int i = 0; i < count; ++i) {
    const double px = real(kWidth - legs), py = real(kHeight - legs), depth = real(1);
    for (const std::uint32_t v : {g.vertex(px, py, depth), g.vertex(px + legs, py, depth), g.vertex(px, py + legs, depth)}) g.indices.push_back(v);
  }
  return g;
}

/// A grid of about `count` right triangles with legs of `legs` px, indexed: half a vertex per triangle, neighbours in order.
/// It wraps around the picture as often as it takes, each round nearer than the one before.
Geometry mesh(int count, double legs) {
  Geometry g;
  const int columns = static_cast<int>(kWidth / legs), rows = static_cast<int>(kHeight / legs);
  for (int round = 0; static_cast<int>(g.indices.size()) / 3 < count; ++round) {
    const auto first = static_cast<std::uint32_t>(g.x.size());
    const auto stride = static_cast<std::uint32_t>(columns + 1);
    const int left = (count - static_cast<int>(g.indices.size()) / 3 + 2 * columns - 1) / (2 * columns);
    const int used = left < rows ? left : rows;
    for (int j = 0; j <= used; ++j)
      for (int i = 0; i <= columns; ++i) g.vertex(i * legs, j * legs, 0.9 / (round + 1));
    for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(used); ++j)
      for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(columns); ++i) {
        const std::uint32_t a = first + j * stride + i;
        for (const std::uint32_t v : {a, a + 1, a + stride, a + 1, a + stride + 1, a + stride}) g.indices.push_back(v);
      }
  }
  return g;
}

/// Full-screen layers of two triangles, tilted a little so that depth is really evaluated.
Geometry layers(int count, bool back_to_front) {
  Geometry g;
  for (int i = 0; i < count; ++i) {
    const double depth = back_to_front ? 0.9 - 0.03 * i : 0.1 + 0.03 * i, tilt = 0.01;
    const std::uint32_t a = g.vertex(0, 0, depth), b = g.vertex(kWidth, 0, depth + tilt), c = g.vertex(kWidth, kHeight, depth), d = g.vertex(0, kHeight, depth - tilt);
    for (const std::uint32_t v : {a, b, c, a, c, d}) g.indices.push_back(v);
  }
  return g;
}

class Sum : public BillSink {
 public:
  void billed(std::span<const BilledStamp> stamps) override {
    for (const BilledStamp& s : stamps) {
      covered += static_cast<std::uint64_t>(covered_invocations(s.covered));
      shaded += static_cast<std::uint64_t>(covered_invocations(shaded_lanes(s.covered)));
    }
  }
  std::uint64_t covered = 0, shaded = 0;
};

void draw_tiles(const Frame& frame, TileRasterizer& tiles, BillSink* bill) {
  for (const std::uint32_t tile : frame.tile_order()) {
    tiles.begin(static_cast<int>(tile));
    tiles.draw_opaque(bill);
    benchmark::DoNotOptimize(tiles.view().depth[0]);
  }
}

void frame_bench(benchmark::State& state, Geometry g, bool with_bill, double items) {
  Frame frame;
  Sum sum;
  frame.set_up(g.input(), serial());
  TileRasterizer tiles(frame, {});
  for (auto _ : state) {
    frame.set_up(g.input(), serial());
    draw_tiles(frame, tiles, with_bill ? &sum : nullptr);
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(items * static_cast<double>(state.iterations())));
  if (with_bill) state.counters["billed"] = static_cast<double>(sum.shaded) / static_cast<double>(state.iterations());
}

void triangles(benchmark::State& state, bool with_bill) {
  const int count = state.range(0) >= 32 ? 50000 : 200000;
  frame_bench(state, soup(count, static_cast<double>(state.range(0))), with_bill, count);
}

void mesh_triangles(benchmark::State& state, bool with_bill) {
  Geometry g = mesh(state.range(0) >= 32 ? 50000 : 200000, static_cast<double>(state.range(0)));
  const double count = static_cast<double>(g.indices.size() / 3);
  frame_bench(state, std::move(g), with_bill, count);
}

void triangle_set_up(benchmark::State& state) {
  const int count = state.range(0) >= 32 ? 50000 : 200000;
  Geometry g = soup(count, static_cast<double>(state.range(0)));
  Frame frame;
  for (auto _ : state) frame.set_up(g.input(), serial());
  state.SetItemsProcessed(count * state.iterations());
}

void fill(benchmark::State& state, bool back_to_front, bool with_bill) {
  frame_bench(state, layers(20, back_to_front), with_bill, 20.0 * kWidth * kHeight);
}

/// The same with four samples a pixel; items are still triangles and pixels.
void triangles_4x(benchmark::State& state) {
  const int count = state.range(0) >= 32 ? 50000 : 200000;
  Geometry g = soup(count, static_cast<double>(state.range(0)));
  g.samples = 4;
  frame_bench(state, std::move(g), false, count);
}

void fill_4x(benchmark::State& state, bool back_to_front) {
  Geometry g = layers(20, back_to_front);
  g.samples = 4;
  frame_bench(state, std::move(g), false, 20.0 * kWidth * kHeight);
}

/// Barycentrics and 8 attributes of a full screen of visible quads, in batches of 16.
void interpolation(benchmark::State& state) {
  Geometry g = soup(50000, static_cast<double>(state.range(0)));
  Frame frame;
  frame.set_up(g.input(), serial());
  TileRasterizer tiles(frame, {});
  std::vector<VisibleQuad> quads, tile_quads;
  for (const std::uint32_t tile : frame.tile_order()) {
    tiles.begin(static_cast<int>(tile));
    tiles.draw_opaque(nullptr);
    gather_visible_quads(frame, tiles.view(), tile_quads);
    quads.insert(quads.end(), tile_quads.begin(), tile_quads.end());
  }
  BarycentricRows rows;
  std::array<QuadPosition, kBatchQuads> batch;
  std::array<double, kBatchQuads> a0{}, d1{}, d2{};
  alignas(64) std::array<double, kBatchLanes> out{};
  for (auto _ : state)
    for (std::size_t first = 0; first + kBatchQuads <= quads.size(); first += kBatchQuads) {
      for (std::size_t q = 0; q < kBatchQuads; ++q) batch[q] = {quads[first + q].triangle, quads[first + q].x, quads[first + q].y};
      interpolate_barycentrics(frame, batch, rows);
      for (int attribute = 0; attribute < 8; ++attribute) {
        interpolate_attribute(rows, a0, d1, d2, out);
        benchmark::DoNotOptimize(out);
      }
    }
  state.SetItemsProcessed(static_cast<std::int64_t>(quads.size() * 4) * state.iterations());
}

BENCHMARK_CAPTURE(triangles, no_bill, false)->ArgName("legs_px")->Arg(1)->Arg(4)->Arg(8)->Arg(32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(triangles, bill, true)->ArgName("legs_px")->Arg(1)->Arg(4)->Arg(8)->Arg(32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(mesh_triangles, no_bill, false)->ArgName("legs_px")->Arg(1)->Arg(4)->Arg(8)->Arg(32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(mesh_triangles, bill, true)->ArgName("legs_px")->Arg(1)->Arg(4)->Arg(8)->Arg(32)->Unit(benchmark::kMillisecond);
BENCHMARK(triangle_set_up)->ArgName("legs_px")->Arg(1)->Arg(4)->Arg(8)->Arg(32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fill, back_to_front, true, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fill, back_to_front_bill, true, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fill, front_to_back, false, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fill, front_to_back_bill, false, true)->Unit(benchmark::kMillisecond);
BENCHMARK(triangles_4x)->ArgName("legs_px")->Arg(1)->Arg(4)->Arg(8)->Arg(32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fill_4x, back_to_front, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fill_4x, front_to_back, false)->Unit(benchmark::kMillisecond);
BENCHMARK(interpolation)->ArgName("legs_px")->Arg(8)->Arg(32)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
