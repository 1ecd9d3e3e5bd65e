// A captured cube map: what is seen from a point in every direction, drawn by the same renderer, and how much
// of it is sky, so that the sky in it can be exchanged later. As a value and as a file.
//
// The file is an EXR of 6 n x 2 n - 1 pixels: the levels of the chain (filter/cube_filter.hpp) one below the
// other, the faces of each side by side. R, G, B: linear light as captured; A: share of the sky; surface.R,
// .G, .B: what surfaces alone send (the sky black), in level 0 only, so that light = surface + A * sky for
// any sky.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "shading/filter/cube_filter.hpp"
#include "shading/passes/options.hpp"

namespace aluminate::scenes {
struct Scene;
}

namespace aluminate::passes {

/// Light above this is cut off: a highlight caught by a capture would be spread over whole levels as a
/// blotch.
inline constexpr double kGreatestCaptured = 16.0;

struct CubeMap {
  filter::CubeLevel seen;           // rgb as captured, w: share of the sky, 0..1
  std::vector<glm::dvec3> surface;  // by texel of `seen`: rgb without the sky
};

struct CaptureRequest {
  int face_px = 64;       // filter::is_cube_size
  bool at_given = false;  // false: the middle of the scene's bounds
  glm::dvec3 at{0};       // world
};

/// Renders six faces of kCaptureSamples^2 pixels a texel with `options` (camera, size, samples and
/// reflections of it are not used), three times: as it is, and with nothing and with white behind the
/// surfaces. Throws UserError.
inline constexpr int kCaptureSamples = 4;
CubeMap capture_cube_map(const scenes::Scene& scene, const FrameOptions& options,
                         const CaptureRequest& request);

/// chain: filter::prefilter(map.seen).
std::vector<std::uint8_t> encode_cube_map(const CubeMap& map, const std::vector<filter::CubeLevel>& chain);
/// Throws UserError naming the file for anything encode_cube_map() does not write.
CubeMap read_cube_map(const std::string& path);

}  // namespace aluminate::passes
