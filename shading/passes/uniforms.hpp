// The numbers behind a program's uniform names. Programs may declare any subset; a name nobody knows is an
// error that lists the names there are.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "scenes/light_rig.hpp"
#include "scenes/scene.hpp"
#include "scenes/view.hpp"
#include "shading/passes/options.hpp"
#include "shading/passes/shadows.hpp"
#include "shading/passes/sky_setup.hpp"
#include "shading/passes/toksvig.hpp"
#include "shading/vm/program.hpp"

namespace aluminate::passes {

/// What is the same for every draw of a frame.
struct FrameUniforms {
  scenes::View view;
  double ambient = 0;  // flat
  std::vector<scenes::ShadingLight> lights;
  std::vector<ShadowView> shadows;  // of the first lights
  const ToksvigSet* toksvig = nullptr;
  std::optional<SkySetup> sky;
  AmbientKind ambient_kind = AmbientKind::Flat;
  glm::dvec3 polarizer{1};
  glm::dvec4 reflection{0};  // lighting.hlsl; zero: no cube map
  double dome_depth =
      1;  // clip z at w = 1 that rounds to the last depth before the cleared one, or just before
  double emissive_scale = 0;  // power of two no emissive factor exceeds; 0: nothing glows

  bool has_ambient() const {
    return reflection != glm::dvec4(0) || has_diffuse_ambient();
  }
  bool has_diffuse_ambient() const {
    return ambient_kind == AmbientKind::Flat ? ambient > 0 : ambient_kind != AmbientKind::None;
  }
};

/// uniform_count x 4 values for `program` under `material` (nullptr: none). Throws UserError for an unknown
/// name.
std::vector<double> uniform_values(const vm::Program& program, const FrameUniforms& frame,
                                   const scenes::Material* material);

}  // namespace aluminate::passes
