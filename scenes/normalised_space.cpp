#include "scenes/normalised_space.hpp"

#include <algorithm>
#include <cmath>

namespace aluminate::scenes {

NormalisedSpace normalised_space(const glm::dvec3& bounds_min, const glm::dvec3& bounds_max) {
  NormalisedSpace space;
  const glm::dvec3 half =
      bounds_max * 0.5 - bounds_min * 0.5;  // halves first: the extent of finite bounds may overflow
  space.centre = bounds_min + half;
  const double longest = std::max({half.x, half.y, half.z});
  // Below 2^-900 the scale would leave binary64; such a scene is a point for every purpose.
  if (!(longest > 0x1p-900)) return space;
  const glm::dvec3 unit = half / longest;
  space.radius_world = longest * std::sqrt(unit.x * unit.x + unit.y * unit.y + unit.z * unit.z);
  int exponent = 0;
  const double mantissa = std::frexp(space.radius_world, &exponent);  // in [1/2, 1)
  space.exponent = 1 - exponent;
  space.scale = std::ldexp(1.0, space.exponent);
  space.radius = mantissa * 2;
  space.half_extent = half * space.scale;
  return space;
}

}  // namespace aluminate::scenes
