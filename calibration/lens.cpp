#include "calibration/lens.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"
#include "platform/host/suggest.hpp"

namespace aluminate::calibration {
namespace {

struct NamedKind {
  const char* name;
  LensKind kind;
  std::size_t parameters;
};
constexpr std::array<NamedKind, 6> kKinds{{{"none", LensKind::None, 0},
                                           {"poly3", LensKind::Poly3, 1},
                                           {"poly5", LensKind::Poly5, 2},
                                           {"ptlens", LensKind::PtLens, 3},
                                           {"acm", LensKind::AcmRectilinear, 5},
                                           {"acm-fisheye", LensKind::AcmFisheye, 2}}};

std::vector<double> parse_numbers(std::string_view text, const std::string& whole) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    double value = 0.0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc{} || !std::isfinite(value) || (next != end && *next != ','))
      throw UserError(fmt::format("expected numbers with commas in '{}'", whole));
    numbers.push_back(value);
    at = next == end ? next : next + 1;
  }
  return numbers;
}

// In units of the model.
Point distort_unit(const LensModel& lens, const Point& p) noexcept {
  const auto& k = lens.k;
  const double r2 = dot(p, p);
  switch (lens.kind) {
    case LensKind::None:
      return p;
    case LensKind::Poly3:
      return (1.0 - k[0] + k[0] * r2) * p;
    case LensKind::Poly5:
      return (1.0 + r2 * (k[0] + k[1] * r2)) * p;
    case LensKind::PtLens: {
      const double r = std::sqrt(r2);
      return (1.0 - k[0] - k[1] - k[2] + r * (k[2] + r * (k[1] + r * k[0]))) * p;
    }
    case LensKind::AcmRectilinear: {
      const double radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[2]));
      const double tangential = 2.0 * (k[3] * p.y + k[4] * p.x);
      return {(radial + tangential) * p.x + k[4] * r2, (radial + tangential) * p.y + k[3] * r2};
    }
    case LensKind::AcmFisheye: {
      const double r = std::sqrt(r2);
      if (r < 1e-12) return p;
      const double theta = std::atan(r), t2 = theta * theta;
      return (theta * (1.0 + t2 * (k[0] + t2 * k[1])) / r) * p;
    }
  }
  return p;
}

// Catmull-Rom weights for a position between the second and the third of four samples.
std::array<double, 4> cubic_weights(double t) noexcept {
  return {t * (-0.5 + t * (1.0 - 0.5 * t)), 1.0 + t * t * (-2.5 + 1.5 * t), t * (0.5 + t * (2.0 - 1.5 * t)),
          t * t * (-0.5 + 0.5 * t)};
}

void sample_cubic(const Photo& photo, const Point& p, std::size_t first, std::size_t last,
                  float* to) noexcept {
  const double px = std::clamp(p.x, 0.0, photo.width - 1.0), py = std::clamp(p.y, 0.0, photo.height - 1.0);
  const int x = static_cast<int>(px), y = static_cast<int>(py);
  const std::array<double, 4> wx = cubic_weights(px - x), wy = cubic_weights(py - y);
  double sum[3]{};
  for (int j = 0; j < 4; ++j) {
    const int row = std::clamp(y + j - 1, 0, photo.height - 1);
    for (int i = 0; i < 4; ++i) {
      const float* pixel = photo.pixel(std::clamp(x + i - 1, 0, photo.width - 1), row);
      const double weight = wx[static_cast<std::size_t>(i)] * wy[static_cast<std::size_t>(j)];
      for (std::size_t c = first; c <= last; ++c) sum[c] += weight * static_cast<double>(pixel[c]);
    }
  }
  for (std::size_t c = first; c <= last; ++c) to[c] = static_cast<float>(sum[c]);
}

}  // namespace

bool LensModel::moves_pixels() const { return kind != LensKind::None || has_lateral_colour(); }
bool LensModel::has_lateral_colour() const {
  return std::any_of(channel_scale.begin(), channel_scale.end(), [](const auto& s) {
    return s != std::array<double, 3>{1, 0, 0};
  });
}
bool LensModel::has_vignette() const { return vignette != std::array<double, 3>{}; }

