#include "scenes/gltf/hierarchy.hpp"

#include "platform/host/error.hpp"
#include "scenes/gltf/shading_frame.hpp"
#include "scenes/trigonometry.hpp"

#include <algorithm>
#include <cmath>

#include "scenes/gltf/tinygltf.hpp"

namespace aluminate::scenes::gltf {
namespace {

bool finite(const glm::dmat4& m) {
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      if (!std::isfinite(m[c][r])) return false;
  return true;
}

/// Rotation matrix of a quaternion x, y, z, w of any length but zero.
glm::dmat3 rotation_matrix(double x, double y, double z, double w) {
  return glm::dmat3(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),  //
                    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),  //
                    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y));
}

class Walker {
 public:
  Walker(Document& document, const LoadLimits& limits)
      : document_(document), nodes_(document.model->nodes), limits_(limits) {}

  std::vector<PlacedNode> run() {
    reached_.assign(nodes_.size(), false);
    for (const int root : roots()) visit(root, glm::dmat4(1), 1);
    return std::move(placed_);
  }

 private:
  std::vector<int> roots() const {
    const auto& model = *document_.model;
    if (!model.scenes.empty())
      return model.scenes[static_cast<std::size_t>(std::max(model.defaultScene, 0))].nodes;
    std::vector<bool> is_child(nodes_.size(), false);
    for (const auto& node : nodes_)
      for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
    std::vector<int> result;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (!is_child[i]) result.push_back(static_cast<int>(i));
    // Nodes without a root are a cycle: start anywhere, so that it is found and named.
    if (result.empty() && !nodes_.empty()) result.push_back(0);
    return result;
  }

  void visit(int index, const glm::dmat4& parent, int depth) {
    const std::string place = fmt::format("/nodes/{}", index);
    if (reached_[static_cast<std::size_t>(index)])
      document_.fail(place, "is reached twice: a node has one parent, and no node is its own ancestor");
    if (depth > limits_.node_depth)
      document_.fail(place, fmt::format("nodes are nested more than {} deep", limits_.node_depth));
    reached_[static_cast<std::size_t>(index)] = true;
    const auto& node = nodes_[static_cast<std::size_t>(index)];
    PlacedNode placed{index, node.name.empty() ? fmt::format("node {}", index) : shown_name(node.name),
                      parent * local_matrix(node, place)};
    if (node.mesh >= 0) check_matrix(placed, place);
    if (node.skin >= 0)
      document_.warnings.add(
          fmt::format("{} '{}': its skin was ignored, the mesh is drawn unposed", place, placed.name));
    const glm::dmat4 world = placed.world;
    placed_.push_back(std::move(placed));
    for (const int child : node.children) visit(child, world, depth + 1);
  }

  void check_matrix(const PlacedNode& placed, const std::string& place) {
    if (!finite(placed.world))
      document_.warnings.add(fmt::format("{} '{}': its world matrix is not finite", place, placed.name));
    else if (direction_map(glm::dmat3(placed.world)).singular)
      document_.warnings.add(fmt::format(
          "{} '{}': its world matrix is singular, its meshes are flat or empty", place, placed.name));
  }

  glm::dmat4 local_matrix(const tinygltf::Node& node, const std::string& place) {
    glm::dmat4 m(1);
    if (node.matrix.size() == 16) {
      for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) m[c][r] = node.matrix[static_cast<std::size_t>(4 * c + r)];
      if (m[0].w != 0 || m[1].w != 0 || m[2].w != 0 || m[3].w != 1) {
        document_.warnings.add(place + "/matrix: its last row is not 0 0 0 1, which was assumed");
        m[0].w = m[1].w = m[2].w = 0;
        m[3].w = 1;
      }
      return m;
    }
    glm::dmat3 linear(1);
    if (node.rotation.size() == 4) linear = rotation(node.rotation, place);
    if (node.scale.size() == 3)
      for (int c = 0; c < 3; ++c) linear[c] *= node.scale[static_cast<std::size_t>(c)];
    m = glm::dmat4(linear);
    if (node.translation.size() == 3)
      m[3] = glm::dvec4(node.translation[0], node.translation[1], node.translation[2], 1);
    return m;
  }

  glm::dmat3 rotation(const std::vector<double>& q, const std::string& place) {
    const double length2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (!(length2 > 0) || !std::isfinite(length2)) {
      document_.warnings.add(place + "/rotation: has no direction, no rotation was assumed");
      return glm::dmat3(1);
    }
    // Exporters write floats: a unit quaternion is one to about 1e-7 and is used as it is.
    if (std::fabs(length2 - 1) < 1e-5) return rotation_matrix(q[0], q[1], q[2], q[3]);
    document_.warnings.add(place + "/rotation: is not of unit length and was normalised");
    const double length = std::sqrt(length2);
    return rotation_matrix(q[0] / length, q[1] / length, q[2] / length, q[3] / length);
  }

  Document& document_;
  const std::vector<tinygltf::Node>& nodes_;
  const LoadLimits& limits_;
  std::vector<bool> reached_;
  std::vector<PlacedNode> placed_;
};

}  // namespace

