// A transform applied to every pixel, in place, rows in parallel; and pixels as the bytes of a picture file,
// made and passed on while later rows are still being corrected. In: a photograph, a transform. Out: albedo
// in linear sRGB and how many pixels are no plausible material.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "calibration/photo.hpp"
#include "calibration/transform.hpp"

namespace aluminate::calibration {

/// Luminance of common materials under diffuse light lies between charcoal and fresh snow [Lagarde11]; with a
/// margin for noise, the chart's own black (0.03) and white (0.90) inside.
inline constexpr double kDarkestAlbedo = 0.02, kBrightestAlbedo = 0.92;

struct CorrectionCounts {
  std::int64_t pixels = 0;
  std::int64_t negative = 0;       // a channel below 0: clipped in the picture
  std::int64_t above_one = 0;      // a channel above 1: clipped in integer pictures
  std::int64_t too_dark = 0;       // luminance below kDarkestAlbedo: a hole, a shadow, flare taken off
  std::int64_t too_bright = 0;     // luminance above kBrightestAlbedo: a highlight, a light
  std::int64_t clipped_input = 0;  // a channel of the photograph at its limit: its albedo is a guess
};

/// photo.rgb_lin becomes albedo; negative channels become 0 after counting.
CorrectionCounts correct_photo(Photo& photo, const Transform& transform);

struct OutputFormat {
  Encoding encoding = Encoding::Srgb;
  int bits = 16;  // 8 or 16; EXR is always 32-bit float linear
};

/// By the name's ending: .png (8 or 16 bits), .tif or .tiff (16), .exr. Throws UserError for others before
/// any work.
void check_output_name(const std::string& path, const OutputFormat& format);
/// correct_photo, and the result to sink as the file that path names.
CorrectionCounts correct_and_write(Photo& photo, const Transform& transform, const std::string& path,
                                   const OutputFormat& format, const host::ByteSink& sink);
/// A photograph that is corrected already.
void write_corrected(const Photo& corrected, const std::string& path, const OutputFormat& format,
                     const host::ByteSink& sink);

}  // namespace aluminate::calibration
