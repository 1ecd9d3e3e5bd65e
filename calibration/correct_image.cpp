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

// Corrects one row in place.
void correct_row(Photo& photo, std::int64_t y, const Transform& transform,
                 CorrectionCounts& counts) noexcept {
  const std::size_t row = static_cast<std::size_t>(photo.width);
  float* rgb = photo.rgb_lin.data() + static_cast<std::size_t>(y) * row * 3;
  for (std::size_t x = 0; x < row; x += kBlock)
    correct_block(rgb + 3 * x, std::min(kBlock, row - x), photo, transform, counts);
}

CorrectionCounts total_of(const std::vector<CorrectionCounts>& rows) {
  CorrectionCounts total;
  for (const CorrectionCounts& counts : rows) total += counts;
  return total;
}

std::uint16_t linear_code(float value, float code_max) noexcept {
  return static_cast<std::uint16_t>(std::min(value, 1.0f) * code_max + 0.5f);
}

// row_at(y): width*3 values of 0 or more; asked once for each row, by several threads.
template <class RowAt>
void write_rows(int width, int height, const RowAt& row_at, const std::string& path,
                const OutputFormat& format, const host::ByteSink& sink) {
  const Container container = container_of(path);
  const std::size_t values = 3 * static_cast<std::size_t>(width);
  const bool is_srgb = format.encoding == Encoding::Srgb;
  const SrgbCodes& srgb = SrgbCodes::instance();
  if (container == Container::Exr) {
    host::write_exr_rgb(
        width, height, [&](int y, float* to) { std::copy_n(row_at(y), values, to); }, sink);
    return;
  }
  if (format.bits == 8) {
    host::Image8 image{width, height, 3, {}};
    image.texels.resize(values * static_cast<std::size_t>(height));
    host::parallel_for(
        height,
        [&](std::int64_t y) {
          const float* from = row_at(static_cast<int>(y));
          std::uint8_t* to = image.texels.data() + static_cast<std::size_t>(y) * values;
          for (std::size_t i = 0; i < values; ++i)
            to[i] = is_srgb ? srgb.code8(from[i]) : static_cast<std::uint8_t>(linear_code(from[i], 255.0f));
        },
        kRowsPerItem);
    sink(host::encode_png(image, {{"Software", "aluminate calibrate"}}));
    return;
  }
  const host::RowOfCodes codes = [&](int y, std::uint16_t* to) {
    const float* from = row_at(y);
    if (is_srgb)
      for (std::size_t i = 0; i < values; ++i) to[i] = srgb.code16(from[i]);
    else
      for (std::size_t i = 0; i < values; ++i) to[i] = linear_code(from[i], 65535.0f);
  };
  if (container == Container::Png)
    host::write_png16(width, height, is_srgb, codes, sink);
  else
    host::write_tiff16(width, height, codes, sink);
}

}  // namespace

CorrectionCounts correct_photo(Photo& photo, const Transform& transform) {
  std::vector<CorrectionCounts> rows(static_cast<std::size_t>(photo.height));
  host::parallel_for(
      photo.height,
      [&](std::int64_t y) { correct_row(photo, y, transform, rows[static_cast<std::size_t>(y)]); },
      kRowsPerItem);
  return total_of(rows);
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

CorrectionCounts correct_and_write(Photo& photo, const Transform& transform, const std::string& path,
                                   const OutputFormat& format, const host::ByteSink& sink) {
  std::vector<CorrectionCounts> rows(static_cast<std::size_t>(photo.height));
  const std::size_t values = 3 * static_cast<std::size_t>(photo.width);
  write_rows(
      photo.width, photo.height,
      [&](int y) {
        correct_row(photo, y, transform, rows[static_cast<std::size_t>(y)]);
        return photo.rgb_lin.data() + static_cast<std::size_t>(y) * values;
      },
      path, format, sink);
  return total_of(rows);
}

void write_corrected(const Photo& photo, const std::string& path, const OutputFormat& format,
                     const host::ByteSink& sink) {
  const std::size_t values = 3 * static_cast<std::size_t>(photo.width);
  write_rows(
      photo.width, photo.height,
      [&](int y) { return photo.rgb_lin.data() + static_cast<std::size_t>(y) * values; }, path, format, sink);
}

}  // namespace aluminate::calibration
