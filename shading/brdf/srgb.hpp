// The sRGB transfer curve in double: the reference for decode and encode tables elsewhere.
// In and out: one channel, 1 = full scale. Never clamps except in the 8-bit functions.
#pragma once

#include <cmath>
#include <cstdint>

#include "shading/brdf/clamped.hpp"

namespace aluminate::brdf {

/// [IEC61966-2-1] Stored value to linear: s / 12.92 up to 0.04045, then ((s + 0.055) / 1.055)^2.4. Odd
/// continuation below 0. The two pieces meet within 3e-8 (the standard's constants are rounded).
[[nodiscard]] inline double srgb_to_linear(double stored) noexcept {
  if (stored < 0.0) return -srgb_to_linear(-stored);
  return stored <= 0.04045 ? stored / 12.92 : std::pow((stored + 0.055) / 1.055, 2.4);
}

/// [IEC61966-2-1] Linear to stored value: 12.92 x up to 0.0031308, then 1.055 x^(1/2.4) - 0.055.
[[nodiscard]] inline double linear_to_srgb(double linear) noexcept {
  if (linear < 0.0) return -linear_to_srgb(-linear);
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

/// Linear value of a stored byte.
[[nodiscard]] inline double srgb8_to_linear(std::uint8_t stored) noexcept {
  return srgb_to_linear(stored / 255.0);
}

/// Nearest stored byte of a linear value, clamped to [0, 1], halves up. linear_to_srgb8(srgb8_to_linear(b))
/// == b for all b.
[[nodiscard]] inline std::uint8_t linear_to_srgb8(double linear) noexcept {
  return static_cast<std::uint8_t>(std::floor(linear_to_srgb(clamped(linear)) * 255.0 + 0.5));
}

}  // namespace aluminate::brdf
