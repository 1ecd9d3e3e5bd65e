// A deterministic bumpy normal map with a flat quarter: the common input of the filter tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <numbers>
#include <vector>

namespace aluminate::filter {

/// RGBA8, size x size, rgb = normal of a height field of slope `steepness` (0: flat), a = gloss_u8.
inline std::vector<std::uint8_t> bumpy_map(int size, double steepness, std::uint8_t gloss_u8) {
  const double p = 2.0 * std::numbers::pi / size;
  const auto height = [&](double x, double y) {
    return steepness * (std::sin(9 * p * x + 2 * std::sin(3 * p * y)) * std::cos(7 * p * y) +
                        0.5 * std::sin(23 * p * x + 5 * p * y) * (0.5 + 0.5 * std::sin(p * x * 2)));
  };
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const bool flat = x < size / 2 && y < size / 2;
      const double dx = flat ? 0.0 : height(x + 1, y) - height(x - 1, y);
      const double dy = flat ? 0.0 : height(x, y + 1) - height(x, y - 1);
      const glm::dvec3 n = glm::normalize(glm::dvec3(-dx, -dy, 1));
      for (int k = 0; k < 3; ++k)
        pixels.push_back(static_cast<std::uint8_t>(std::lround((n[k] * 0.5 + 0.5) * 255.0)));
      pixels.push_back(gloss_u8);
    }
  return pixels;
}

}  // namespace aluminate::filter
