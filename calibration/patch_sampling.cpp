#include "calibration/patch_sampling.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calibration/linear_solve.hpp"
#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::calibration {
namespace {

double median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Pixels {
  std::array<std::vector<float>, 3> rgb;
  std::vector<Point> place;  // in the patch, [-kSampledHalfWidth, kSampledHalfWidth]
};

Pixels gather(const Photo& photo, const Homography& to_photo, const Homography& to_chart,
              const Point& chart_centre, int most_pixels) {
  double left = INFINITY, right = -INFINITY, top = INFINITY, bottom = -INFINITY;
  for (const double dx : {-kSampledHalfWidth, kSampledHalfWidth})
    for (const double dy : {-kSampledHalfWidth, kSampledHalfWidth}) {
      const Point p = to_photo(chart_centre + Point{dx, dy});
      left = std::min(left, p.x);
      right = std::max(right, p.x);
      top = std::min(top, p.y);
      bottom = std::max(bottom, p.y);
    }
  const int x0 = std::max(0, static_cast<int>(std::ceil(left))),
            x1 = std::min(photo.width - 1, static_cast<int>(std::floor(right)));
  const int y0 = std::max(0, static_cast<int>(std::ceil(top))),
            y1 = std::min(photo.height - 1, static_cast<int>(std::floor(bottom)));
  Pixels pixels;
  const auto take = [&](int x, int y, const Point& offset) {
    const float* rgb = photo.pixel(x, y);
    for (std::size_t c = 0; c < 3; ++c) pixels.rgb[c].push_back(rgb[c]);
    pixels.place.push_back(offset);
  };
  const double area = std::max(0.0, (x1 - x0 + 1.0) * (y1 - y0 + 1.0));
  const int step = std::max(1, static_cast<int>(std::sqrt(area / most_pixels)));
  for (int y = y0; y <= y1; y += step)
    for (int x = x0; x <= x1; x += step) {
      const Point offset = to_chart({static_cast<double>(x), static_cast<double>(y)}) - chart_centre;
      if (std::fabs(offset.x) <= kSampledHalfWidth && std::fabs(offset.y) <= kSampledHalfWidth)
        take(x, y, offset);
    }
  if (pixels.place.empty()) {  // patches of a few pixels: the one at the centre
    const Point p = to_photo(chart_centre);
    const int x = static_cast<int>(std::lround(p.x)), y = static_cast<int>(std::lround(p.y));
    if (x >= 0 && y >= 0 && x < photo.width && y < photo.height) take(x, y, {});
  }
  return pixels;
}

// Mean luminance of one half of the patch against the other, along one axis.
double half_difference(const Pixels& pixels, const std::vector<bool>& kept, double Point::*axis) {
  double sums[2]{}, counts[2]{};
  for (std::size_t i = 0; i < pixels.place.size(); ++i) {
    if (!kept[i] || pixels.place[i].*axis == 0.0) continue;
    const std::size_t half = pixels.place[i].*axis > 0.0 ? 1 : 0;
    sums[half] += 0.2126 * static_cast<double>(pixels.rgb[0][i]) +
                  0.7152 * static_cast<double>(pixels.rgb[1][i]) +
                  0.0722 * static_cast<double>(pixels.rgb[2][i]);
    counts[half] += 1.0;
  }
  if (counts[0] == 0.0 || counts[1] == 0.0) return 0.0;
  const double a = sums[0] / counts[0], b = sums[1] / counts[1], mean = 0.5 * (a + b);
  // Black is uneven by its noise: below 1 % of white the difference is compared with that instead.
  return std::fabs(a - b) / std::max(mean, 0.01);
}

PatchSample statistics(const Photo& photo, const Pixels& pixels, const Point& centre) {
  PatchSample sample;
  sample.centre = centre;
  const std::size_t count = pixels.place.size();
  sample.pixels = static_cast<int>(count);
  if (count == 0) return sample;

  Colour middle{}, limit{};
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<float> values = pixels.rgb[c];
    middle[c] = median(values);
    for (float& value : values) value = std::fabs(value - static_cast<float>(middle[c]));
    // 1.4826: the median absolute deviation of a normal distribution to its standard deviation. At least one
    // 8-bit step near black (1/255/12.92), so that a patch of two codes keeps both.
    limit[c] = 3.0 * std::max(1.4826 * median(values), 0.0005 + 0.004 * std::fabs(middle[c]));
  }
  std::vector<bool> kept(count);
  std::size_t kept_count = 0, high = 0, low = 0;
  Colour sum{}, square{};
  for (std::size_t i = 0; i < count; ++i) {
    bool inside = true, at_high = false, at_low = false;
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = static_cast<double>(pixels.rgb[c][i]);
      inside = inside && std::fabs(value - middle[c]) <= limit[c];
      at_high = at_high || value >= photo.clip_high[c];
      at_low = at_low || value <= photo.clip_low;
    }
    high += at_high ? 1 : 0;
    low += at_low ? 1 : 0;
    kept[i] = inside;
    if (!inside) continue;
    ++kept_count;
    for (std::size_t c = 0; c < 3; ++c) {
      const double offset = static_cast<double>(pixels.rgb[c][i]) - middle[c];
      sum[c] += offset;
      square[c] += offset * offset;
    }
  }
  const double n = static_cast<double>(std::max<std::size_t>(kept_count, 1));
  for (std::size_t c = 0; c < 3; ++c) {
    sample.mean[c] = middle[c] + sum[c] / n;
    sample.deviation[c] = std::sqrt(std::max(0.0, square[c] / n - (sum[c] / n) * (sum[c] / n)));
  }
  sample.outliers = static_cast<int>(count - kept_count);
  sample.clipped_high = static_cast<double>(high) / static_cast<double>(count);
  sample.clipped_low = static_cast<double>(low) / static_cast<double>(count);
  const std::vector<bool> all(count, true);  // an uneven patch shows in what the mean leaves out
  sample.unevenness =
      std::max(half_difference(pixels, all, &Point::x), half_difference(pixels, all, &Point::y));
  return sample;
}

}  // namespace

