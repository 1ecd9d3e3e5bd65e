// What an encoded image is and how large, from its first bytes; nothing is decoded.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace aluminate::scenes {

enum class ImageKind : std::uint8_t { Png, Jpeg, WebP, Ktx2, Basis, Dds, Gif, Bmp, Unknown };

struct ImageHeader {
  ImageKind kind = ImageKind::Unknown;
  int width_px = 0, height_px = 0;  // PNG and JPEG only; 0 = the header is cut off or damaged
};

std::string_view image_kind_name(ImageKind kind);  // "PNG", "JPEG", ...
ImageHeader read_image_header(std::span<const std::uint8_t> bytes);

}  // namespace aluminate::scenes
