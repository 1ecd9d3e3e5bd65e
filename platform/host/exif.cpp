#include "platform/host/exif.hpp"

#include <cstddef>

namespace aluminate::host {

int exif_orientation(std::span<const std::uint8_t> tiff) noexcept {
  constexpr int kUpright = 1;
  constexpr std::uint32_t kMagic = 42, kOrientation = 0x0112, kShort = 3;
  if (tiff.size() < 8) return kUpright;
  const bool little = tiff[0] == 'I' && tiff[1] == 'I';
  if (!little && !(tiff[0] == 'M' && tiff[1] == 'M')) return kUpright;
  const auto number = [&](std::size_t at, std::size_t size) {  // at + size <= tiff.size()
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value = value << 8 | tiff[at + (little ? size - 1 - i : i)];
    return value;
  };
  const std::size_t directory = number(4, 4);
  if (number(2, 2) != kMagic || directory > tiff.size() - 2) return kUpright;
  const std::size_t entries = number(directory, 2);
  constexpr std::size_t kEntryBytes = 12;
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t at = directory + 2 + i * kEntryBytes;
    if (at + kEntryBytes > tiff.size()) return kUpright;
    if (number(at, 2) != kOrientation) continue;
    const std::uint32_t value = number(at + 8, 2);
    return number(at + 2, 2) == kShort && value >= 1 && value <= 8 ? static_cast<int>(value) : kUpright;
  }
  return kUpright;
}

}  // namespace aluminate::host