LensModel parse_lens(const std::string& text, int width, int height, double focal_px) {
  const std::size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  const auto found =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const NamedKind& kind) { return name == kind.name; });
  if (found == kKinds.end()) {
    std::vector<std::string> known{"auto"};
    for (const NamedKind& kind : kKinds) known.emplace_back(kind.name);
    throw UserError(fmt::format("unknown lens model '{}'", name), host::did_you_mean(name, known));
  }
  const std::vector<double> numbers = colon == std::string::npos
                                          ? std::vector<double>{}
                                          : parse_numbers(std::string_view(text).substr(colon + 1), text);
  if (numbers.size() > found->parameters || (numbers.empty() && found->parameters > 0)) {
    throw UserError(fmt::format("lens model {} takes up to {} numbers, found {}", name, found->parameters,
                                numbers.size()),
                    "for example ptlens:0.01,-0.03,0.02");
  }
  LensModel lens;
  lens.kind = found->kind;
  std::copy(numbers.begin(), numbers.end(), lens.k.begin());
  lens.centre = {0.5 * (width - 1), 0.5 * (height - 1)};
  const bool is_acm = lens.kind == LensKind::AcmRectilinear || lens.kind == LensKind::AcmFisheye;
  if (is_acm && !(focal_px > 0.0))
    throw UserError("Adobe's lens model needs the focal length in px", "give it with --focal-px");
  lens.unit_px = is_acm ? focal_px : 0.5 * std::min(width, height);
  lens.vignette_unit_px = is_acm ? focal_px : 0.5 * std::hypot(width, height);
  return lens;
}

Point distort(const LensModel& lens, const Point& ideal) noexcept {
  return lens.centre + lens.unit_px * distort_unit(lens, (1.0 / lens.unit_px) * (ideal - lens.centre));
}

Point distort(const LensModel& lens, const Point& ideal, std::size_t channel) noexcept {
  const Point unit = distort_unit(lens, (1.0 / lens.unit_px) * (ideal - lens.centre));
  const auto& s = lens.channel_scale[channel];
  const double r = std::sqrt(dot(unit, unit));
  return lens.centre + lens.unit_px * (s[0] + r * (s[1] + r * s[2])) * unit;
}

Point undistort(const LensModel& lens, const Point& seen) {
  const Point target = (1.0 / lens.unit_px) * (seen - lens.centre);
  Point p = target;
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 50; ++i) {
    const Point error = distort_unit(lens, p) - target;
    if (length(error) < 1e-10) return lens.centre + lens.unit_px * p;
    const Point dx =
        (0.5 / kStep) * (distort_unit(lens, p + Point{kStep, 0}) - distort_unit(lens, p - Point{kStep, 0}));
    const Point dy =
        (0.5 / kStep) * (distort_unit(lens, p + Point{0, kStep}) - distort_unit(lens, p - Point{0, kStep}));
    const double determinant = cross(dx, dy);
    if (!(determinant > 1e-6)) break;  // the model folds over here
    p = p - (1.0 / determinant) * Point{cross(error, dy), cross(dx, error)};
  }
  throw UserError(fmt::format("the lens model cannot be inverted at {:.0f},{:.0f}", seen.x, seen.y),
                  "its coefficients do not fit a picture of this size");
}

double vignette_at(const LensModel& lens, const Point& seen) noexcept {
  const Point p = (1.0 / lens.vignette_unit_px) * (seen - lens.centre);
  const double r2 = dot(p, p);
  return 1.0 + r2 * (lens.vignette[0] + r2 * (lens.vignette[1] + r2 * lens.vignette[2]));
}

void correct_lens(Photo& photo, const LensModel& lens) {
  const std::size_t row_values = 3 * static_cast<std::size_t>(photo.width);
  if (lens.has_vignette()) {
    const double corner =
        std::min(vignette_at(lens, {0, 0}), vignette_at(lens, {photo.width - 1.0, photo.height - 1.0}));
    if (!(corner > 0.05))
      throw UserError(fmt::format("the vignetting model leaves {:.3f} of the light in the corner", corner),
                      "expected 0.05 or more");
    host::parallel_for(
        photo.height,
        [&](std::int64_t y) {
          float* row = photo.rgb_lin.data() + static_cast<std::size_t>(y) * row_values;
          for (int x = 0; x < photo.width; ++x) {
            const float gain =
                static_cast<float>(1.0 / vignette_at(lens, {static_cast<double>(x), static_cast<double>(y)}));
            for (int c = 0; c < 3; ++c) *row++ *= gain;
          }
        },
        16);
  }
  if (!lens.moves_pixels()) return;
  host::UninitializedVector<float> straight(photo.rgb_lin.size());
  const bool by_channel = lens.has_lateral_colour();
  host::parallel_for(
      photo.height,
      [&](std::int64_t y) {
        float* to = straight.data() + static_cast<std::size_t>(y) * row_values;
        for (int x = 0; x < photo.width; ++x, to += 3) {
          const Point ideal{static_cast<double>(x), static_cast<double>(y)};
          if (!by_channel) {
            sample_cubic(photo, distort(lens, ideal), 0, 2, to);
          } else {
            for (std::size_t c = 0; c < 3; ++c) sample_cubic(photo, distort(lens, ideal, c), c, c, to);
          }
        }
      },
      8);
  photo.rgb_lin = std::move(straight);
}

}  // namespace aluminate::calibration