PatchSamples sample_patches(const Photo& photo, const Corners& corners, int most_pixels) {
  const Homography to_photo(corners), to_chart = to_photo.inverse();
  PatchSamples samples;
  host::parallel_for(kPatchCount, [&](std::int64_t patch) {
    const std::size_t i = static_cast<std::size_t>(patch);
    const Point chart_centre{static_cast<double>(i % kChartColumns), static_cast<double>(i / kChartColumns)};
    samples[i] = statistics(photo, gather(photo, to_photo, to_chart, chart_centre, most_pixels),
                            to_photo(chart_centre));
  });
  return samples;
}

PatchColours colours_of(const PatchSamples& samples) {
  PatchColours colours;
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    colours.rgb_lin[i] = samples[i].mean;
    colours.usable[i] = samples[i].usable();
  }
  return colours;
}

double chart_agreement(const PatchColours& colours, const ChartReference& reference) {
  Table rows(kPatchCount, 4), target(kPatchCount, 3);
  std::vector<double> weights(kPatchCount);
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    weights[i] = colours.usable[i] ? 1.0 : 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      rows.at(i, c) = std::cbrt(colours.rgb_lin[i][c]);
      target.at(i, c) = std::cbrt(reference.rgb_lin[i][c]);
    }
    rows.at(i, 3) = 1.0;
  }
  if (colours.usable_count() < 6) return 0.0;
  Table fit;
  try {
    fit = least_squares(rows, target, weights, "chart");
  } catch (const UserError&) {
    return 0.0;  // one colour everywhere is no chart
  }
  double residual = 0.0, variance = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    double mean = 0.0, weight = 0.0;
    for (std::size_t i = 0; i < kPatchCount; ++i) {
      mean += weights[i] * target.at(i, c);
      weight += weights[i];
    }
    mean /= weight;
    for (std::size_t i = 0; i < kPatchCount; ++i) {
      double value = 0.0;
      for (std::size_t j = 0; j < 4; ++j) value += rows.at(i, j) * fit.at(j, c);
      residual += weights[i] * (value - target.at(i, c)) * (value - target.at(i, c));
      variance += weights[i] * (target.at(i, c) - mean) * (target.at(i, c) - mean);
    }
  }
  return 1.0 - residual / variance;
}

}  // namespace aluminate::calibration
