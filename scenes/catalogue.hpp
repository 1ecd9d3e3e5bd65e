// The scenes that come with aluminate. Their files are written by scenes/generator (aluminate_scenes_make).
#pragma once

#include <span>
#include <string_view>

namespace aluminate::scenes {

struct SampleScene {
  std::string_view name;         // "material_wall"
  std::string_view file;         // relative to the repository root: "scenes/samples/material_wall.gltf"
  std::string_view description;  // one line, no full stop
};

std::span<const SampleScene> sample_scenes();

}  // namespace aluminate::scenes
