// Linear light to integer codes, fast: the sRGB curve from a table indexed by the leading bits of a float,
// interpolated. Error of the encoded value below 1e-7 plus float rounding (0.01 of a 16-bit step), so every
// code that was decoded from a 16-bit file is met again. Values outside of [0, 1] are clipped; counting them
// is the caller's business.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace aluminate::calibration {

class SrgbCodes {
 public:
  static const SrgbCodes& instance();

  /// [0, 1] to [0, 1].
  float encode(float linear) const noexcept {
    if (!(linear > 0.0f)) return 0.0f;
    if (linear >= 1.0f) return 1.0f;
    if (linear <= 0.0031308f) return 12.92f * linear;
    const std::uint32_t offset = std::bit_cast<std::uint32_t>(linear) - kFirstBits;
    const Entry& entry = table_[offset >> kShift];
    return entry.value + entry.slope * (linear - entry.from);
  }
  std::uint16_t code16(float linear) const noexcept {
    return static_cast<std::uint16_t>(encode(linear) * 65535.0f + 0.5f);
  }
  std::uint8_t code8(float linear) const noexcept {
    return static_cast<std::uint8_t>(encode(linear) * 255.0f + 0.5f);
  }

 private:
  SrgbCodes();
  // 2^-9 = 0.00195 <= 0.0031308; 10 bits of mantissa: the chord of x^(1/2.4) is off by at most 0.24/8 * 2^-20
  // of the value.
  static constexpr std::uint32_t kFirstBits = (127u - 9u) << 23;
  static constexpr int kShift = 23 - 10;
  struct Entry {
    float from, value, slope;
  };
  std::vector<Entry> table_;
};

}  // namespace aluminate::calibration
