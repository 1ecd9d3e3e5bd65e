#include "calibration/correct_image.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "calibration/srgb_codes.hpp"
#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::calibration {
namespace {

// Pixels at a time: six columns of doubles stay in the first-level cache.
constexpr std::size_t kBlock = 512;
constexpr std::int64_t kRowsPerItem = 16;

CorrectionCounts& operator+=(CorrectionCounts& a, const CorrectionCounts& b) {
  a.pixels += b.pixels;
  a.negative += b.negative;
  a.above_one += b.above_one;
  a.too_dark += b.too_dark;
  a.too_bright += b.too_bright;
  a.clipped_input += b.clipped_input;
  return a;
}

void correct_block(float* rgb, std::size_t count, const Photo& photo, const Transform& transform,
                   CorrectionCounts& counts) noexcept {
  alignas(64) double r[kBlock], g[kBlock], b[kBlock];
  const float high_r = static_cast<float>(photo.clip_high[0]),
              high_g = static_cast<float>(photo.clip_high[1]),
              high_b = static_cast<float>(photo.clip_high[2]), low = static_cast<float>(photo.clip_low);
  int clipped = 0, negative = 0, above = 0, dark = 0, bright = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const float x = rgb[3 * i], y = rgb[3 * i + 1], z = rgb[3 * i + 2];
    clipped += (x >= high_r) | (y >= high_g) | (z >= high_b) | (x <= low) | (y <= low) | (z <= low);
    r[i] = static_cast<double>(x);
    g[i] = static_cast<double>(y);
    b[i] = static_cast<double>(z);
  }
  correct(transform, r, g, b, count);
  const auto& luminance = srgb_to_xyz_matrix()[1];
  const double lr = luminance[0], lg = luminance[1], lb = luminance[2];
  for (std::size_t i = 0; i < count; ++i) {
    const double y = lr * r[i] + lg * g[i] + lb * b[i];
    negative += (r[i] < 0.0) | (g[i] < 0.0) | (b[i] < 0.0);
    above += (r[i] > 1.0) | (g[i] > 1.0) | (b[i] > 1.0);
    dark += y < kDarkestAlbedo;
    bright += y > kBrightestAlbedo;
    rgb[3 * i] = static_cast<float>(r[i] > 0.0 ? r[i] : 0.0);
    rgb[3 * i + 1] = static_cast<float>(g[i] > 0.0 ? g[i] : 0.0);
    rgb[3 * i + 2] = static_cast<float>(b[i] > 0.0 ? b[i] : 0.0);
  }
  counts += {static_cast<std::int64_t>(count), negative, above, dark, bright, clipped};
}

enum class Container { Png, Tiff, Exr };

Container container_of(const std::string& path) {
  const std::size_t dot = path.find_last_of("./");
  std::string ending = dot != std::string::npos && path[dot] == '.' ? path.substr(dot) : "";
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  if (ending == ".png") return Container::Png;
  if (ending == ".tif" || ending == ".tiff") return Container::Tiff;
  if (ending == ".exr") return Container::Exr;
  throw UserError({path},
                  fmt::format("expected an output that ends in .png, .tif or .exr, found '{}'", ending));
}

template <class Code, class Convert>
std::vector<Code> codes_of(const Photo& photo, Convert&& convert) {
  std::vector<Code> codes(photo.rgb_lin.size());
  const std::size_t row = static_cast<std::size_t>(photo.width) * 3;
  host::parallel_for(
      photo.height,
      [&](std::int64_t y) {
        const std::size_t begin = static_cast<std::size_t>(y) * row;
        for (std::size_t i = begin; i < begin + row; ++i) codes[i] = convert(photo.rgb_lin[i]);
      },
      kRowsPerItem);
  return codes;
}

}  // namespace

CorrectionCounts correct_photo(Photo& photo, const Transform& transform) {
  const std::size_t row = static_cast<std::size_t>(photo.width);
  std::vector<CorrectionCounts> rows(static_cast<std::size_t>(photo.height));
  host::parallel_for(
      photo.height,
      [&](std::int64_t y) {
        float* rgb = photo.rgb_lin.data() + static_cast<std::size_t>(y) * row * 3;
        for (std::size_t x = 0; x < row; x += kBlock)
          correct_block(rgb + 3 * x, std::min(kBlock, row - x), photo, transform,
                        rows[static_cast<std::size_t>(y)]);
      },
      kRowsPerItem);
  CorrectionCounts total;
  for (const CorrectionCounts& counts : rows) total += counts;
  return total;
}

void check_output_name(const std::string& path, const OutputFormat& format) {
  const Container container = container_of(path);
  if (format.bits != 8 && format.bits != 16)
    throw UserError(fmt::format("{} bits a channel", format.bits), "8 or 16");
  if (format.bits == 8 && container == Container::Tiff)
    throw UserError({path}, "an 8-bit TIFF is not written", "use --bits 16, or a name that ends in .png");
  if (container == Container::Exr && format.encoding == Encoding::Srgb)
    return;  // EXR is linear whatever the default says
}

std::vector<std::uint8_t> encode_corrected(const Photo& photo, const std::string& path,
                                           const OutputFormat& format) {
  const Container container = container_of(path);
  const host::ImageMetadata metadata{{"Software", "aluminate calibrate"}};
  if (container == Container::Exr) {
    const std::size_t texels = photo.rgb_lin.size() / 3;
    std::array<std::vector<float>, 3> planes;
    host::parallel_for(3, [&](std::int64_t channel) {
      const std::size_t c = static_cast<std::size_t>(channel);
      planes[c].resize(texels);
      for (std::size_t i = 0; i < texels; ++i) planes[c][i] = photo.rgb_lin[3 * i + c];
    });
    const std::array<host::ExrLayer, 3> layers{{{"R", std::span<const float>(planes[0]), false},
                                                {"G", std::span<const float>(planes[1]), false},
                                                {"B", std::span<const float>(planes[2]), false}}};
    return host::encode_exr(photo.width, photo.height, layers, metadata);
  }
  const bool is_srgb = format.encoding == Encoding::Srgb;
  const SrgbCodes& srgb = SrgbCodes::instance();
  if (format.bits == 8) {
    host::Image8 image{photo.width, photo.height, 3, {}};
    image.texels = is_srgb ? codes_of<std::uint8_t>(photo, [&](float v) { return srgb.code8(v); })
                           : codes_of<std::uint8_t>(photo, [](float v) {
                               return static_cast<std::uint8_t>(std::min(v, 1.0f) * 255.0f + 0.5f);
                             });
    return host::encode_png(image, metadata);
  }
  const std::vector<std::uint16_t> codes =
      is_srgb ? codes_of<std::uint16_t>(photo, [&](float v) { return srgb.code16(v); })
              : codes_of<std::uint16_t>(photo, [](float v) {
                  return static_cast<std::uint16_t>(std::min(v, 1.0f) * 65535.0f + 0.5f);
                });
  return container == Container::Png ? host::encode_png16(photo.width, photo.height, codes, is_srgb)
                                     : host::encode_tiff16(photo.width, photo.height, codes);
}

}  // namespace aluminate::calibration
