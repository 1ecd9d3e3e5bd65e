// Counts as pictures a person can read: viridis for one plane, blue-white-orange for a difference, each with
// a legend that states what is shown, the unit and the scale.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "platform/host/image_file.hpp"

namespace aluminate::report {

/// values: width*height. 0 is black, 1..scale_max runs through viridis; above scale_max is the last colour
/// (the legend counts those pixels). title: "ALU words per pixel, schlick-smith".
host::Image8 heat_map(int width, int height, std::span<const std::uint32_t> values, std::uint32_t scale_max,
                      const std::string& title);

/// b - a: blue where b is smaller, white where equal, orange where larger; the scale is symmetric and ends at
/// the 99th percentile of the differing pixels.
host::Image8 difference_heat_map(int width, int height, std::span<const std::uint32_t> a,
                                 std::span<const std::uint32_t> b, const std::string& title);

/// |a - b| per channel times gain, clamped: stored values, no legend, same size as the pictures.
host::Image8 difference_image(int width, int height, std::span<const std::uint8_t> rgba_a,
                              std::span<const std::uint8_t> rgba_b, int gain);

}  // namespace aluminate::report
