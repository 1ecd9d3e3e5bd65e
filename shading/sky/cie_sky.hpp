// The CIE general sky [CIE-S011]: relative luminance of the dome for a sun position, 15 standard types and
// the set tuned for Far Cry 3. In: five parameters, directions or angles. Out: luminance relative to the
// zenith or to the sun. Frame of this folder: z up, unit vectors. Nothing here knows colour (sky.hpp) or
// reaches a pixel except through a table.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <string_view>

#include "platform/host/error.hpp"

namespace aluminate::sky {

/// phi(Z) = 1 + a exp(b / cos Z), f(chi) = 1 + c (exp(d chi) - exp(d pi / 2)) + e cos^2 chi; angles in
/// radians.
struct CieParameters {
  double a = 0, b = -1, c = 0, d = -1, e = 0;
  bool operator==(const CieParameters&) const = default;
};

struct NamedSky {
  std::string_view name;  // value of --sky
  std::string_view description;
  CieParameters parameters;
};

/// Row i < 15 is CIE type i + 1 [CIE-S011]. The last row is the game's [McAuley12]: the slides print c = -24
/// (and c = -10 for type 12), with which luminance changes sign across the dome; c = +24 and +10 are meant.
inline constexpr std::array<NamedSky, 16> kNamedSkies{{
    {"1", "standard overcast, steep gradation, azimuthal uniformity", {4, -0.7, 0, -1, 0}},
    {"2", "overcast, steep gradation, slight brightening towards the sun", {4, -0.7, 2, -1.5, 0.15}},
    {"3", "overcast, moderate gradation, azimuthal uniformity", {1.1, -0.8, 0, -1, 0}},
    {"4", "overcast, moderate gradation, slight brightening towards the sun", {1.1, -0.8, 2, -1.5, 0.15}},
    {"5", "uniform", {0, -1, 0, -1, 0}},
    {"6", "partly cloudy, no gradation, slight brightening towards the sun", {0, -1, 2, -1.5, 0.15}},
    {"7", "partly cloudy, no gradation, brighter around the sun", {0, -1, 5, -2.5, 0.3}},
    {"8", "partly cloudy, no gradation, distinct corona", {0, -1, 10, -3, 0.45}},
    {"9", "partly cloudy, obscured sun", {-1, -0.55, 2, -1.5, 0.15}},
    {"10", "partly cloudy, brighter around the sun", {-1, -0.55, 5, -2.5, 0.3}},
    {"11", "white-blue, distinct corona", {-1, -0.55, 10, -3, 0.45}},
    {"12", "standard clear", {-1, -0.32, 10, -3, 0.45}},
    {"13", "standard clear, polluted", {-1, -0.32, 16, -3, 0.3}},
    {"14", "cloudless turbid, broad corona", {-1, -0.15, 16, -3, 0.3}},
    {"15", "white-blue turbid, broad corona", {-1, -0.15, 24, -2.8, 0.15}},
    {"fc3", "Far Cry 3, tropical clear", {-1, -0.08, 24, -3, 0.3}},
}};
inline constexpr CieParameters kFarCry3Sky = kNamedSkies[15].parameters;

/// Parameters of CIE type 1..15; a type outside is a bug of the caller (InternalError).
[[nodiscard]] const CieParameters& cie_type(int type);

/// "1".."15", "fc3" or "a,b,c,d,e". UserError for anything else and for a sky that validate() refuses.
[[nodiscard]] CieParameters parse_sky(std::string_view text);

/// UserError unless luminance is finite and positive over the whole dome: b < 0 (or a = 0), phi(0) > 0, f > 0
/// on [0, pi].
void validate(const CieParameters& sky);

/// phi. cos_zenith <= 0 gives 1, the limit at the horizon for b < 0, also below it.
[[nodiscard]] double gradation(const CieParameters& sky, double cos_zenith) noexcept;

/// f. chi in [0, pi], the angle between a sky element and the sun. The term exp(d pi / 2) stays in: leaving
/// it out, as some code does, changes f by 0.9% of c.
[[nodiscard]] double indicatrix(const CieParameters& sky, double chi) noexcept;

/// Angle between unit vectors by atan2(|a x b|, a.b): full precision also near 0 and pi, where acos loses
/// half the digits.
[[nodiscard]] double angle_between(const glm::dvec3& a, const glm::dvec3& b) noexcept;

/// Unit vector of a zenith angle and an azimuth (radians, counter-clockwise from +x seen from above).
[[nodiscard]] glm::dvec3 direction(double zenith, double azimuth) noexcept;

/// What luminance is divided by. Sun: the element in the sun's direction, so that the dome darkens as the sun
/// sinks (the game's choice); it is not bounded by 1, the horizon below a low sun reaches 1.9 with fc3.
enum class Relative : std::uint8_t { Zenith, Sun };
[[nodiscard]] std::string_view to_string(Relative relative) noexcept;
/// "zenith" or "sun"; UserError otherwise.
[[nodiscard]] Relative parse_relative(std::string_view text);

/// [CIE-S011] L / Lz = f(chi) phi(Z) / (f(Zs) phi(0)); [McAuley12] L / Lsun = f(chi) phi(Z) / (f(0) phi(Zs)).
/// The factor that does not depend on the view: 1 / (f(Zs) phi(0)) or 1 / (f(0) phi(Zs)). Below the horizon
/// phi(Zs) stays at phi = 1 (the formula would explode) while chi keeps the true sun.
[[nodiscard]] double normalisation(const CieParameters& sky, Relative relative,
                                   const glm::dvec3& to_sun) noexcept;
[[nodiscard]] double relative_luminance(const CieParameters& sky, Relative relative, const glm::dvec3& to_sun,
                                        const glm::dvec3& view) noexcept;

/// One line of `sky table`. Degrees; zenith angles in [0, 180], any azimuth. Below the horizon phi = 1, see
/// gradation().
struct SkyTableInput {
  double sun_zenith_deg = 0, view_zenith_deg = 0, azimuth_from_sun_deg = 0;
};
struct SkyTableOutput {
  double l_over_l_zenith = 1, l_over_l_sun = 1;
};
/// UserError at `place` for an angle that is not finite or a zenith angle outside [0, 180].
[[nodiscard]] SkyTableOutput sky_table_row(const CieParameters& sky, const SkyTableInput& in,
                                           const SourcePlace& place = {});

}  // namespace aluminate::sky
