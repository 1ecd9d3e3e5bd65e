// PNG and JPEG, read by their own libraries: OpenImageIO reads them too, but loading it takes longer than most pictures.
// In: encoded bytes whose signature was seen. Out: codes as stored. Errors are UserError and name the image; truncated or
// damaged data is an error, never half an image.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "platform/host/image_file.hpp"

namespace aluminate::host {

/// Refuses what image_file.hpp's limits refuse. Called with the header's numbers, before anything is allocated.
void check_image_size(const std::string& name, std::int64_t width, std::int64_t height, std::int64_t depth, std::int64_t channels);

/// 1 (grey), 2 (grey, alpha), 3 or 4 channels of 8 or 16 bits. A palette becomes its colours, transparency alpha, fewer
/// than 8 bits become 8. Nothing is converted by gamma or profile.
ImageCodes decode_png(std::span<const std::uint8_t> encoded, const std::string& name);

/// 1 or 3 channels of 8 bits. Nothing for CMYK, which only OpenImageIO turns into colours.
std::optional<ImageCodes> decode_jpeg(std::span<const std::uint8_t> encoded, const std::string& name);

}  // namespace aluminate::host
