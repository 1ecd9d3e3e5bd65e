#include "calibration/chart_geometry.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "calibration/linear_solve.hpp"
#include "platform/host/error.hpp"

namespace aluminate::calibration {
namespace {

Point centre_of(std::span<const Point> points) {
  Point sum;
  for (const Point& p : points) sum = sum + p;
  return (1.0 / static_cast<double>(points.size())) * sum;
}

// Moves points to their centre and to unit size: pixel coordinates squared would swamp the system.
struct Normalise {
  explicit Normalise(std::span<const Point> points) : centre(centre_of(points)) {
    double sum = 0.0;
    for (const Point& p : points) sum += length(p - centre);
    scale = sum > 0.0 ? static_cast<double>(points.size()) / sum : 1.0;
  }
  Point operator()(const Point& p) const { return scale * (p - centre); }
  Matrix3 matrix() const {
    return {{{scale, 0, -scale * centre.x}, {0, scale, -scale * centre.y}, {0, 0, 1}}};
  }
  Point centre;
  double scale = 1.0;
};

}  // namespace

double length(const Point& p) { return std::hypot(p.x, p.y); }

Homography::Homography(std::span<const Point> from, std::span<const Point> to) {
  ALU_CHECK(from.size() == to.size() && from.size() >= 4, "{} and {} points", from.size(), to.size());
  const Normalise source(from), target(to);
  Table rows(2 * from.size(), 8), right(2 * from.size(), 1);
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Point s = source(from[i]), t = target(to[i]);
    const std::array<double, 8> for_x{s.x, s.y, 1, 0, 0, 0, -s.x * t.x, -s.y * t.x};
    const std::array<double, 8> for_y{0, 0, 0, s.x, s.y, 1, -s.x * t.y, -s.y * t.y};
    for (std::size_t j = 0; j < 8; ++j) {
      rows.at(2 * i, j) = for_x[j];
      rows.at(2 * i + 1, j) = for_y[j];
    }
    right.at(2 * i, 0) = t.x;
    right.at(2 * i + 1, 0) = t.y;
  }
  const Table h = least_squares(rows, right, {}, "chart position");
  const Matrix3 normalised{{{h.values[0], h.values[1], h.values[2]},
                            {h.values[3], h.values[4], h.values[5]},
                            {h.values[6], h.values[7], 1.0}}};
  m_ = multiply(calibration::inverse(target.matrix()), multiply(normalised, source.matrix()));
}

Point Homography::operator()(const Point& p) const noexcept {
  const Colour h = multiply(m_, Colour{p.x, p.y, 1.0});
  return {h[0] / h[2], h[1] / h[2]};
}

Homography Homography::inverse() const {
  Homography result;
  result.m_ = calibration::inverse(m_);
  return result;
}

Corners parse_corners(const std::string& text) {
  Corners corners{};
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto fail = [&] {
    throw UserError(fmt::format("expected corners as x,y;x,y;x,y;x,y, found '{}'", text),
                    "pixel centres of the patches dark skin, bluish green, black, white, in this order");
  };
  const auto skip_blanks = [&] {
    while (at != end && *at == ' ') ++at;
  };
  const auto number = [&](char separator) {
    skip_blanks();
    double value = 0.0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc{} || !std::isfinite(value)) fail();
    at = next;
    skip_blanks();
    if (separator != '\0') {
      if (at == end || *at != separator) fail();
      ++at;
    }
    return value;
  };
  for (std::size_t i = 0; i < 4; ++i) {
    corners[i].x = number(',');
    corners[i].y = number(i < 3 ? ';' : '\0');
  }
  if (at != end) fail();
  return corners;
}

void check_corners(const Corners& corners, int width, int height) {
  const char* const hint = "the order is dark skin, bluish green, black, white: around the chart, not across";
  for (const Point& p : corners) {
    if (!(p.x >= 0.0 && p.y >= 0.0 && p.x <= width - 1.0 && p.y <= height - 1.0)) {
      throw UserError(
          fmt::format("the corner {:g},{:g} lies outside of the {} x {} picture: the chart is cut off", p.x,
                      p.y, width, height),
          hint);
    }
  }
  int positive = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Point a = corners[(i + 1) % 4] - corners[i], b = corners[(i + 2) % 4] - corners[(i + 1) % 4];
    const double turn = cross(a, b);
    if (!(std::fabs(turn) > 1e-3 * length(a) * length(b)))
      throw UserError("three of the four corners lie on one line", hint);
    positive += turn > 0.0 ? 1 : 0;
  }
  if (positive == 0) throw UserError("the corners run counter-clockwise: a mirrored chart", hint);
  if (positive != 4) throw UserError("the four corners are no convex quadrilateral", hint);
  const double pitch = patch_pitch_px(corners);
  if (pitch < 4.0) {
    throw UserError(
        fmt::format("the chart is too small: its patches are {:.1f} px apart, at least 4 are needed", pitch),
        "photograph the chart closer or with more resolution");
  }
}

std::array<Point, kPatchCount> patch_centres(const Corners& corners) {
  const Homography to_photo(corners);
  std::array<Point, kPatchCount> centres{};
  for (std::size_t i = 0; i < kPatchCount; ++i)
    centres[i] = to_photo({static_cast<double>(i % kChartColumns), static_cast<double>(i / kChartColumns)});
  return centres;
}

double patch_pitch_px(const Corners& corners) {
  const std::array<Point, kPatchCount> centres = patch_centres(corners);
  double smallest = INFINITY;
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    if (i % kChartColumns + 1 < kChartColumns)
      smallest = std::min(smallest, length(centres[i + 1] - centres[i]));
    if (i + kChartColumns < kPatchCount)
      smallest = std::min(smallest, length(centres[i + kChartColumns] - centres[i]));
  }
  return smallest;
}

double chart_width_px(const Corners& corners) {
  double longest = 0.0;
  for (std::size_t i = 0; i < 4; ++i) longest = std::max(longest, length(corners[(i + 1) % 4] - corners[i]));
  return longest * 6.0 / 5.0;
}

}  // namespace aluminate::calibration
