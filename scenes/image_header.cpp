#include "scenes/image_header.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace aluminate::scenes {
namespace {

using Bytes = std::span<const std::uint8_t>;

bool begins(Bytes bytes, std::string_view signature, std::size_t at = 0) {
  if (bytes.size() < at + signature.size()) return false;
  return std::equal(
      signature.begin(), signature.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at),
      [](char expected, std::uint8_t found) { return static_cast<std::uint8_t>(expected) == found; });
}

int big_endian(Bytes bytes, std::size_t at, int count) {
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[at + static_cast<std::size_t>(i)];
  return value > 0x7fffffff ? 0 : static_cast<int>(value);
}

/// Walks the marker segments to the frame header [JPEG-T81 B.2.2].
void read_jpeg_size(Bytes bytes, ImageHeader& header) {
  std::size_t at = 2;
  while (at + 9 <= bytes.size() && bytes[at] == 0xFF) {
    const std::uint8_t marker = bytes[at + 1];
    if (marker == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    const bool frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame) {
      header.height_px = big_endian(bytes, at + 5, 2);
      header.width_px = big_endian(bytes, at + 7, 2);
      return;
    }
    const bool alone = marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8);
    at += alone ? 2 : 2 + static_cast<std::size_t>(big_endian(bytes, at + 2, 2));
  }
}

}  // namespace

std::string_view image_kind_name(ImageKind kind) {
  static constexpr std::array<std::string_view, 9> kNames{"PNG", "JPEG", "WebP", "KTX2",   "Basis",
                                                          "DDS", "GIF",  "BMP",  "unknown"};
  return kNames[static_cast<std::size_t>(kind)];
}

ImageHeader read_image_header(Bytes bytes) {
  ImageHeader header;
  if (begins(bytes, "\x89PNG\r\n\x1a\n")) {
    header.kind = ImageKind::Png;
    if (begins(bytes, "IHDR", 12) && bytes.size() >= 24) {
      header.width_px = big_endian(bytes, 16, 4);
      header.height_px = big_endian(bytes, 20, 4);
    }
  } else if (begins(bytes, "\xFF\xD8\xFF")) {
    header.kind = ImageKind::Jpeg;
    read_jpeg_size(bytes, header);
  } else if (begins(bytes, "RIFF") && begins(bytes, "WEBP", 8)) {
    header.kind = ImageKind::WebP;
  } else if (begins(bytes, "\xABKTX 20\xBB")) {
    header.kind = ImageKind::Ktx2;
  } else if (begins(bytes, "sB")) {
    header.kind = ImageKind::Basis;
  } else if (begins(bytes, "DDS ")) {
    header.kind = ImageKind::Dds;
  } else if (begins(bytes, "GIF8")) {
    header.kind = ImageKind::Gif;
  } else if (begins(bytes, "BM")) {
    header.kind = ImageKind::Bmp;
  }
  return header;
}

}  // namespace aluminate::scenes
