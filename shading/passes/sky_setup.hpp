// The sky of a frame as numbers for shaders. In: options. Out: the sky function itself, its sun as a light,
// its ambient light. Everything that reaches a shader is rounded to a grid coarser than libm's last bits, so
// that pictures have the same bits everywhere.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

#include "scenes/light_rig.hpp"
#include "shading/passes/options.hpp"
#include "shading/sky/sh9.hpp"
#include "shading/sky/sky.hpp"

namespace aluminate::passes {

struct SkySetup {
  sky::Sky sky;                            // z up
  sky::Sh9 light{};                        // of `sky`, never of what the polariser leaves of it
  scenes::ShadingLight sun;                // world; black at night
  std::array<glm::dvec4, 7> ambient_sh{};  // lighting.hlsl
  sky::HemisphereAmbient hemisphere;

  /// Uniforms of sky.hlsl.
  glm::dvec4 sun_direction{0}, gradation{0}, indicatrix{0}, zenith{0}, horizon{0}, night_zenith{0},
      night_horizon{0};
};

/// nullopt without --sky. UserError when ambient light of a sky is asked for and there is none.
std::optional<SkySetup> make_sky_setup(const FrameOptions& options);

/// The sky's light in place of the scene's own: directional lights go, the sun comes first.
void replace_directional_lights(const SkySetup& sky, scenes::LightSet& lights);

}  // namespace aluminate::passes
