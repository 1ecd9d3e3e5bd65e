#include "calibration/photo.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
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

}  // namespace

Encoding parse_encoding(std::string_view name) {
  if (name == "srgb") return Encoding::Srgb;
  if (name == "linear") return Encoding::Linear;
  const std::vector<std::string> known{"srgb", "linear"};
  throw UserError(fmt::format("unknown encoding '{}'", name), host::did_you_mean(name, known));
}

std::string_view encoding_name(Encoding encoding) { return encoding == Encoding::Srgb ? "srgb" : "linear"; }

Photo photo_of(host::ImageFloat image, Encoding encoding, const std::string& name) {
  const std::size_t channels = image.channels.size();
  if (channels < 3)
    throw UserError({name}, "expected a colour photograph, found a grey image",
                    "a Bayer mosaic is read with --bayer RGGB|BGGR|GRBG|GBRG");
  Photo photo;
  photo.width = image.width;
  photo.height = image.height;
  const bool is_float = image.stored == host::StoredAs::Float;
  const int code_max = image.stored == host::StoredAs::Unorm8 ? 255 : 65535;
  photo.kind = is_float ? "floating point, linear"
                        : fmt::format("{}-bit {}", code_max == 255 ? 8 : 16, encoding_name(encoding));
  if (is_float) {
    photo.clip_high.fill(std::numeric_limits<double>::infinity());
  } else {
    photo.clip_low = 0.0;
  }
  const std::vector<float> table = is_float ? std::vector<float>{} : decoding_table(code_max, encoding);
  const std::size_t row_texels = static_cast<std::size_t>(photo.width);
  // In place when there is no alpha to drop: a large photograph is held once.
  if (channels != 3) photo.rgb_lin.resize(row_texels * static_cast<std::size_t>(photo.height) * 3);
  const float* from = image.texels.data();
  float* to = channels == 3 ? image.texels.data() : photo.rgb_lin.data();
  std::atomic<bool> all_finite{true};
  host::parallel_for(
      photo.height,
      [&](std::int64_t y) {
        const float* source = from + static_cast<std::size_t>(y) * row_texels * channels;
        float* target = to + static_cast<std::size_t>(y) * row_texels * 3;
        float not_finite = 0.0f;  // x * 0 is 0 for every finite x and NaN otherwise
        for (std::size_t x = 0; x < row_texels; ++x, source += channels, target += 3) {
          for (std::size_t c = 0; c < 3; ++c) {
            const float value = source[c];
            if (is_float) {
              not_finite += value * 0.0f;
              target[c] = value;
            } else {
              target[c] = table[static_cast<std::size_t>(value * static_cast<float>(code_max) + 0.5f)];
            }
          }
        }
        if (!(not_finite == 0.0f)) all_finite = false;
      },
      16);
  if (!all_finite)
    throw UserError({name}, "the image holds values that are not finite numbers",
                    "NaN or infinity: is the file damaged?");
  if (channels == 3) photo.rgb_lin = std::move(image.texels);
  apply_orientation(photo, image.orientation);
  return photo;
}

void apply_orientation(Photo& photo, int orientation) {
  if (orientation <= 1 || orientation > 8) return;
  const bool swaps = orientation >= 5;
  const int w = photo.width, h = photo.height, out_w = swaps ? h : w, out_h = swaps ? w : h;
  std::vector<float> turned(photo.rgb_lin.size());
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
