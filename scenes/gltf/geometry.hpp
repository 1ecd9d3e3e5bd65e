// One primitive of one mesh, placed in the world by one node: to a Mesh. Strips and fans become triangles,
// missing normals and tangents are generated, broken attributes repaired and noted, mirrored nodes keep their
// outside outside.
#pragma once

#include "scenes/gltf/document.hpp"
#include "scenes/scene.hpp"

#include <cstdint>
#include <optional>

namespace aluminate::scenes::gltf {

/// What has been taken from the file so far, against LoadLimits.
struct Usage {
  std::uint64_t vertices = 0, indices = 0, draws = 0;
};

/// Which optional attributes a material reads.
struct MaterialNeeds {
  bool uv0 = false, uv1 = false;
  bool tangents = false;   // has a normal map
  int tangent_uv_set = 0;  // of the normal map
  glm::dmat3x2 tangent_uv_transform{1, 0, 0, 1, 0, 0};
};
MaterialNeeds needs_of(const Material& material);

struct PrimitiveSource {
  std::size_t mesh = 0, primitive = 0;
  glm::dmat4 world{1};
  MaterialNeeds needs;
  int material = 0;
  std::string name;       // "node/mesh/primitive"
  std::string mesh_name;  // for messages
};

/// nullopt: nothing to draw (points, lines, no positions), noted in the document's warnings.
/// Normals: the file's, or the normalised sum over a vertex's triangles of the cross product of two edges
/// (area-weighted). Tangents: the file's, or sums of the triangles' uv gradients [Lengyel01] made orthogonal
/// to the normal; without a normal map or uv any unit vector orthogonal to the normal, w = 1.
std::optional<Mesh> build_mesh(Document& document, const PrimitiveSource& source, const LoadLimits& limits,
                               Usage& usage);

}  // namespace aluminate::scenes::gltf
