// What a glTF file means to the renderer: world-space triangles, materials, textures by reference, cameras,
// lights. Everything the loader could repair is repaired and noted in `warnings`; what it could not raises
// UserError.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

namespace aluminate::scenes {

/// Encoded image (PNG, JPEG, ...): decoded only when a draw samples it. Bytes are owned; file-based images
/// are read at load.
struct EncodedImage {
  std::string name;  // for messages: "scene.glb image 3 'helmet_base'"
  std::vector<std::uint8_t> bytes;
};

enum class Wrap : std::uint8_t { Repeat, Clamp, Mirror };
enum class Filter : std::uint8_t { Nearest, Linear };

struct Sampler {
  Wrap wrap_u = Wrap::Repeat, wrap_v = Wrap::Repeat;
  Filter magnify = Filter::Linear, minify = Filter::Linear;
  bool mipmapped = true;        // false: minification reads level 0
  Filter mip = Filter::Linear;  // Linear = trilinear
  bool operator==(const Sampler&) const = default;
};

/// A material's use of an image. image < 0: absent.
struct TextureSlot {
  int image = -1;
  Sampler sampler{};
  int uv_set = 0;  // 0 or 1
  glm::dmat3x2 uv_transform{1, 0, 0, 1,
                            0, 0};  // KHR_texture_transform: uv' = M * (u, v, 1), columns x, y, translation
  bool present() const { return image >= 0; }
};

enum class AlphaMode : std::uint8_t { Opaque, Mask, Blend };
enum class Workflow : std::uint8_t { MetallicRoughness, SpecularGlossiness };

struct Material {
  std::string name;
  Workflow workflow = Workflow::MetallicRoughness;
  glm::dvec4 base_color{1};  // linear; diffuseFactor in SpecularGlossiness
  double metallic = 1, roughness = 1;
  glm::dvec3 specular{1};  // SpecularGlossiness only, linear
  double glossiness = 1;
  glm::dvec3 emissive{0};
  double normal_scale = 1, occlusion_strength = 1, alpha_cutoff = 0.5;
  AlphaMode alpha_mode = AlphaMode::Opaque;
  bool double_sided = false, unlit = false;
  TextureSlot base_color_map;                           // sRGB; diffuse map in SpecularGlossiness
  TextureSlot metallic_roughness_map;                   // G = roughness, B = metallic
  TextureSlot specular_glossiness_map;                  // rgb sRGB, A = glossiness
  TextureSlot normal_map, occlusion_map, emissive_map;  // occlusion in R; emissive sRGB
};

/// One drawable: world space, indexed triangles, counter-clockwise = front. All attribute arrays have the
/// vertex count or are empty; positions, normals and tangents are always there (generated when the file has
/// none). A uv set is there exactly when one of the material's textures reads it; tangents follow the uv only
/// when the material has a normal map.
struct Mesh {
  std::string name;  // "node/mesh/primitive"
  int material = 0;  // index into Scene::materials; always valid (a default is appended when needed)
  std::vector<glm::dvec3>
      positions;                   // may hold NaN or infinity: the rasterizer drops and counts such triangles
  std::vector<glm::vec3> normals;  // unit
  std::vector<glm::vec4> tangents;  // unit xyz, w = +1 or -1: B = cross(N, T) w
  std::vector<glm::vec2> uv0, uv1;
  std::vector<glm::vec4> colors;       // COLOR_0, linear
  std::vector<std::uint32_t> indices;  // 3 per triangle; winding already flipped under negative scale
};

struct Camera {
  std::string name;
  glm::dmat4 camera_to_world{1};  // looks along -z, +y up
  bool perspective = true;
  double fovy = 0.785398163397448;          // radians
  double xmag = 1, ymag = 1;                // orthographic half extents
  double near_plane = 0.01, far_plane = 0;  // far 0 = none given
};

enum class LightKind : std::uint8_t { Directional, Point, Spot };
struct Light {
  std::string name;
  LightKind kind = LightKind::Point;
  glm::dvec3 color{1};  // linear, times intensity as the file gives it
  double intensity = 1;
  double range = 0;                                       // 0 = unlimited
  double inner_cone = 0, outer_cone = 0.785398163397448;  // radians
  glm::dvec3 position{0};                                 // world
  glm::dvec3 direction{0, 0, -1};                         // world, the way the light travels
};

struct Scene {
  std::string file;          // as the user named it
  std::string content_hash;  // XXH3-128 of the file's bytes and of every file it names, hex
  std::vector<EncodedImage> images;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;  // scene order, depth first
  std::vector<Camera> cameras;
  std::vector<Light> lights;
  glm::dvec3 bounds_min{0}, bounds_max{0};  // of all finite vertices
  std::vector<std::string> warnings;        // one clear line each
};

}  // namespace aluminate::scenes