std::vector<PlacedNode> walk_nodes(Document& document, const LoadLimits& limits) {
  return Walker(document, limits).run();
}

std::vector<Camera> read_cameras(Document& document, const std::vector<PlacedNode>& nodes) {
  std::vector<Camera> cameras;
  for (const PlacedNode& placed : nodes) {
    const auto& node = document.model->nodes[static_cast<std::size_t>(placed.node)];
    if (node.camera < 0) continue;
    const auto& source = document.model->cameras[static_cast<std::size_t>(node.camera)];
    Camera camera;
    camera.name = node.name.empty() && !source.name.empty() ? shown_name(source.name) : placed.name;
    camera.camera_to_world = placed.world;
    camera.perspective = source.type == "perspective";
    const auto& lens = source.perspective;
    const auto& box = source.orthographic;
    camera.near_plane = camera.perspective ? lens.znear : box.znear;
    camera.far_plane = camera.perspective ? lens.zfar : box.zfar;
    camera.fovy = lens.yfov;
    camera.xmag = std::fabs(box.xmag);
    camera.ymag = std::fabs(box.ymag);
    const bool usable = finite(placed.world) &&
                        (camera.perspective ? camera.fovy > 0 && camera.fovy < kPi && camera.near_plane > 0
                                            : camera.xmag > 0 && camera.ymag > 0 && camera.near_plane >= 0);
    if (!usable) {
      document.warnings.add(fmt::format("/cameras/{} '{}': its numbers make no view and it was left out",
                                        node.camera, camera.name));
      continue;
    }
    if (camera.far_plane != 0 && camera.far_plane <= camera.near_plane) {
      document.warnings.add(fmt::format("/cameras/{} '{}': zfar is not beyond znear and was ignored",
                                        node.camera, camera.name));
      camera.far_plane = 0;
    }
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

std::vector<Light> read_lights(Document& document, const std::vector<PlacedNode>& nodes) {
  std::vector<Light> lights;
  for (const PlacedNode& placed : nodes) {
    const auto& node = document.model->nodes[static_cast<std::size_t>(placed.node)];
    const auto found = node.extensions.find("KHR_lights_punctual");
    if (found == node.extensions.end()) continue;
    const int index = found->second.Get("light").GetNumberAsInt();
    const auto& source = document.model->lights.at(static_cast<std::size_t>(index));
    Light light;
    light.name = node.name.empty() && !source.name.empty() ? shown_name(source.name) : placed.name;
    light.kind = source.type == "directional" ? LightKind::Directional
                 : source.type == "spot"      ? LightKind::Spot
                                              : LightKind::Point;
    if (source.color.size() == 3) light.color = glm::dvec3(source.color[0], source.color[1], source.color[2]);
    light.intensity = source.intensity;
    light.range = light.kind == LightKind::Directional ? 0 : source.range;
    const auto repair = [&](double& value, double low, double high, const char* what) {
      if (value >= low && value <= high) return;
      document.warnings.add(fmt::format("light {} '{}': {} = {} lies outside {} to {} and was clamped", index,
                                        light.name, what, value, low, high));
      value = value > high ? high : low;
    };
    for (int c = 0; c < 3; ++c) repair(light.color[c], 0, 1e6, "color");
    repair(light.intensity, 0, 1e30, "intensity");
    repair(light.range, 0, 1e30, "range");
    if (light.kind == LightKind::Spot) {
      light.inner_cone = source.spot.innerConeAngle;
      light.outer_cone = source.spot.outerConeAngle;
      repair(light.outer_cone, 0, kPi / 2, "outerConeAngle");
      repair(light.inner_cone, 0, light.outer_cone, "innerConeAngle");
    }
    light.position = glm::dvec3(placed.world[3]);
    light.direction = unit_or_zero(-glm::dvec3(placed.world[2]));
    if (!finite(placed.world) || light.direction == glm::dvec3(0)) {
      document.warnings.add(fmt::format(
          "light {} '{}': its node's matrix has no direction and it was left out", index, light.name));
      continue;
    }
    lights.push_back(std::move(light));
  }
  return lights;
}

}  // namespace aluminate::scenes::gltf
