// A number in [0, 1] to a colour a reader can order: viridis, perceptually uniform and safe for colour blindness
// [Viridis]. In: a value; out: sRGB 8-bit codes. Integer table, so heat maps are the same bytes everywhere.
#pragma once

#include <cstdint>

#include "platform/host/image_file.hpp"

namespace aluminate::host {

/// Entry 0 (dark violet, low) to 255 (yellow, high).
Rgb8 viridis(std::uint8_t index);

/// value/max on the map, rounded to the nearest entry; values above max are max, max 0 gives entry 0.
Rgb8 viridis(std::uint64_t value, std::uint64_t max);

}  // namespace aluminate::host
