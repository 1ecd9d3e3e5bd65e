#include "shading/report/statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "platform/host/error.hpp"

namespace aluminate::report {

Distribution distribution(std::span<const std::uint32_t> values, std::span<const std::uint8_t> drawn) {
  ALU_CHECK(values.size() == drawn.size(), "{} values, {} flags", values.size(), drawn.size());
  Distribution d;
  std::vector<std::uint32_t> sorted;
  sorted.reserve(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!drawn[i] && values[i] == 0) continue;
    sorted.push_back(values[i]);
    d.total += values[i];
  }
  d.pixels = sorted.size();
  if (sorted.empty()) return d;
  d.max = *std::max_element(sorted.begin(), sorted.end());
  const auto percentile = [&sorted](std::size_t percent) {
    const std::size_t rank = (sorted.size() * percent + 99) / 100 - 1;  // nearest rank
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(rank), sorted.end());
    return sorted[rank];
  };
  d.p95 = percentile(95);
  d.p99 = percentile(99);
  return d;
}

ImageDifference compare_images(int width, std::span<const std::uint8_t> rgba_a,
                               std::span<const std::uint8_t> rgba_b) {
  ALU_CHECK(rgba_a.size() == rgba_b.size() && width > 0, "{} and {} bytes", rgba_a.size(), rgba_b.size());
  ImageDifference d;
  d.pixels = rgba_a.size() / 4;
  std::uint64_t histogram[256] = {};  // differing pixels by their largest channel
  for (std::size_t i = 0; i < d.pixels; ++i) {
    const int x = static_cast<int>(i % static_cast<std::size_t>(width)),
              y = static_cast<int>(i / static_cast<std::size_t>(width));
    int largest = 0;
    for (int channel = 0; channel < 3; ++channel) {
      const std::size_t at = i * 4 + static_cast<std::size_t>(channel);
      const int step = std::abs(int{rgba_a[at]} - int{rgba_b[at]});
      largest = std::max(largest, step);
      d.total_steps += static_cast<std::uint64_t>(step);
      if (step > d.max_step) {
        d.max_step = step;
        d.worst_x = x;
        d.worst_y = y;
        d.worst_channel = channel;
      }
    }
    if (largest == 0) continue;
    ++histogram[largest];
    if (d.differing++ == 0) {
      d.first_x = x;
      d.first_y = y;
    }
  }
  for (std::uint64_t below = 0; d.differing > 0 && below * 100 < d.differing * 99;
       below += histogram[d.p99_step])
    ++d.p99_step;
  return d;
}

std::string difference_text(const ImageDifference& d, int width, std::span<const std::uint8_t> rgba_a,
                            std::span<const std::uint8_t> rgba_b) {
  if (d.same()) return fmt::format("equal: {} pixels\n", d.pixels);
  static constexpr const char* kChannels[] = {"red", "green", "blue"};
  const std::size_t at = (static_cast<std::size_t>(d.worst_y) * static_cast<std::size_t>(width) +
                          static_cast<std::size_t>(d.worst_x)) *
                             4 +
                         static_cast<std::size_t>(d.worst_channel);
  return fmt::format(
      "{} of {} pixels differ ({:.2f} %), mean {:.4f} steps of 255\n"
      "largest {} steps at ({}, {}) {}: {} and {}\n"
      "first at ({}, {})\n",
      d.differing, d.pixels, 100.0 * static_cast<double>(d.differing) / static_cast<double>(d.pixels),
      d.mean_step(), d.max_step, d.worst_x, d.worst_y, kChannels[d.worst_channel], rgba_a[at], rgba_b[at],
      d.first_x, d.first_y);
}

}  // namespace aluminate::report
