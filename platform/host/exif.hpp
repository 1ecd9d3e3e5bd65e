// The one fact of EXIF [EXIF32] that changes what a picture shows.
#pragma once

#include <cstdint>
#include <span>

namespace aluminate::host {

/// Orientation 1..8 from the TIFF structure inside an EXIF block (without the "Exif\0\0" of JPEG). 1 when there is none,
/// or when the block is damaged. Pure.
int exif_orientation(std::span<const std::uint8_t> tiff) noexcept;

}  // namespace aluminate::host
