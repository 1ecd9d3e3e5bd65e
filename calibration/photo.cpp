#include "calibration/photo.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"
#include "platform/host/suggest.hpp"

namespace aluminate::calibration {
namespace {

std::vector<float> decoding_table(int code_max, Encoding encoding) {
  std::vector<float> table(static_cast<std::size_t>(code_max) + 1);
  for (std::size_t code = 0; code < table.size(); ++code) {
    const double encoded = static_cast<double>(code) / code_max;
    table[code] = static_cast<float>(encoding == Encoding::Srgb ? srgb_to_linear(encoded) : encoded);
  }
  return table;
}

Photo empty_photo(int width, int height, std::size_t channels, host::StoredAs stored, Encoding encoding,
                  const std::string& name) {
  if (channels < 3)
    throw UserError({name}, "expected a colour photograph, found a grey image",
                    "a Bayer mosaic is read with --bayer RGGB|BGGR|GRBG|GBRG");
  Photo photo;
  photo.width = width;
  photo.height = height;
  if (stored == host::StoredAs::Float) {
    photo.kind = "floating point, linear";
    photo.clip_high.fill(std::numeric_limits<double>::infinity());
  } else {
    photo.kind = fmt::format("{}-bit {}", stored == host::StoredAs::Unorm8 ? 8 : 16, encoding_name(encoding));
    photo.clip_low = 0.0;
  }
  photo.rgb_lin.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
  return photo;
}

// convert(index of a source texel's first value, three linear values) for every pixel.
template <class Convert>
void fill_rows(Photo& photo, std::size_t channels, const Convert& convert) {
  const std::size_t row = static_cast<std::size_t>(photo.width);
  host::parallel_for(
      photo.height,
      [&](std::int64_t y) {
        const std::size_t first = static_cast<std::size_t>(y) * row;
        float* target = photo.rgb_lin.data() + 3 * first;
        for (std::size_t x = 0; x < row; ++x, target += 3) convert((first + x) * channels, target);
      },
      16);
}

}  // namespace

Encoding parse_encoding(std::string_view name) {
  if (name == "srgb") return Encoding::Srgb;
  if (name == "linear") return Encoding::Linear;
  const std::vector<std::string> known{"srgb", "linear"};
  throw UserError(fmt::format("unknown encoding '{}'", name), host::did_you_mean(name, known));
}

std::string_view encoding_name(Encoding encoding) { return encoding == Encoding::Srgb ? "srgb" : "linear"; }

Photo photo_of(const host::ImageFloat& image, Encoding encoding, const std::string& name) {
  Photo photo = empty_photo(image.width, image.height, image.channels.size(), image.stored, encoding, name);
  const float* const texels = image.texels.data();
  if (image.stored == host::StoredAs::Float) {
    std::atomic<bool> all_finite{true};
    fill_rows(photo, image.channels.size(), [&](const std::size_t texel, float* target) {
      const float* const source = texels + texel;
      // x * 0 is 0 for every finite x and NaN otherwise.
      if (!(source[0] * 0.0f + source[1] * 0.0f + source[2] * 0.0f == 0.0f)) all_finite = false;
      std::copy_n(source, 3, target);
    });
    if (!all_finite)
      throw UserError({name}, "the image holds values that are not finite numbers",
                      "NaN or infinity: is the file damaged?");
  } else {
    const int code_max = image.stored == host::StoredAs::Unorm8 ? 255 : 65535;
    const std::vector<float> table = decoding_table(code_max, encoding);
    fill_rows(photo, image.channels.size(), [&](const std::size_t texel, float* target) {
      for (std::size_t c = 0; c < 3; ++c)
        target[c] = table[static_cast<std::size_t>(texels[texel + c] * static_cast<float>(code_max) + 0.5f)];
    });
  }
  apply_orientation(photo, image.orientation);
  return photo;
}

Photo photo_of(const host::ImageCodes& image, Encoding encoding, const std::string& name) {
  const std::size_t channels = static_cast<std::size_t>(image.channels);
  Photo photo = empty_photo(image.width, image.height, channels, image.stored, encoding, name);
  const bool is_short = image.stored == host::StoredAs::Unorm16;
  const std::vector<float> table = decoding_table(is_short ? 65535 : 255, encoding);
  const std::uint8_t* const bytes = image.bytes.data();
  if (is_short) {
    fill_rows(photo, channels, [&](const std::size_t texel, float* target) {
      std::array<std::uint16_t, 3> codes;
      std::memcpy(codes.data(), bytes + 2 * texel, sizeof codes);
      for (std::size_t c = 0; c < 3; ++c) target[c] = table[codes[c]];
    });
  } else {
    fill_rows(photo, channels, [&](const std::size_t texel, float* target) {
      for (std::size_t c = 0; c < 3; ++c) target[c] = table[bytes[texel + c]];
    });
  }
  apply_orientation(photo, image.orientation);
  return photo;
}

void apply_orientation(Photo& photo, int orientation) {
  if (orientation <= 1 || orientation > 8) return;
  const bool swaps = orientation >= 5;
  const int w = photo.width, h = photo.height, out_w = swaps ? h : w, out_h = swaps ? w : h;
  host::UninitializedVector<float> turned(photo.rgb_lin.size());
  host::parallel_for(
      out_h,
      [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        float* target = turned.data() + 3 * static_cast<std::size_t>(y) * static_cast<std::size_t>(out_w);
        for (int x = 0; x < out_w; ++x, target += 3) {
          int sx = x, sy = y;
          switch (orientation) {  // where the shown pixel (x, y) is stored
            case 2:
              sx = w - 1 - x;
              break;
            case 3:
              sx = w - 1 - x;
              sy = h - 1 - y;
              break;
            case 4:
              sy = h - 1 - y;
              break;
            case 5:
              sx = y;
              sy = x;
              break;
            case 6:
              sx = y;
              sy = h - 1 - x;
              break;
            case 7:
              sx = w - 1 - y;
              sy = h - 1 - x;
              break;
            default:
              sx = w - 1 - y;
              sy = x;
              break;
          }
          const float* source = photo.pixel(sx, sy);
          for (std::size_t c = 0; c < 3; ++c) target[c] = source[c];
        }
      },
      8);
  photo.rgb_lin = std::move(turned);
  photo.width = out_w;
  photo.height = out_h;
}

}  // namespace aluminate::calibration
