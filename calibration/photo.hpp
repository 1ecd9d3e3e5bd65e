// A photograph in linear light. In: a file of any kind aluminate reads (platform/host/image_file.hpp), or a
// camera raw (calibration/raw_file.hpp). Out: linear RGB in float, upright, and the levels at which a value
// says nothing any more.
#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "calibration/colour_space.hpp"
#include "platform/host/image_file.hpp"

namespace aluminate::calibration {

enum class Encoding { Srgb, Linear };
Encoding parse_encoding(std::string_view name);  // "srgb", "linear"
std::string_view encoding_name(Encoding encoding);

struct Photo {
  int width = 0, height = 0;
  host::UninitializedVector<float>
      rgb_lin;  // width*height*3, row 0 on top, as shown: EXIF rotation is applied
  std::array<double, 3> clip_high{1, 1, 1};  // a value at or above carries no information
  double clip_low = -1e30;                   // nor one at or below; 0 for integer codes
  std::string kind;                          // "8-bit sRGB", "16-bit linear", "EXR", "raw ..."

  const float* pixel(int x, int y) const {
    return rgb_lin.data() +
           3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
};

/// sRGB codes become linear light; encoding says what integers mean, floating point values are always linear.
/// Alpha is dropped, grey is refused (a photograph of a chart has colour). Values that are not finite are
/// refused.
Photo photo_of(const host::ImageFloat& image, Encoding encoding, const std::string& name);
Photo photo_of(const host::ImageCodes& image, Encoding encoding, const std::string& name);

/// Turns the pixels so that an EXIF orientation (1..8) becomes 1.
void apply_orientation(Photo& photo, int orientation);

}  // namespace aluminate::calibration
