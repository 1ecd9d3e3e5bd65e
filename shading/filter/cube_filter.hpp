// Reflections filtered by gloss: a captured cube map in, a chain of mips out, each the light that a lobe of
// one power gathers around the direction of reflection. Literal IEEE sequences (sums in texel order, powers
// by squaring), so the chain has the same bits everywhere.
//
// Level k of a cube of 2^n texels a side holds power 2^(13 - 2 (k - n + 6)): 64 texels start at the greatest
// power, 8192, whose lobe is about as wide as a texel, and halving the size quarters the power, which doubles
// the lobe's width. So the level of a power is linear in its logarithm: level = n + 1/2 - log2(m) / 2.
#pragma once

#include <glm/glm.hpp>
#include <vector>

namespace aluminate::filter {

inline constexpr int kMinCubeFacePx = 16, kMaxCubeFacePx = 128;

/// Faces +x -x +y -y +z -z in Direct3D's layout (docs/texture_unit.md), row-major, row 0 at v = 0.
struct CubeLevel {
  int size = 0;                    // texels along an edge
  std::vector<glm::dvec4> texels;  // 6 size^2: linear rgb, share of the sky

  std::size_t index(int face, int x, int y) const {
    return (static_cast<std::size_t>(face) * static_cast<std::size_t>(size) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size) +
           static_cast<std::size_t>(x);
  }
};

/// A power of two within the two limits.
[[nodiscard]] bool is_cube_size(int size) noexcept;

/// Unit vector through the middle of a texel, world axes.
[[nodiscard]] glm::dvec3 cube_direction(int face, int x, int y, int size) noexcept;

/// Solid angle of a texel to second order: (2 / size)^2 / (1 + u^2 + v^2)^1.5, u and v in [-1, 1].
[[nodiscard]] double cube_solid_angle(int x, int y, int size) noexcept;

/// Power held by a level of a cube whose first level has `size` texels a side: 2 .. 8192; above that the
/// level is the capture itself.
[[nodiscard]] double cube_level_power(int level, int size) noexcept;

/// Level of the chain for a power is `bias - log2(m) / 2`.
[[nodiscard]] double cube_level_bias(int size) noexcept;

/// The chain down to one texel a face. Level 0 is the capture. Below, each texel is the mean of the capture
/// weighed by (n.h)^m (n.l) dl with n = v = r, the direction of the texel, as [Karis13] splits the integral:
/// n.h = sqrt((1 + r.l) / 2). Directions whose weight is below 2^-30 of the greatest are left out.
[[nodiscard]] std::vector<CubeLevel> prefilter(CubeLevel capture);

}  // namespace aluminate::filter
