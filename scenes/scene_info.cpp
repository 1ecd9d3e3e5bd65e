#include "scenes/scene_info.hpp"

#include "platform/host/error.hpp"
#include "scenes/image_header.hpp"
#include "scenes/loader.hpp"
#include "scenes/normalised_space.hpp"
#include "scenes/trigonometry.hpp"

#include <array>
#include <nlohmann/json.hpp>

namespace aluminate::scenes {
namespace {

constexpr double kDegrees = 180 / kPi;

std::string point_text(const glm::dvec3& p) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x, p.y, p.z); }

struct NamedSlot {
  const char* use;
  const TextureSlot* slot;
};

std::array<NamedSlot, 6> slots_of(const Material& m) {
  const bool specular = m.workflow == Workflow::SpecularGlossiness;
  return {{{specular ? "diffuse" : "base color", &m.base_color_map},
           {"metallic-roughness", &m.metallic_roughness_map},
           {"specular-glossiness", &m.specular_glossiness_map},
           {"normal", &m.normal_map},
           {"occlusion", &m.occlusion_map},
           {"emissive", &m.emissive_map}}};
}

std::string material_line(const Material& m) {
  std::string line = m.name + ": ";
  if (m.unlit)
    line += "unlit";
  else
    line += m.workflow == Workflow::SpecularGlossiness ? "specular-glossiness" : "metallic-roughness";
  if (m.alpha_mode == AlphaMode::Mask) line += fmt::format(", mask {:.3g}", m.alpha_cutoff);
  if (m.alpha_mode == AlphaMode::Blend) line += ", blend";
  if (m.double_sided) line += ", double-sided";
  std::string maps;
  for (const auto& [use, slot] : slots_of(m))
    if (slot->present()) maps += fmt::format("{}{}", maps.empty() ? "" : ", ", use);
  return line + (maps.empty() ? ", no maps" : ", maps: " + maps);
}

std::string camera_line(const Camera& c) {
  const std::string lens = c.perspective
                               ? fmt::format("perspective, fovy {:.4g} deg", c.fovy * kDegrees)
                               : fmt::format("orthographic, {:.4g} x {:.4g}", 2 * c.xmag, 2 * c.ymag);
  return fmt::format("{}: {}, at {}", c.name, lens, point_text(glm::dvec3(c.camera_to_world[3])));
}

std::string light_line(const Light& l) {
  const std::string color = fmt::format("color ({:.3g}, {:.3g}, {:.3g})", l.color.r, l.color.g, l.color.b);
  const std::string range = l.range > 0 ? fmt::format(", range {:.4g}", l.range) : "";
  switch (l.kind) {
    case LightKind::Directional:
      return fmt::format("{}: directional, {:.4g} lux, {}, along {}", l.name, l.intensity, color,
                         point_text(l.direction));
    case LightKind::Point:
      return fmt::format("{}: point, {:.4g} cd, {}, at {}{}", l.name, l.intensity, color,
                         point_text(l.position), range);
    case LightKind::Spot:
      return fmt::format("{}: spot {:.3g} to {:.3g} deg, {:.4g} cd, {}, at {}{}", l.name,
                         l.inner_cone * kDegrees, l.outer_cone * kDegrees, l.intensity, color,
                         point_text(l.position), range);
  }
  return l.name;
}

std::vector<double> triple(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

}  // namespace

SceneInfo scene_info(const Scene& scene) {
  SceneInfo info;
  info.file = scene.file;
  info.content_hash = scene.content_hash;
  info.bounds_min = scene.bounds_min;
  info.bounds_max = scene.bounds_max;
  info.radius = normalised_space(scene).radius_world;
  info.triangles_per_material.assign(scene.materials.size(), 0);
  for (const Mesh& mesh : scene.meshes) {
    info.triangles += mesh.indices.size() / 3;
    info.vertices += mesh.positions.size();
    ++info.draws;
    info.triangles_per_material.at(static_cast<std::size_t>(mesh.material)) += mesh.indices.size() / 3;
  }
  for (const EncodedImage& image : scene.images) {
    const ImageHeader header = read_image_header(image.bytes);
    info.images.push_back({image.name,
                           std::string(image_kind_name(header.kind)),
                           header.width_px,
                           header.height_px,
                           image.bytes.size(),
                           {}});
  }
  for (const Material& material : scene.materials) {
    info.materials.push_back(material_line(material));
    for (const auto& [use, slot] : slots_of(material))
      if (slot->present())
        info.images.at(static_cast<std::size_t>(slot->image))
            .uses.push_back(fmt::format("{}: {}", material.name, use));
  }
  for (const Camera& camera : scene.cameras) info.cameras.push_back(camera_line(camera));
  for (const Light& light : scene.lights) info.lights.push_back(light_line(light));
  info.warnings = scene.warnings;
  return info;
}

std::string scene_info_text(const SceneInfo& info) {
  std::string out = fmt::format(
      "{}\n  hash       {}\n  triangles  {}\n  vertices   {}\n  draws      {}\n  bounds     {} to {}, radius "
      "{:.6g}\n",
      info.file, info.content_hash, info.triangles, info.vertices, info.draws, point_text(info.bounds_min),
      point_text(info.bounds_max), info.radius);
  const auto section = [&](const char* title, const std::vector<std::string>& lines) {
    out += fmt::format("{} ({})\n", title, lines.size());
    for (std::size_t i = 0; i < lines.size(); ++i) out += fmt::format("  {:>3}  {}\n", i, lines[i]);
  };
  std::vector<std::string> materials = info.materials;
  for (std::size_t i = 0; i < materials.size(); ++i)
    materials[i] += fmt::format(", {} triangles", info.triangles_per_material[i]);
  section("materials", materials);
  std::vector<std::string> images;
  for (const ImageInfo& image : info.images) {
    std::string uses;
    for (const std::string& use : image.uses) uses += (uses.empty() ? "" : "; ") + use;
    images.push_back(fmt::format("{}: {} x {} px {}, {} bytes, {}", image.name, image.width_px,
                                 image.height_px, image.kind, image.bytes, uses.empty() ? "unused" : uses));
  }
  section("images", images);
  section("cameras", info.cameras);
  section("lights", info.lights);
  section("warnings", info.warnings);
  return out;
}

std::string scene_info_json(const SceneInfo& info) {
  nlohmann::ordered_json root;
  root["file"] = info.file;
  root["content_hash"] = info.content_hash;
  root["triangles"] = info.triangles;
  root["vertices"] = info.vertices;
  root["draws"] = info.draws;
  root["bounds_min_world"] = triple(info.bounds_min);
  root["bounds_max_world"] = triple(info.bounds_max);
  root["radius_world"] = info.radius;
  root["materials"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < info.materials.size(); ++i)
    root["materials"].push_back(
        {{"description", info.materials[i]}, {"triangles", info.triangles_per_material[i]}});
  root["images"] = nlohmann::ordered_json::array();
  for (const ImageInfo& image : info.images)
    root["images"].push_back({{"name", image.name},
                              {"kind", image.kind},
                              {"width_px", image.width_px},
                              {"height_px", image.height_px},
                              {"encoded_bytes", image.bytes},
                              {"uses", image.uses}});
  root["cameras"] = info.cameras;
  root["lights"] = info.lights;
  root["warnings"] = info.warnings;
  return root.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::vector<std::string> validate_scene(const std::filesystem::path& path) {
  return load_scene(path).warnings;
}

}  // namespace aluminate::scenes
