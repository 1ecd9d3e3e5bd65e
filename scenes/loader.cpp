#include "scenes/loader.hpp"

#include "platform/host/error.hpp"
#include "scenes/gltf/document.hpp"
#include "scenes/gltf/geometry.hpp"
#include "scenes/gltf/hierarchy.hpp"
#include "scenes/gltf/materials.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/gltf/tinygltf.hpp"

namespace aluminate::scenes {
namespace {

/// Farther out counts as not finite for the bounds: squares and products of such lengths leave binary64.
constexpr double kFarthest = 1e100;

/// Materials in use of the file, plus one default material that appears only when a primitive names none.
class MaterialList {
 public:
  explicit MaterialList(std::vector<Material>& materials)
      : materials_(materials), in_file_(materials.size()) {}

  int index_of(int in_file) {
    if (in_file >= 0) return in_file;
    if (materials_.size() == in_file_) {
      Material material;
      material.name = "default";
      materials_.push_back(std::move(material));
    }
    return static_cast<int>(in_file_);
  }

 private:
  std::vector<Material>& materials_;
  std::size_t in_file_;
};

void place_mesh(gltf::Document& document, const gltf::PlacedNode& placed, int mesh_index,
                const LoadLimits& limits, gltf::Usage& usage, MaterialList& materials, Scene& scene) {
  const auto& mesh = document.model->meshes[static_cast<std::size_t>(mesh_index)];
  const std::string mesh_name =
      mesh.name.empty() ? fmt::format("mesh {}", mesh_index) : gltf::shown_name(mesh.name);
  for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
    if (++usage.draws > limits.draws)
      document.fail(fmt::format("/nodes/{}", placed.node),
                    fmt::format("the scene places more than {} primitives", limits.draws));
    gltf::PrimitiveSource source;
    source.mesh = static_cast<std::size_t>(mesh_index);
    source.primitive = i;
    source.world = placed.world;
    source.material = materials.index_of(mesh.primitives[i].material);
    source.needs = gltf::needs_of(scene.materials[static_cast<std::size_t>(source.material)]);
    source.name = fmt::format("{}/{}/{}", placed.name, mesh_name, i);
    source.mesh_name = mesh_name;
    if (auto built = gltf::build_mesh(document, source, limits, usage))
      scene.meshes.push_back(std::move(*built));
  }
}

void measure_bounds(Scene& scene) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  glm::dvec3 low(kInfinity), high(-kInfinity);
  for (const Mesh& mesh : scene.meshes) {
    for (const glm::dvec3& p : mesh.positions) {
      const bool near =
          std::fabs(p.x) <= kFarthest && std::fabs(p.y) <= kFarthest && std::fabs(p.z) <= kFarthest;
      if (!near) continue;
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
  }
  if (low.x > high.x) return;  // nothing finite: the bounds stay a point at the origin
  scene.bounds_min = low;
  scene.bounds_max = high;
}

}  // namespace

Scene load_scene(const std::filesystem::path& path, const LoadLimits& limits) {
  gltf::Document document = gltf::read_document(path, limits);
  Scene scene;
  scene.file = document.file;
  scene.content_hash = document.content_hash;
  scene.images = gltf::take_images(document);
  scene.materials = gltf::read_materials(document, scene.images);
  if (!document.model->animations.empty()) document.warnings.add("animations were ignored");
  const std::vector<gltf::PlacedNode> nodes = gltf::walk_nodes(document, limits);
  MaterialList materials(scene.materials);
  gltf::Usage usage;
  for (const gltf::PlacedNode& placed : nodes) {
    const int mesh = document.model->nodes[static_cast<std::size_t>(placed.node)].mesh;
    if (mesh >= 0) place_mesh(document, placed, mesh, limits, usage, materials, scene);
  }
  scene.cameras = gltf::read_cameras(document, nodes);
  scene.lights = gltf::read_lights(document, nodes);
  measure_bounds(scene);
  if (scene.meshes.empty()) document.warnings.add("the scene has no triangles");
  scene.warnings = document.warnings.take();
  return scene;
}

}  // namespace aluminate::scenes
