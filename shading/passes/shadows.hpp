// Shadow maps. In: the lights of a frame and its scene. Out: for each light that casts, a view, the rows that
// take a position into the map, and the map itself, drawn by the same rasterizer at the light's view; its
// bill. Directional lights cover everything lit, spots their cone. Casters whose shadow cannot fall into the
// picture are left out and counted.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/light_rig.hpp"
#include "scenes/normalised_space.hpp"
#include "scenes/scene.hpp"
#include "scenes/view.hpp"
#include "shading/passes/frame.hpp"
#include "shading/passes/options.hpp"
#include "shading/vm/texture.hpp"

namespace aluminate::passes {

struct DrawList;

inline constexpr std::size_t kMaxShadows = 4;
inline constexpr int kShadowMapPx = 1024;  // a side; a single light has twice as much

struct ShadowView {
  scenes::View view;
  /// Uniforms: rows to (u, v, depth, 1) w in the atlas; x: step along the normal, y: depth bias.
  std::array<glm::dvec4, 4> rows{};
  glm::dvec4 bias{0};
  int origin_x = 0, origin_y = 0, size = 0;  // of its part of the atlas, pixels
};

struct ShadowPlan {
  std::vector<ShadowView> views;  // of the first lights
  int atlas_px = 0;               // a side
};

/// Moves the lights that cast (directional and spot, at most kMaxShadows) to the front and lays out their
/// maps. Lights beyond are noted in lights.warnings and cast none.
ShadowPlan plan_shadows(const scenes::Scene& scene, const scenes::NormalisedSpace& space,
                        scenes::LightSet& lights);

struct ShadowResult {
  PassTotals totals;  // summed over maps; its fragments are texels of the maps, not pixels of the picture
  std::uint64_t skipped_casters = 0;  // (light, draw) pairs
};

/// Draws the maps of list.shadows into *list.shadow_atlas.
ShadowResult draw_shadow_maps(const FrameOptions& options, const DrawList& list);

}  // namespace aluminate::passes
