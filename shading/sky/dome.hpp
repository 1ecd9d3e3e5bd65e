// The dome as an image and as an integral. In: a Sky. Out: linear float rgb in a latitude-longitude map,
// irradiance by direct quadrature. The image goes through the post-process multiplier; integrals and SH never
// do.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "shading/sky/sky.hpp"

namespace aluminate::sky {

/// int L dw and int L |cos Z| dw over the upper hemisphere.
struct DomeIntegral {
  glm::dvec3 radiance{0};    // int L dw
  glm::dvec3 horizontal{0};  // irradiance of a horizontal surface facing up
};
/// Error below 1e-8 relative.
[[nodiscard]] DomeIntegral dome_integral(const Sky& sky);

/// E(n) = int L max(0, n.d) dw over the sphere, `ground` included: what irradiance(project(sky), n)
/// approximates. Split where the horizon of the normal crosses the rings; error below 1e-7 relative. normal:
/// unit.
[[nodiscard]] glm::dvec3 direct_irradiance(const Sky& sky, const glm::dvec3& normal);

/// Latitude-longitude map, width x height: pixel centre (x + 0.5, y + 0.5); azimuth = 2 pi (x + 0.5) / width
/// - pi, counter-clockwise from +x seen from above, so the column in the middle looks along +x; zenith angle
/// = pi (y + 0.5) / height, so row 0 is at the zenith and the horizon in the middle.
[[nodiscard]] glm::dvec3 latlong_direction(int x, int y, int width, int height) noexcept;
/// Solid angle of a pixel of row y: 2 pi / width (cos(pi y / height) - cos(pi (y + 1) / height)).
[[nodiscard]] double latlong_solid_angle(int y, int width, int height) noexcept;

/// What the dome shader draws below the horizon.
enum class BelowHorizon : std::uint8_t { Extend, Ground };

struct DomeImageOptions {
  int width = 1024, height = 512;  // 1 .. 16384 each
  BelowHorizon below = BelowHorizon::Ground;
  glm::dvec3 post_process{1};  // the polarising filter of [McAuley12]: rgb factor on the dome, 1 = off
};

/// Row-major rgb, 3 floats a pixel, linear, one sample at each pixel centre. UserError for a size out of
/// range.
[[nodiscard]] std::vector<float> dome_image(const Sky& sky, const DomeImageOptions& options);

}  // namespace aluminate::sky
