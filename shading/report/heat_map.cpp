#include "shading/report/heat_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "platform/host/color_map.hpp"

namespace aluminate::report {
namespace {

using host::Image8;
using host::Rgb8;

constexpr int kLegendHeight = 44;  // px under the picture
constexpr int kBarHeight = 12;
constexpr int kMargin = 8;
constexpr int kTextSize = 13;
constexpr Rgb8 kLegendBackground{24, 24, 28}, kLegendText{230, 230, 230};

void put(Image8& image, int x, int y, Rgb8 c) {
  const std::size_t at =
      (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)) * 3;
  image.texels[at] = c.r;
  image.texels[at + 1] = c.g;
  image.texels[at + 2] = c.b;
}

Image8 canvas(int width, int height) {
  Image8 image{width, height + kLegendHeight, 3, {}};
  image.texels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height + kLegendHeight) * 3);
  for (int y = height; y < height + kLegendHeight; ++y)
    for (int x = 0; x < width; ++x) put(image, x, y, kLegendBackground);
  return image;
}

// color(i) for i in [0, 256) along the bar; labels at its ends, the title above it.
template <typename Color>
void draw_legend(Image8& image, const std::string& title, const std::string& low, const std::string& high,
                 Color color) {
  const int top = image.height - kLegendHeight;
  const int bar = image.width - 2 * kMargin;
  for (int x = 0; x < bar; ++x)
    for (int y = 0; y < kBarHeight; ++y)
      put(image, kMargin + x, image.height - kMargin - kBarHeight + y + 2,
          color(x * 255 / std::max(1, bar - 1)));
  host::draw_text(image, kMargin, top + 18, low + "   " + title, kTextSize, kLegendText);
  host::draw_text(image, image.width - kMargin - host::text_width(high, kTextSize), top + 18, high, kTextSize,
                  kLegendText);
}

// White at 0; blue towards -1, orange towards +1. t in [-255, 255].
Rgb8 diverging(int t) {
  const auto mix = [&](int end) { return static_cast<std::uint8_t>(255 + (end - 255) * std::abs(t) / 255); };
  return t < 0 ? Rgb8{mix(33), mix(102), mix(172)} : Rgb8{mix(217), mix(95), mix(2)};
}

}  // namespace

Image8 heat_map(int width, int height, std::span<const std::uint32_t> values, std::uint32_t scale_max,
                const std::string& title) {
  Image8 image = canvas(width, height);
  std::uint64_t clipped = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::uint32_t v =
          values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
      clipped += v > scale_max;
      put(image, x, y, v == 0 ? Rgb8{0, 0, 0} : host::viridis(v, scale_max));
    }
  const std::string high =
      clipped ? fmt::format("{}+ ({} px above)", scale_max, clipped) : fmt::format("{}", scale_max);
  draw_legend(image, title, "0", high, [](int i) { return host::viridis(static_cast<std::uint8_t>(i)); });
  return image;
}

Image8 difference_heat_map(int width, int height, std::span<const std::uint32_t> a,
                           std::span<const std::uint32_t> b, const std::string& title) {
  Image8 image = canvas(width, height);
  std::vector<std::int64_t> sizes;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] != b[i]) sizes.push_back(std::abs(std::int64_t{b[i]} - std::int64_t{a[i]}));
  std::int64_t scale = 1;
  if (!sizes.empty()) {
    const auto rank = sizes.begin() + static_cast<std::ptrdiff_t>((sizes.size() * 99 + 99) / 100 - 1);
    std::nth_element(sizes.begin(), rank, sizes.end());
    scale = *rank;
  }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
      const std::int64_t change = std::clamp(std::int64_t{b[i]} - std::int64_t{a[i]}, -scale, scale);
      put(image, x, y, diverging(static_cast<int>(change * 255 / scale)));
    }
  draw_legend(image, title, fmt::format("-{}", scale), fmt::format("+{}", scale),
              [](int i) { return diverging(2 * i - 255); });
  return image;
}

Image8 difference_image(int width, int height, std::span<const std::uint8_t> rgba_a,
                        std::span<const std::uint8_t> rgba_b, int gain) {
  Image8 image{width, height, 3, {}};
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  image.texels.resize(pixels * 3);
  for (std::size_t i = 0; i < pixels; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      image.texels[i * 3 + c] = static_cast<std::uint8_t>(
          std::min(255, gain * std::abs(int{rgba_a[i * 4 + c]} - int{rgba_b[i * 4 + c]})));
  return image;
}

}  // namespace aluminate::report
