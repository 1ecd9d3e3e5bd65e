#include "platform/host/image_signature.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace aluminate::host {
namespace {

struct Signature {
  std::string_view bytes;
  const char* format;
};

using std::string_view_literals::operator""sv;
constexpr std::array kSignatures{
    Signature{"\x89PNG\r\n\x1a\n"sv, "png"},  Signature{"\xff\xd8\xff"sv, "jpeg"},
    Signature{"\x76\x2f\x31\x01"sv, "openexr"}, Signature{"II*\0"sv, "tiff"},
    Signature{"MM\0*"sv, "tiff"},             Signature{"II+\0"sv, "tiff"},
    Signature{"MM\0+"sv, "tiff"},             Signature{"#?RADIANCE"sv, "hdr"},
    Signature{"#?RGBE"sv, "hdr"},             Signature{"BM"sv, "bmp"},
};

bool ends_with_folded(std::string_view text, std::string_view end) {
  if (text.size() < end.size()) return false;
  return std::equal(end.begin(), end.end(), text.end() - static_cast<std::ptrdiff_t>(end.size()),
                    [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b - 'A' + 'a' : b); });
}

// Marker segments up to a scan, then entropy-coded data in which FF is followed by 00 or a restart marker; several scans
// may follow each other. A thumbnail's end marker lies inside a segment and is jumped over.
bool jpeg_has_end(std::span<const std::uint8_t> jpeg) {
  constexpr std::uint8_t kEnd = 0xd9, kRestartFirst = 0xd0, kRestartLast = 0xd7, kTemporary = 0x01;
  std::size_t at = 2;  // behind the start marker
  while (at + 1 < jpeg.size()) {
    if (jpeg[at] != 0xff) {
      ++at;  // entropy-coded data, or padding that decoders skip as well
      continue;
    }
    const std::uint8_t marker = jpeg[at + 1];
    if (marker == 0xff) {
      ++at;  // fill byte
    } else if (marker == kEnd) {
      return true;
    } else if (marker == 0 || marker == kTemporary || (marker >= kRestartFirst && marker <= kRestartLast)) {
      at += 2;
    } else {
      if (at + 3 >= jpeg.size()) return false;
      at += 2 + (std::size_t{jpeg[at + 2]} << 8 | jpeg[at + 3]);  // a scan header, too, is followed by its data
    }
  }
  return false;
}

// Chunks of a length, a name, that many bytes and a checksum; the last one is IEND.
bool png_has_end(std::span<const std::uint8_t> png) {
  constexpr std::size_t kChunkBytes = 12;
  std::size_t at = 8;  // behind the signature
  while (at + kChunkBytes <= png.size()) {
    const std::size_t length = std::size_t{png[at]} << 24 | std::size_t{png[at + 1]} << 16 |
                               std::size_t{png[at + 2]} << 8 | png[at + 3];
    const std::string_view name(reinterpret_cast<const char*>(png.data() + at + 4), 4);
    at += kChunkBytes + length;
    if (name == "IEND") return at <= png.size();
  }
  return false;
}

}  // namespace

const char* image_format(std::span<const std::uint8_t> encoded, std::string_view name) {
  const std::string_view bytes(reinterpret_cast<const char*>(encoded.data()), encoded.size());
  for (const Signature& signature : kSignatures) {
    if (bytes.starts_with(signature.bytes)) return signature.format;
  }
  return ends_with_folded(name, ".tga") ? "targa" : nullptr;
}

bool is_cut_off(std::span<const std::uint8_t> encoded, std::string_view format) {
  return (format == "jpeg" && !jpeg_has_end(encoded)) || (format == "png" && !png_has_end(encoded));
}

}  // namespace aluminate::host
