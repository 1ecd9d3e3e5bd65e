// Distributions of per-pixel costs and differences between two pictures: exact integer statistics, no
// sampling.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace aluminate::report {

/// Of the pixels that were drawn at all. mean = total / pixels; p95, p99 = smallest value that so many
/// percent do not exceed.
struct Distribution {
  std::uint64_t pixels = 0, total = 0;
  std::uint32_t p95 = 0, p99 = 0, max = 0;
  double mean() const { return pixels ? static_cast<double>(total) / static_cast<double>(pixels) : 0.0; }
};

/// values and drawn have one entry per pixel; pixels with drawn == 0 count only where their value is not 0
/// (helper lanes).
Distribution distribution(std::span<const std::uint32_t> values, std::span<const std::uint8_t> drawn);

/// Two RGBA8 pictures of equal size, compared on RGB in stored 8-bit steps.
struct ImageDifference {
  std::uint64_t pixels = 0, differing = 0;
  int max_step = 0;
  int worst_x = -1, worst_y = -1,
      worst_channel = 0;           // first pixel with the largest difference, in reading order
  int first_x = -1, first_y = -1;  // first differing pixel, in reading order
  std::uint64_t total_steps = 0;   // over pixels and channels
  int p99_step = 0;                // of the differing pixels, largest channel
  double mean_step() const {
    return pixels ? static_cast<double>(total_steps) / (3.0 * static_cast<double>(pixels)) : 0.0;
  }
  bool same() const { return differing == 0; }
};

ImageDifference compare_images(int width, std::span<const std::uint8_t> rgba_a,
                               std::span<const std::uint8_t> rgba_b);

/// "412 of 921600 pixels differ (0.04 %), largest 3 of 255 at (811, 402) green: 96 and 99, ..." or "equal";
/// ends in a newline.
std::string difference_text(const ImageDifference& difference, int width,
                            std::span<const std::uint8_t> rgba_a, std::span<const std::uint8_t> rgba_b);

}  // namespace aluminate::report
