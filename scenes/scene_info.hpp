// What is in a scene, for `aluminate scene info` and `scene validate`. Text and JSON say the same things.
#pragma once

#include "scenes/scene.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace aluminate::scenes {

struct ImageInfo {
  std::string name, kind;           // kind: "png", "jpeg" or "unknown"
  int width_px = 0, height_px = 0;  // 0 = the header could not be read
  std::uint64_t bytes = 0;          // encoded
  std::vector<std::string> uses;    // "Body: base color"
};

struct SceneInfo {
  std::string file, content_hash;
  std::uint64_t triangles = 0, vertices = 0, draws = 0;
  glm::dvec3 bounds_min{0}, bounds_max{0};
  double radius = 0;                                  // half the bounds' diagonal, world units
  std::vector<std::uint64_t> triangles_per_material;  // same order as Scene::materials
  std::vector<std::string> materials;                 // one line each: workflow, alpha mode, maps
  std::vector<ImageInfo> images;
  std::vector<std::string> cameras, lights;  // one line each
  std::vector<std::string> warnings;
};

SceneInfo scene_info(const Scene& scene);
std::string scene_info_text(const SceneInfo& info);  // lines, for people
std::string scene_info_json(const SceneInfo& info);  // one JSON object, keys in a fixed order

/// Every warning the loader has for this file, one line each; empty = clean. Throws UserError where loading
/// would.
std::vector<std::string> validate_scene(const std::filesystem::path& path);

}  // namespace aluminate::scenes
