// Sensor data. In: a camera raw or DNG (LibRaw), or a grey TIFF/PNG that is a Bayer mosaic. Out: the exact
// samples with their black and white levels and colour order, and from those a Photo: black subtracted,
// as-shot white balance, demosaiced [Malvar04], linear. The camera's colour matrix is not applied: the chart
// determines a better one.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "calibration/photo.hpp"
#include "platform/host/uninitialized.hpp"

namespace aluminate::calibration {

struct Mosaic {
  int width = 0, height = 0;
  host::UninitializedVector<std::uint16_t> samples;  // as stored
  std::array<char, 4> pattern{'R', 'G', 'G', 'B'};  // colours of pixels (0,0) (1,0) (0,1) (1,1)
  std::array<double, 3> black{0, 0, 0};             // codes of R, G, B
  double white = 65535;
  std::array<double, 3> multipliers{1, 1, 1};  // as shot, the smallest is 1
  int orientation = 1;
  std::string maker, model, lens;
  double focal_mm = 0, aperture = 0;  // 0: not known
};

/// By content: TIFF-like data with a raw photometric interpretation, or another container LibRaw names. A
/// plain TIFF is not.
bool looks_like_raw(std::span<const std::uint8_t> bytes, const std::string& name);

/// Throws UserError for a corrupt file, or one that is no Bayer mosaic.
Mosaic decode_raw(std::span<const std::uint8_t> bytes, const std::string& name);

/// A grey 8- or 16-bit picture as a mosaic. pattern: "RGGB", "BGGR", "GRBG" or "GBRG"; the samples are the
/// stored codes.
Mosaic mosaic_of_grey(const host::ImageFloat& image, const std::string& pattern, const std::string& name);

/// Linear RGB, 1 = white level before white balance.
Photo demosaic(const Mosaic& mosaic, const std::string& kind);

}  // namespace aluminate::calibration
