// Whole frames with shading and the bill, on one thread: full-screen textured fill and lit fill, and a mesh
// whose vertices outnumber its pixels. Items are pixels of the picture, or vertices.
#include <benchmark/benchmark.h>

#include <random>

#include "platform/host/image_file.hpp"
#include "platform/host/parallel.hpp"
#include "scenes/scene.hpp"
#include "shading/passes/frame.hpp"

namespace {

using namespace aluminate;

/// n x n quads in the plane z = 0 from (-1, -1) to (1, 1), with one texture of random texels.
scenes::Scene sheet(int n) {
  scenes::Scene scene;
  host::Image8 image{256, 256, 4, {}};
  std::mt19937 random(1);
  for (int i = 0; i < 256 * 256 * 4; ++i) image.texels.push_back(static_cast<std::uint8_t>(random() >> 24));
  scene.images.push_back({"noise", host::encode_png(image)});
  scenes::Material material;
  material.base_color_map.image = 0;
  material.metallic = 0;
  material.roughness = 0.4;
  scene.materials.push_back(material);
  scenes::Mesh mesh;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) {
      mesh.positions.emplace_back(2.0 * x / n - 1, 2.0 * y / n - 1, 0);
      mesh.normals.emplace_back(0, 0, 1);
      mesh.tangents.emplace_back(1, 0, 0, 1);
      mesh.uv0.emplace_back(4.0f * static_cast<float>(x) / static_cast<float>(n),
                            4.0f * static_cast<float>(y) / static_cast<float>(n));
    }
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const auto a = static_cast<std::uint32_t>(y * (n + 1) + x), up = a + static_cast<std::uint32_t>(n) + 1;
      for (const std::uint32_t v : {a, a + 1, up + 1, a, up + 1, up}) mesh.indices.push_back(v);
    }
  scene.meshes.push_back(std::move(mesh));
  scene.bounds_min = {-1, -1, 0};
  scene.bounds_max = {1, 1, 0};
  return scene;
}

passes::FrameOptions options(const char* lights, int width, int height, int msaa) {
  passes::FrameOptions o;
  o.width = width;
  o.height = height;
  o.camera = "0,0,1:0,0,0:45";  // the sheet reaches beyond the picture
  o.lights = lights;
  o.msaa = msaa;
  return o;
}

void fill(benchmark::State& state, const char* lights, int msaa) {
  host::set_thread_count(1);
  const scenes::Scene scene = sheet(1);
  const passes::FrameOptions o = options(lights, 640, 360, msaa);
  for (auto _ : state) benchmark::DoNotOptimize(passes::render_frame(scene, o).rgba8.data());
  state.SetItemsProcessed(state.iterations() * o.width * o.height);
}

void vertex_bound(benchmark::State& state) {
  host::set_thread_count(1);
  const scenes::Scene scene = sheet(400);
  const passes::FrameOptions o = options("none", 64, 64, 1);
  for (auto _ : state) benchmark::DoNotOptimize(passes::render_frame(scene, o).rgba8.data());
  state.SetItemsProcessed(state.iterations() * 401 * 401);
}

BENCHMARK_CAPTURE(fill, textured, "none", 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fill, lit_4, "rig:4", 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fill, lit_4_4x, "rig:4", 4)->Unit(benchmark::kMillisecond);
BENCHMARK(vertex_bound)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
