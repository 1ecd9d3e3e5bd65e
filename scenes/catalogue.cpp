#include "scenes/catalogue.hpp"

#include <array>

namespace aluminate::scenes {

std::span<const SampleScene> sample_scenes() {
  static constexpr std::array kScenes = {
      SampleScene{"material_wall", "scenes/samples/material_wall.gltf",
                  "spheres on a wall, gloss to the right, dielectric to metal downwards"},
      SampleScene{
          "beach_hut", "scenes/samples/beach_hut.gltf",
          "a plank hut under palms: sun, alpha-tested leaves, blended water; cameras outside and inside"},
      SampleScene{"grazing_floor", "scenes/samples/grazing_floor.gltf",
                  "a long tiled hall with normal and gloss maps, seen at grazing angles"},
      SampleScene{"overdraw_stress", "scenes/samples/overdraw_stress.gltf",
                  "overlapping opaque, cut-out and blended layers in mixed order"},
      SampleScene{"triangle", "scenes/samples/triangle.gltf", "one triangle with vertex colours"},
  };
  return kScenes;
}

}  // namespace aluminate::scenes
