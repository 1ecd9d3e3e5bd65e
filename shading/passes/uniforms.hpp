// The numbers behind a program's uniform names. Programs may declare any subset; a name nobody knows is an
// error that lists the names there are.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scenes/light_rig.hpp"
#include "scenes/scene.hpp"
#include "scenes/view.hpp"
#include "shading/passes/options.hpp"
#include "shading/vm/program.hpp"

namespace aluminate::passes {

/// What is the same for every draw of a frame.
struct FrameUniforms {
  glm::dmat4 world_to_clip{1};
  glm::dvec3 eye{0};  // normalised world units
  double ambient = 0;
  std::vector<scenes::ShadingLight> lights;
};

/// uniform_count x 4 values for `program` under `material` (nullptr: none). Throws UserError for an unknown
/// name.
std::vector<double> uniform_values(const vm::Program& program, const FrameUniforms& frame,
                                   const scenes::Material* material);

}  // namespace aluminate::passes
