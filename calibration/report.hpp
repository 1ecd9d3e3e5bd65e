// A page for a person: the chart's place in the photograph, before and after, residuals in the chromaticity
// diagram, every patch's error, and which pixels are no plausible material. HTML is one file without outside
// references; PNG is the pictures and the diagram of it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calibration/calibrate.hpp"

namespace aluminate::calibration {

/// A reduced picture of a photograph in 8-bit sRGB: at most 900 px wide or high.
host::Image8 thumbnail(const Photo& photo);
/// The same of an albedo, pixels outside of the plausible range in magenta (too bright) and cyan (too dark).
host::Image8 range_picture(const Photo& corrected);

struct ReportPictures {
  host::Image8 before, after, range;
};

std::string report_html(const Calibration& calibration, const ReportPictures& pictures);
std::vector<std::uint8_t> report_png(const Calibration& calibration, const ReportPictures& pictures);

}  // namespace aluminate::calibration
