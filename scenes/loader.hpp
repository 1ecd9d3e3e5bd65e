// A .gltf or .glb file in, a Scene out: world-space triangles, materials, encoded images, cameras, lights.
// Reads nothing outside the file's own folder. Whatever the file holds, the result is a Scene (repairs noted
// in Scene::warnings) or one UserError that names the file and the place in it ("/accessors/3/bufferView").
// Normals a file lacks are smooth: the sum of the area-weighted face normals around each vertex, not glTF's
// flat ones, because a vertex shared by two triangles then stays one vertex.
#pragma once

#include "scenes/scene.hpp"

#include <cstdint>
#include <filesystem>

namespace aluminate::scenes {

/// Ceilings on what a file may ask for, checked in 64 bits before anything is allocated. Counts are after
/// instancing. The defaults hold about 5 GB of attributes at worst; a scene at console scale is a thousand
/// times smaller.
struct LoadLimits {
  std::uint64_t vertices = std::uint64_t{1} << 25;
  std::uint64_t indices = std::uint64_t{1} << 28;
  std::uint64_t draws = std::uint64_t{1} << 20;             // primitives after instancing
  std::uint64_t file_bytes = (std::uint64_t{1} << 32) - 1;  // of the scene file and of each file it names
  std::uint64_t json_values = std::uint64_t{1} << 22;
  int json_depth = 128;
  int node_depth = 512;
};

/// Throws UserError. The same bytes give the same Scene everywhere: parsing and IEEE binary64 arithmetic
/// only.
Scene load_scene(const std::filesystem::path& path, const LoadLimits& limits = {});

}  // namespace aluminate::scenes
