// Mip chain of a normal map in double, un-normalised: the length of each mean is what Toksvig's factor reads.
// In: an RGBA8 tangent-space normal map. Out: per level the mean vector of the unit normals under each texel.
// Never re-normalises a level: that is exactly the information to keep. Never averages quantised lengths:
// texels become unit vectors first.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace aluminate::filter {

/// A row-major picture of 4 bytes a texel, tangent space: n = 2 rgb / 255 - 1. pixels.size() == 4 width
/// height.
struct Rgba8View {
  std::span<const std::uint8_t> pixels;
  int width = 0, height = 0;
};

template <class Value>
struct Level {
  int width = 0, height = 0;
  std::vector<Value> texels;  // row-major, width * height
  [[nodiscard]] const Value& at(int x, int y) const {
    return texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};
using NormalLevel = Level<glm::dvec3>;
using ScalarLevel = Level<double>;

/// Unit vector of a stored normal; (0, 0, 1) where the texel holds no direction. 8 bits cannot store length
/// 1: (128, 128, 255) decodes to 1.00002 long and a diagonal to as little as 0.993, which at power 8192 would
/// already read as roughness.
[[nodiscard]] glm::dvec3 decode_normal(std::uint8_t r, std::uint8_t g, std::uint8_t b) noexcept;

/// Level 0: the decoded map. UserError for an empty map or a size that does not match.
[[nodiscard]] NormalLevel decode_normal_map(const Rgba8View& map);
/// Level 0 of one channel (0..3) as value / 255.
[[nodiscard]] ScalarLevel decode_channel(const Rgba8View& map, int channel);

/// Half the size, rounded down but at least 1, each texel the exact area average of what it covers: a 2x2 box
/// for even sizes, the box with fractional edges for odd ones. The mean over the picture is kept to rounding.
[[nodiscard]] NormalLevel halve(const NormalLevel& level);
[[nodiscard]] ScalarLevel halve(const ScalarLevel& level);

/// All levels down to 1x1, level 0 first.
[[nodiscard]] std::vector<NormalLevel> mip_chain(NormalLevel base);
[[nodiscard]] std::vector<ScalarLevel> mip_chain(ScalarLevel base);

/// Convolution with a Gaussian of `sigma` texels (cut at 3 sigma, wrapping at the edges): the footprint of a
/// texel that overlaps its neighbours. Applied to every level, also 0, base and mip 1 filter alike [Hill11].
/// sigma <= 0 returns the level.
[[nodiscard]] NormalLevel gaussian(const NormalLevel& level, double sigma);

}  // namespace aluminate::filter
