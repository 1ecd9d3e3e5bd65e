#include "tests/calibration/synthetic_photo.hpp"

#include <algorithm>
#include <cmath>

#include "platform/host/output_file.hpp"

namespace aluminate::calibration::test {
namespace {

constexpr double kPatchHalf = 0.435, kCardMargin = 0.62;

void blur(std::vector<double>& rgb, int width, int height, double sigma) {
  const int reach = static_cast<int>(std::ceil(3.0 * sigma));
  std::vector<double> weights;
  double total = 0.0;
  for (int i = -reach; i <= reach; ++i) {
    weights.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
    total += weights.back();
  }
  for (const bool vertical : {false, true}) {
    const std::vector<double> from = rgb;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < 3; ++c) {
          double sum = 0.0;
          for (int i = -reach; i <= reach; ++i) {
            const int xx = vertical ? x : std::clamp(x + i, 0, width - 1),
                      yy = vertical ? std::clamp(y + i, 0, height - 1) : y;
            sum += weights[static_cast<std::size_t>(i + reach)] *
                   from[3 * (static_cast<std::size_t>(yy) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(xx)) +
                        static_cast<std::size_t>(c)];
          }
          rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                   static_cast<std::size_t>(x)) +
              static_cast<std::size_t>(c)] = sum / total;
        }
  }
}

std::vector<double> ideal_values(const Scene& scene) {
  const Homography to_chart = Homography(scene.corners).inverse();
  std::vector<double> rgb;
  constexpr int kSub = 3;
  for (int y = 0; y < scene.height; ++y)
    for (int x = 0; x < scene.width; ++x) {
      Colour sum{};
      for (int j = 0; j < kSub; ++j)
        for (int i = 0; i < kSub; ++i) {
          const Colour colour =
              scene_colour(scene, to_chart, {x + (i + 0.5) / kSub - 0.5, y + (j + 0.5) / kSub - 0.5});
          for (std::size_t c = 0; c < 3; ++c) sum[c] += colour[c] / (kSub * kSub);
        }
      rgb.insert(rgb.end(), sum.begin(), sum.end());
    }
  if (scene.blur_px > 0.0) blur(rgb, scene.width, scene.height, scene.blur_px);
  return rgb;
}

}  // namespace

Colour scene_colour(const Scene& scene, const Homography& to_chart, const Point& p) {
  const double wave =
      0.5 + 0.25 * std::sin(0.037 * p.x + 0.011 * p.y) + 0.2 * std::sin(0.023 * p.y - 0.017 * p.x);
  const Colour background{0.25 * wave + 0.05, 0.22 * wave + 0.06, 0.12 + 0.1 * wave};
  if (!scene.has_chart) return background;
  const Point chart = to_chart(p);
  if (chart.x < -kCardMargin || chart.y < -kCardMargin || chart.x > 5.0 + kCardMargin ||
      chart.y > 3.0 + kCardMargin)
    return background;
  const int column = std::clamp(static_cast<int>(std::lround(chart.x)), 0, 5),
            row = std::clamp(static_cast<int>(std::lround(chart.y)), 0, 3);
  Colour colour{0.025, 0.025, 0.027};
  if (std::fabs(chart.x - column) <= kPatchHalf && std::fabs(chart.y - row) <= kPatchHalf) {
    colour = chart_reference(scene.edition).rgb_lin[static_cast<std::size_t>(row * kChartColumns + column)];
  }
  return scene.change ? scene.change(chart, colour) : colour;
}

Photo ideal_photo(const Scene& scene) {
  Photo photo;
  photo.width = scene.width;
  photo.height = scene.height;
  photo.clip_high.fill(1e30);
  for (const double value : ideal_values(scene)) photo.rgb_lin.push_back(static_cast<float>(value));
  return photo;
}

host::ImageFloat photograph(const Scene& scene) {
  host::ImageFloat image;
  image.width = scene.width;
  image.height = scene.height;
  image.channels = {"R", "G", "B"};
  image.stored = scene.camera.code_max == 255 ? host::StoredAs::Unorm8 : host::StoredAs::Unorm16;
  std::mt19937 random(scene.seed);
  const std::vector<double> ideal = ideal_values(scene);
  for (std::size_t i = 0; i < ideal.size(); i += 3)
    for (const double value :
         photograph_encoded(scene.camera, {ideal[i], ideal[i + 1], ideal[i + 2]}, &random))
      image.texels.push_back(static_cast<float>(value));
  return image;
}

void write_photograph(const Scene& scene, const std::string& path) {
  const host::ImageFloat image = photograph(scene);
  if (scene.camera.code_max == 255) {
    host::Image8 codes{image.width, image.height, 3, {}};
    for (const float value : image.texels)
      codes.texels.push_back(static_cast<std::uint8_t>(std::lround(255.0f * value)));
    host::write_png(path, codes);
  } else {
    std::vector<std::uint16_t> codes;
    for (const float value : image.texels)
      codes.push_back(static_cast<std::uint16_t>(std::lround(65535.0f * std::clamp(value, 0.0f, 1.0f))));
    host::write_file(path, host::encode_png16(image.width, image.height, codes, true));
  }
}

}  // namespace aluminate::calibration::test
