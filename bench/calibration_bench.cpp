// A 24-megapixel photograph corrected by every kind of transform, and encoded; wall time on all cores.
#include <benchmark/benchmark.h>

#include <random>
#include <span>

#include "calibration/correct_image.hpp"

namespace {

using namespace aluminate::calibration;

constexpr int kWidth = 6000, kHeight = 4000;

Photo random_photo() {
  Photo photo;
  photo.width = kWidth;
  photo.height = kHeight;
  photo.clip_low = 0.0;
  std::mt19937 random(1);
  photo.rgb_lin.resize(std::size_t{kWidth} * kHeight * 3);
  for (float& value : photo.rgb_lin) value = static_cast<float>(random() >> 8) / 16777216.0f;
  return photo;
}

Transform transform(int kind) {
  const Affine mixed{{{{0.9, 0.05, 0.02, 0.01}, {0.04, 0.9, 0.03, 0.0}, {0.01, 0.06, 0.95, 0.01}}}};
  if (kind == 0) return LinearFit{mixed};
  if (kind == 1) return ToneLinear{1.1, mixed};
  if (kind == 2) return RootPolynomial{2, std::vector<Colour>(6, Colour{0.2, 0.1, 0.15})};
  if (kind == 3) return RootPolynomial{3, std::vector<Colour>(13, Colour{0.1, 0.05, 0.07})};
  AffinePolyAffine chain;
  chain.first = mixed;
  for (Polynomial& p : chain.polynomials) p.a = {0.01, 0.9, 0.1, -0.05, 0.02, -0.01};
  return chain;
}

void correct_24_megapixels(benchmark::State& state) {
  const Photo original = random_photo();
  const Transform map = transform(static_cast<int>(state.range(0)));
  state.SetLabel(transform_name(map));
  Photo photo = original;
  for (auto _ : state) {
    state.PauseTiming();
    photo.rgb_lin = original.rgb_lin;
    state.ResumeTiming();
    benchmark::DoNotOptimize(correct_photo(photo, map));
  }
}
BENCHMARK(correct_24_megapixels)->DenseRange(0, 4)->Unit(benchmark::kMillisecond)->UseRealTime();

void encode_24_megapixels(benchmark::State& state) {
  const Photo photo = random_photo();
  static constexpr const char* kNames[] = {"out.tif", "out.png", "out.exr"};
  const char* name = kNames[state.range(0)];
  state.SetLabel(name);
  std::size_t bytes = 0;
  for (auto _ : state)
    write_corrected(photo, name, {}, [&](std::span<const std::uint8_t> part) { bytes += part.size(); });
  benchmark::DoNotOptimize(bytes);
}
BENCHMARK(encode_24_megapixels)->DenseRange(0, 2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
