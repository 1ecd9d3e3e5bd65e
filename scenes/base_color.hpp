// A measured albedo into a material: a scene file with the base colour of one material replaced by a picture.
// In: a .gltf or .glb and an encoded PNG or JPEG. Out: one .glb that holds everything, also what lay beside
// the file. Geometry, nodes and all other materials stay as they are; nothing is decoded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace aluminate::scenes {

struct BaseColor {
  std::string material;  // its name, or its number; empty: the only one, or a new one where there is none
  std::optional<double> roughness;  // [0, 1]; empty: as it is
};

/// The picture becomes the base colour as it is: the factor's colour becomes white, metallic becomes 0 (an
/// albedo is what a non-metal reflects), texture coordinates, wrap modes, alpha and everything else stay.
/// image_name names it in messages. Throws UserError for a file that load_scene refuses, an unknown material,
/// a picture that is no PNG or JPEG, and a material whose meshes have no texture coordinates.
std::vector<std::uint8_t> with_base_color(const std::filesystem::path& scene,
                                          std::span<const std::uint8_t> image, const std::string& image_name,
                                          const BaseColor& base_color);

}  // namespace aluminate::scenes
