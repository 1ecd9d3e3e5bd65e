// The lights of a picture as plain numbers for a shader's constant arrays, in normalised units
// (normalised_space.hpp). Either the fixed rig of N lights that any renderer can copy, or the file's
// KHR_lights_punctual, or none. Colours are pi-folded: a white Lambert surface that faces the light at
// attenuation 1 shows exactly the colour.
#pragma once

#include "scenes/normalised_space.hpp"
#include "scenes/scene.hpp"
#include "scenes/view.hpp"

#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace aluminate::scenes {

/// One light. For a surface point P:
///   L = position.xyz - P * position.w,  d2 = dot(L, L),  l = L / sqrt(d2)
///   att    = 1 / (k0 + d2 * k1)
///   window = max(0, 1 - (d2 * inv_range2)^2)                       [KHRLights]: 1 - (d / range)^4
///   cone   = clamp(dot(l, spot_axis) * spot_scale + spot_offset, 0, 1)^2
///   light arriving = color * att * window * cone
/// A kind that has no window or cone carries inv_range2 = 0, spot_scale = 0, spot_offset = 1: the same code,
/// factor 1.
struct ShadingLight {
  glm::dvec4 position{0, 1, 0, 0};  // w = 1: a point; w = 0: xyz is the unit vector to the light
  glm::dvec3 color{1};              // linear, pi-folded, in normalised units (see make_lights)
  double k0 = 1, k1 = 0;
  double inv_range2 = 0;          // 1 / range^2
  glm::dvec3 spot_axis{0, 1, 0};  // unit, from the lit scene back towards the light
  double spot_scale = 0, spot_offset = 1;
  std::string name;  // "rig 0", "Sun"
};

/// --lights auto | scene | rig:N | lamps:N | none. lamps: N bounded points inside the scene's box. auto =
/// scene when the file has lights, else rig:4.
struct LightChoice {
  enum class Kind { Auto, Scene, Rig, Lamps, None };
  Kind kind = Kind::Auto;
  int count = 4;  // Rig, Lamps: 1..kMaxRigLights
};
constexpr int kMaxRigLights = 256;

LightChoice parse_lights(std::string_view text);  // throws UserError

struct LightSet {
  std::vector<ShadingLight> lights;
  std::string description;            // "rig:4", "scene (2 lights)", "none"
  std::vector<std::string> warnings;  // e.g. a light so strong that the picture will be white
};

/// The rule for a file's photometric units: light E lux (or I candela at distance d, E = I / d^2) on a white
/// Lambert surface gives radiance E / pi, so color = intensity * color / pi. A directional light of intensity
/// pi shows white as 1. No exposure is applied: files lit for 100,000 lux come out white and say so in
/// warnings. Point and spot: att = 1 / (2^-16 + d2) in normalised units (the file's 1 / d^2, finite at the
/// lamp), the square of the scale folded into color.
LightSet make_lights(const Scene& scene, const NormalisedSpace& space, const View& view,
                     const LightChoice& choice);

}  // namespace aluminate::scenes
