// Where the sun stands. In: "HH:MM" or "elevation,azimuth". Out: a unit vector, z up. A day of equal length
// on a fixed latitude, for lighting studies; not an ephemeris.
#pragma once

#include <glm/glm.hpp>
#include <string_view>

#include "platform/host/error.hpp"

namespace aluminate::sky {

/// Elevation above the horizon and azimuth counter-clockwise from +x seen from above, degrees.
struct SunPosition {
  double elevation_deg = 90, azimuth_deg = 0;
};

/// Unit vector to the sun, z up: (cos el cos az, cos el sin az, sin el). Azimuth 0 is the sun of `sky sh9`,
/// (sin Zs, 0, cos Zs).
[[nodiscard]] glm::dvec3 to_sun(const SunPosition& position) noexcept;

/// "elevation,azimuth" in degrees, -90 <= elevation <= 90, azimuth any finite number; azimuth may be left out
/// (0). UserError.
[[nodiscard]] SunPosition parse_sun(std::string_view text);

/// Hours since midnight in [0, 24) from "HH:MM", 00:00 to 23:59 (H:MM too). UserError.
[[nodiscard]] double parse_time(std::string_view text);

/// The sun's day: latitude and declination in degrees. Defaults: the tropics at equinox, the sun rises at
/// 06:00 due east, stands 70 degrees high due south at 12:00 and sets at 18:00 due west.
struct SunPath {
  double latitude_deg = 20, declination_deg = 0;
};

/// [Meeus98] Hour angle H = 15 degrees (t - 12); sin el = sin lat sin dec + cos lat cos dec cos H; east =
/// -cos dec sin H; north = cos lat sin dec - sin lat cos dec cos H. +x is east, +y north. Solar time: no
/// equation of time, no refraction.
[[nodiscard]] SunPosition sun_at(double hours, const SunPath& path = {}) noexcept;

/// Between this folder's z-up frame and the scene's y-up, right-handed world: (x, y, z) -> (x, z, -y), and
/// back.
[[nodiscard]] constexpr glm::dvec3 z_up_to_world(const glm::dvec3& v) noexcept { return {v.x, v.z, -v.y}; }
[[nodiscard]] constexpr glm::dvec3 world_to_z_up(const glm::dvec3& v) noexcept { return {v.x, -v.z, v.y}; }

}  // namespace aluminate::sky
