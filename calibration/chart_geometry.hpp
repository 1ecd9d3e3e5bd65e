// Where the chart lies in a photograph. Chart coordinates: patch i has its centre at (i % 6, i / 6), one unit
// is the distance of neighbouring centres; photograph coordinates: px, the centre of the top left pixel is
// (0, 0), y down. A homography takes one to the other. Never looks at colours.
#pragma once

#include <array>
#include <span>
#include <string>

#include "calibration/chart.hpp"

namespace aluminate::calibration {

struct Point {
  double x = 0.0, y = 0.0;
  bool operator==(const Point&) const = default;
};

inline Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y}; }
inline Point operator+(const Point& a, const Point& b) { return {a.x + b.x, a.y + b.y}; }
inline Point operator*(double s, const Point& p) { return {s * p.x, s * p.y}; }
inline double cross(const Point& a, const Point& b) { return a.x * b.y - a.y * b.x; }
inline double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y; }
double length(const Point& p);

/// Centres of dark skin, bluish green, black, white: the order of --corners, clockwise on an upright chart.
using Corners = std::array<Point, 4>;
inline constexpr Corners kChartCorners{{{0, 0}, {5, 0}, {5, 3}, {0, 3}}};

class Homography {
 public:
  Homography() = default;
  /// Least squares through pairs of points, at least four. Throws UserError when they do not determine it.
  Homography(std::span<const Point> from, std::span<const Point> to);
  explicit Homography(const Corners& corners) : Homography(kChartCorners, corners) {}

  Point operator()(const Point& p) const noexcept;
  Homography inverse() const;

 private:
  Matrix3 m_{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
};

/// "x,y;x,y;x,y;x,y". Throws UserError.
Corners parse_corners(const std::string& text);

/// Throws UserError when the four points are no convex quadrilateral that a chart could show, or leave the
/// picture.
void check_corners(const Corners& corners, int width, int height);

std::array<Point, kPatchCount> patch_centres(const Corners& corners);

/// Distance of neighbouring patch centres in px, the smallest over the chart.
double patch_pitch_px(const Corners& corners);
/// Longest side of the quadrilateral of corner centres plus one pitch, px: the width of the whole chart.
double chart_width_px(const Corners& corners);

}  // namespace aluminate::calibration
