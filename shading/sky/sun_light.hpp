// The sun as a light. In: its direction. Out: the colour a white Lambert surface facing it returns. Ours, for
// lighting studies: the sky model says nothing about the disc.
#pragma once

#include <glm/glm.hpp>

namespace aluminate::sky {

/// Linear rgb, pi-folded: 2 exp(-tau airmass), tau = (0.09, 0.15, 0.27) a channel, airmass by
/// [KastenYoung89]: from (1.83, 1.72, 1.53) overhead over (0.79, 0.42, 0.12) at 5 degrees to (0.07, 0.01,
/// 0.00) at the horizon. Fades out while the disc, half a degree wide, sets; black below. to_sun: unit, z up.
[[nodiscard]] glm::dvec3 sun_color(const glm::dvec3& to_sun) noexcept;

}  // namespace aluminate::sky
