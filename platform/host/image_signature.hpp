// What an encoded image is, from its bytes alone, before a decoder sees it. Pure. Never allocates.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace aluminate::host {

/// OpenImageIO's name of the format ("png", "jpeg", "tiff", "openexr", "hdr", "bmp", "targa"), or nullptr.
/// TGA has no signature: it is taken from a name that ends in ".tga" when nothing else fits.
const char* image_format(std::span<const std::uint8_t> encoded, std::string_view name);

/// True for a JPEG without its end marker [JPEG-T81 B.1.1] or a PNG without its last chunk [PNG-W3C 5.6]. The other
/// decoders report missing data; libjpeg fills the rest with grey and calls it success.
bool is_cut_off(std::span<const std::uint8_t> encoded, std::string_view format);

}  // namespace aluminate::host
