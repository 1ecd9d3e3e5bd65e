#include "shading/report/self_test.hpp"

#include <fmt/format.h>

#include <cmath>

#include "platform/host/image_file.hpp"
#include "platform/host/parallel.hpp"
#include "scenes/scene.hpp"
#include "shading/report/document.hpp"

namespace aluminate::report {
namespace {

// Hash of the test picture for this version: changes only when results change on purpose.
constexpr const char* kExpectedHash = "0f14c1468ef07fce49bb67a6d0f6dcb3";

// A bowl of 24x24 quads in front of the camera, made with + - * / and sqrt only: no libm, no files.
scenes::Scene bowl() {
  constexpr int kSide = 24;
  scenes::Scene scene;
  scene.file = "self-test";
  scenes::Material material;
  material.base_color = {0.8, 0.5, 0.2, 1.0};
  material.metallic = 0.25;
  material.roughness = 0.3;
  scene.materials.push_back(material);
  scenes::Mesh mesh;
  mesh.name = "bowl";
  for (int j = 0; j <= kSide; ++j)
    for (int i = 0; i <= kSide; ++i) {
      const double x = 2.0 * i / kSide - 1.0, y = 2.0 * j / kSide - 1.0;
      const double length = std::sqrt(x * x + y * y + 0.25);
      mesh.positions.emplace_back(x, y, 0.5 - x * x - y * y);
      mesh.normals.emplace_back(x / length, y / length, 0.5 / length);
      mesh.tangents.emplace_back(1, 0, 0, 1);
    }
  for (std::uint32_t j = 0; j < kSide; ++j)
    for (std::uint32_t i = 0; i < kSide; ++i) {
      const std::uint32_t a = j * (kSide + 1) + i, b = a + 1, c = a + kSide + 1, d = c + 1;
      for (const std::uint32_t index : {a, b, d, a, d, c}) mesh.indices.push_back(index);
    }
  scene.meshes.push_back(std::move(mesh));
  scene.bounds_min = {-1, -1, -1.5};
  scene.bounds_max = {1, 1, 0.5};
  return scene;
}

}  // namespace

SelfTest self_test() {
  SelfTest test;
  test.text = fmt::format("aluminate {}\ncompiler   {}\nthreads    {}\nlegends    {}\n", ALUMINATE_VERSION,
#if defined(__clang__)
                          "clang " __clang_version__,
#else
                          "g++ " __VERSION__,
#endif
                          host::thread_count(),
                          host::text_available() ? "font found" : "no font: legends have no text");
  const scenes::Scene scene = bowl();
  passes::FrameOptions options;
  options.width = 160;
  options.height = 120;
  const int threads = host::thread_count();
  test.passed = true;
  for (const int count : {1, 3, 7}) {
    host::set_thread_count(count);
    const std::string hash = image_hash(passes::render_frame(scene, options));
    const bool same = hash == kExpectedHash;
    test.passed &= same;
    test.text += fmt::format("self-test  {}  {} thread{}  {}\n", hash, count, count == 1 ? "" : "s",
                             same ? "ok" : fmt::format("DIFFERS from {}", kExpectedHash));
  }
  host::set_thread_count(threads);
  test.text += test.passed ? "this machine gives the bits it should\n"
                           : "results on this machine differ from the release: do not accept goldens here\n";
  return test;
}

}  // namespace aluminate::report
