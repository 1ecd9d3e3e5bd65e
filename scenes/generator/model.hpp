// A glTF file under construction: surfaces, materials, nodes in; NAME.gltf, NAME.bin and NAME_*.png out.
// The same calls give the same bytes; only the PNG encoder's version can change a file, never its texels.
#pragma once

#include "platform/host/image_file.hpp"

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace aluminate::scenes::generator {

using nlohmann::ordered_json;

/// Triangles counter-clockwise from outside. uv and colors may be empty; normals are unit. +y up, metres.
struct Surface {
  std::vector<glm::dvec3> positions, normals;
  std::vector<glm::dvec2> uv;
  std::vector<glm::dvec4> colors;    // linear, stored as unorm8
  std::vector<glm::dvec4> tangents;  // for normal maps, see add_tangents
  std::vector<std::uint32_t> indices;

  void append(const Surface& other, const glm::dmat4& placement = glm::dmat4(1));
  void tint(const glm::dvec4& color);  // multiplies, starting from white

  /// Along +u; w such that the bitangent runs along -v, "up" in the image, which is what glTF's normal maps
  /// mean by +y.
  void add_tangents();
};

class Model {
 public:
  explicit Model(std::string name);

  /// Texture index; repeat, trilinear. `what` names the PNG: NAME_what.png.
  int add_texture(const std::string& what, host::Image8 image);
  int add_material(ordered_json material);
  /// Accessors of a surface, to be shared by meshes of different materials.
  ordered_json add_surface(const Surface& surface);
  int add_mesh(const std::string& name, const ordered_json& primitive, int material);
  int add_mesh(const std::string& name, const Surface& surface, int material) {
    return add_mesh(name, add_surface(surface), material);
  }

  void place(const std::string& name, int mesh, const glm::dmat4& placement = glm::dmat4(1));
  void add_camera(const std::string& name, const glm::dvec3& eye, const glm::dvec3& target,
                  double fovy_degrees, double near_plane);
  /// kind "directional" (intensity in lux) or "point" (candela); a directional light shines from `from`
  /// towards `to`.
  void add_light(const std::string& name, const std::string& kind, const glm::dvec3& color, double intensity,
                 const glm::dvec3& from, const glm::dvec3& to = glm::dvec3(0), double range = 0);

  void write(const std::filesystem::path& folder) const;

 private:
  int add_view(const void* bytes, std::size_t size, int target);
  int append(const char* array, ordered_json value);
  void add_root(const ordered_json& node);
  void use_extension(const std::string& name);

  std::string name_;
  ordered_json root_;
  std::vector<std::uint8_t> bin_;
  std::vector<std::pair<std::string, host::Image8>> images_;
};

/// base color, metallic, roughness; textures by index, -1 = none.
ordered_json pbr_material(const std::string& name, const glm::dvec4& base_color, double metallic,
                          double roughness, int base_color_texture = -1, int normal_texture = -1,
                          int metallic_roughness_texture = -1);

glm::dmat4 moved(const glm::dvec3& offset);
glm::dmat4 turned_y(double degrees);
glm::dmat4 turned_x(double degrees);
glm::dmat4 turned_z(double degrees);
glm::dmat4 scaled(const glm::dvec3& factors);

}  // namespace aluminate::scenes::generator
