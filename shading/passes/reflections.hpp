// Specular ambient light of a frame: a captured cube map with its sky texels lit by the frame's own sky,
// filtered again by gloss, as a texture.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "shading/passes/cube_map.hpp"
#include "shading/passes/sky_setup.hpp"
#include "shading/vm/texture.hpp"

namespace aluminate::passes {

struct Reflections {
  vm::Texture texture;    // cube, 16 bits a channel, value / uniform.x; alpha: share of the sky
  glm::dvec4 uniform{0};  // x: a power of two no texel exceeds; y: level of power 1; z, w: 0
};

/// With a sky, light = surface + share * polarizer * sky; without, as captured. Sky radiance is rounded to
/// 2^-20, far coarser than libm's last bits. The polariser reaches the sky in here as it reaches the dome: it
/// is what the eye sees.
Reflections make_reflections(CubeMap map, const std::optional<SkySetup>& sky, const glm::dvec3& polarizer);

/// The same from a file. Throws UserError.
Reflections load_reflections(const std::string& path, const std::optional<SkySetup>& sky,
                             const glm::dvec3& polarizer);

}  // namespace aluminate::passes
