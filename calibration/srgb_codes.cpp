#include "calibration/srgb_codes.hpp"

#include "calibration/colour_space.hpp"

namespace aluminate::calibration {

const SrgbCodes& SrgbCodes::instance() {
  static const SrgbCodes codes;
  return codes;
}

SrgbCodes::SrgbCodes() {
  const std::uint32_t count = (std::bit_cast<std::uint32_t>(1.0f) - kFirstBits) >> kShift;
  table_.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double from = static_cast<double>(std::bit_cast<float>(kFirstBits + (i << kShift)));
    const double to = static_cast<double>(std::bit_cast<float>(kFirstBits + ((i + 1) << kShift)));
    const double at_from = linear_to_srgb(from), at_to = linear_to_srgb(to);
    table_.push_back({static_cast<float>(from), static_cast<float>(at_from),
                      static_cast<float>((at_to - at_from) / (to - from))});
  }
}

}  // namespace aluminate::calibration
