#include "calibration/opencv_chart.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "calibration/opencv_module.hpp"
#include "calibration/patch_grid.hpp"
#include "platform/host/error.hpp"
#include "platform/host/log.hpp"
#include "platform/host/module_file.hpp"

namespace aluminate::calibration {
namespace {

opencv_module::FindCharts open_finder() {
  static const auto finder = reinterpret_cast<opencv_module::FindCharts>(host::open_module(
      opencv_module::kFile, ALUMINATE_MODULE_DIR, opencv_module::kSymbol, "finds charts with OpenCV"));
  return finder;
}

}  // namespace

std::vector<Corners> opencv_charts(const Photo& photo) {
  opencv_module::FindCharts find = nullptr;
  try {
    find = open_finder();
  } catch (const UserError& error) {
    host::warning(error.what());
    return {};
  }
  // mcc's thresholds are px: it works best, and in reasonable time, on pictures of about this size.
  constexpr double kLongestPx = 1400.0;
  const double scale = std::min(4.0, kLongestPx / std::max(photo.width, photo.height));
  const SmallPicture picture = scaled_picture(photo, scale);
  const std::size_t texels =
      static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  std::vector<std::uint8_t> bgr(texels * 3);
  float brightest = 1e-6f;  // an unscaled float or raw photograph may be dark
  for (const float value : picture.rgb) brightest = std::max(brightest, value);
  for (std::size_t i = 0; i < texels; ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double linear = std::pow(static_cast<double>(picture.rgb[3 * i + 2 - c] / brightest), 3.0);
      bgr[3 * i + c] =
          static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(linear_to_srgb(linear), 0.0, 1.0)));
    }
  constexpr int kMost = 3;
  std::array<float, kMost * 8> numbers{};
  const int count = find(bgr.data(), picture.width, picture.height, kMost, numbers.data());
  std::vector<Corners> charts;
  for (int i = 0; i < count; ++i) {
    Corners corners{};
    for (std::size_t k = 0; k < 4; ++k) {
      const float* at = numbers.data() + 8 * static_cast<std::size_t>(i) + 2 * k;
      corners[k] = picture.to_photo({static_cast<double>(at[0]), static_cast<double>(at[1])});
    }
    charts.push_back(corners);
  }
  return charts;
}

}  // namespace aluminate::calibration
