// The node tree: walked depth first, children in file order, each node once. Gives what each node places in
// the world.
#pragma once

#include "scenes/gltf/document.hpp"
#include "scenes/scene.hpp"

#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace aluminate::scenes::gltf {

struct PlacedNode {
  int node = 0;
  std::string name;  // the file's, or "node 7"
  glm::dmat4 world{1};
};

/// Nodes of the default scene (of the first one when none is named; all roots when the file has no scenes). A
/// node reached twice, as in a cycle, is a UserError: glTF asks for trees. Non-finite and singular matrices
/// are noted.
std::vector<PlacedNode> walk_nodes(Document& document, const LoadLimits& limits);

/// Cameras and KHR_lights_punctual in walk order; unusable ones are left out and noted.
std::vector<Camera> read_cameras(Document& document, const std::vector<PlacedNode>& nodes);
std::vector<Light> read_lights(Document& document, const std::vector<PlacedNode>& nodes);

}  // namespace aluminate::scenes::gltf
