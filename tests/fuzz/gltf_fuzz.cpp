// libFuzzer entry of the scene loader: any bytes are a Scene or a UserError. The first byte chooses .glb or
// .gltf.
//   clang++ build with -DALUMINATE_FUZZ=ON, then: gltf_fuzz -max_len=65536 CORPUS
#include "platform/host/error.hpp"
#include "scenes/light_rig.hpp"
#include "scenes/loader.hpp"
#include "scenes/scene_info.hpp"
#include "scenes/view.hpp"

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace {

/// One folder per process: a scene may name its own file there and nothing else.
const std::filesystem::path& folder() {
  static const std::filesystem::path kFolder = [] {
    auto path = std::filesystem::temp_directory_path() / ("gltf_fuzz_" + std::to_string(::getpid()));
    std::filesystem::create_directories(path);
    return path;
  }();
  return kFolder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace aluminate;
  if (size < 2) return 0;
  const auto path = folder() / (data[0] % 2 == 0 ? "scene.glb" : "scene.gltf");
  std::filesystem::remove(path);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data + 1), static_cast<std::streamsize>(size - 1));
  try {
    const scenes::Scene scene = scenes::load_scene(
        path, {.vertices = 100000, .indices = 100000, .draws = 1000, .json_values = 100000});
    (void)scenes::scene_info_json(scenes::scene_info(scene));
    const scenes::NormalisedSpace space = scenes::normalised_space(scene);
    const scenes::View view = scenes::make_view(scene, space, {}, 1.5);
    (void)view.world_to_clip();
    (void)scenes::make_lights(scene, space, view, {});
  } catch (const UserError&) {
  }
  return 0;
}
