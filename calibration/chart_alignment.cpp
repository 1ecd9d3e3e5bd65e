// Fine position and sharpness of a chart whose rough position is known.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/find_chart.hpp"
#include "calibration/patch_grid.hpp"
#include "platform/host/error.hpp"

namespace aluminate::calibration {
namespace {

// The chart and its surroundings, patches at most 48 px apart: larger ones are averaged, which quiets their
// noise and makes the work independent of the photograph's size. A step of the searches below, a hundredth of
// a patch, is then half a pixel.
constexpr double kViewPitch = 48.0;

SmallPicture view_of(const Photo& photo, const Corners& corners) {
  const double pitch = patch_pitch_px(corners), margin = 2.0 * pitch;
  double left = INFINITY, right = -INFINITY, top = INFINITY, bottom = -INFINITY;
  for (const Point& p : corners) {
    left = std::min(left, p.x);
    right = std::max(right, p.x);
    top = std::min(top, p.y);
    bottom = std::max(bottom, p.y);
  }
  const auto px = [](double value, int size) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size)));
  };
  return scaled_part(photo, std::min(1.0, kViewPitch / pitch), px(left - margin, photo.width),
                     px(top - margin, photo.height), px(right + margin, photo.width),
                     px(bottom + margin, photo.height));
}

Corners in_view(const SmallPicture& view, Corners corners) {
  for (Point& p : corners) p = view.from_photo(p);
  return corners;
}

// Bilinear. Lightness and not light, so that dark patches have a say.
Colour lightness_at(const SmallPicture& view, const Point& p) {
  const double px = std::clamp(p.x, 0.0, view.width - 1.0), py = std::clamp(p.y, 0.0, view.height - 1.0);
  const int x0 = static_cast<int>(px), y0 = static_cast<int>(py);
  const int x1 = std::min(x0 + 1, view.width - 1), y1 = std::min(y0 + 1, view.height - 1);
  const double fx = px - x0, fy = py - y0;
  const float *a = view.pixel(x0, y0), *b = view.pixel(x1, y0), *c = view.pixel(x0, y1),
              *d = view.pixel(x1, y1);
  Colour colour{};
  for (std::size_t i = 0; i < 3; ++i)
    colour[i] = (1 - fy) * ((1 - fx) * static_cast<double>(a[i]) + fx * static_cast<double>(b[i])) +
                fy * ((1 - fx) * static_cast<double>(c[i]) + fx * static_cast<double>(d[i]));
  return colour;
}

bool inside(const SmallPicture& view, const Point& p) {
  return p.x >= 0 && p.y >= 0 && p.x <= view.width - 1.0 && p.y <= view.height - 1.0;
}

// The sides of a patch's window in px, fixed while corners move: windows that scaled along would pull the
// chart small, because a smaller window holds less of its blurred edge.
struct Window {
  Point along_column, along_row;
};
using Windows = std::array<Window, kPatchCount>;

Point grid_point(std::size_t patch) {
  return {static_cast<double>(patch % kChartColumns), static_cast<double>(patch / kChartColumns)};
}

Windows windows_of(const Corners& corners) {
  // A little smaller than a patch, which reaches 0.40 (passport size) to 0.45 of the distance between
  // centres.
  constexpr double kHalf = 0.36;
  const Homography to_view(corners);
  Windows windows{};
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    const Point g = grid_point(i);
    windows[i] = {kHalf * (to_view(g + Point{0.5, 0}) - to_view(g - Point{0.5, 0})),
                  kHalf * (to_view(g + Point{0, 0.5}) - to_view(g - Point{0, 0.5}))};
  }
  return windows;
}

// Variance inside of all windows: least when every window lies in its patch.
double disorder(const SmallPicture& view, const Corners& corners, const Windows& windows) {
  constexpr int kSide = 9;
  const Homography to_view(corners);
  double total = 0.0;
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    Colour sum{}, square{};
    const Point centre = to_view(grid_point(i));
    for (int v = 0; v < kSide; ++v)
      for (int u = 0; u < kSide; ++u) {
        const Point p = centre + (2.0 * u / (kSide - 1) - 1.0) * windows[i].along_column +
                        (2.0 * v / (kSide - 1) - 1.0) * windows[i].along_row;
        if (!inside(view, p)) return INFINITY;
        const Colour colour = lightness_at(view, p);
        for (std::size_t c = 0; c < 3; ++c) {
          sum[c] += colour[c];
          square[c] += colour[c] * colour[c];
        }
      }
    constexpr double kCount = kSide * kSide;
    for (std::size_t c = 0; c < 3; ++c) total += square[c] / kCount - (sum[c] / kCount) * (sum[c] / kCount);
  }
  return total;
}

// Where a patch ends along a direction: the distance, in distances between centres, at which the colour is
// half-way to the most different one in the gap. Empty when the surround is as dark as the patch.
std::optional<double> edge_distance(const SmallPicture& view, const Homography& to_view, const Point& start,
                                    const Point& direction) {
  constexpr int kSamples = 40;
  constexpr double kReach = 0.62, kLeastContrast = 0.08;
  const Colour inner = lightness_at(view, to_view(start));
  std::array<double, kSamples + 1> change{};
  std::size_t far = 0;
  for (std::size_t i = 0; i <= kSamples; ++i) {
    const Colour colour =
        lightness_at(view, to_view(start + kReach * static_cast<double>(i) / kSamples * direction));
    for (std::size_t c = 0; c < 3; ++c) change[i] += std::fabs(colour[c] - inner[c]) / 3.0;
    if (change[i] > change[far]) far = i;
  }
  if (change[far] < kLeastContrast) return std::nullopt;
  for (std::size_t i = 1; i <= far; ++i)
    if (change[i] >= 0.5 * change[far]) {
      const double part = (0.5 * change[far] - change[i - 1]) / (change[i] - change[i - 1]);
      const double distance = kReach * (static_cast<double>(i) - 1.0 + part) / kSamples;
      return distance > 0.2 ? std::optional(distance) : std::nullopt;  // nearer: dirt, not the edge
    }
  return std::nullopt;
}

// The centre of a patch between its opposite edges, in chart coordinates relative to where it should be.
std::optional<Point> measured_offset(const SmallPicture& view, const Homography& to_view, std::size_t patch) {
  Point offset;
  for (double Point::*axis : {&Point::x, &Point::y}) {
    std::vector<double> middles;
    for (const double aside : {-0.15, -0.05, 0.05, 0.15}) {
      Point start = grid_point(patch), forward, backward;
      (axis == &Point::x ? start.y : start.x) += aside;
      forward.*axis = 1.0;
      backward.*axis = -1.0;
      const std::optional<double> after = edge_distance(view, to_view, start, forward),
                                  before = edge_distance(view, to_view, start, backward);
      if (after && before) middles.push_back(0.5 * (*after - *before));
    }
    if (middles.size() < 2) return std::nullopt;
    std::sort(middles.begin(), middles.end());
    offset.*axis = 0.5 * (middles[(middles.size() - 1) / 2] + middles[middles.size() / 2]);
  }
  return offset;
}

// Centres every patch between its edges and puts the chart through them; patches that disagree are left out.
Corners centre_between_edges(const SmallPicture& view, const Corners& corners) {
  constexpr std::size_t kMinMeasured = 10;
  const Homography to_view(corners);
  std::vector<Point> from, to;
  for (std::size_t i = 0; i < kPatchCount; ++i)
    if (const std::optional<Point> offset = measured_offset(view, to_view, i)) {
      from.push_back(grid_point(i));
      to.push_back(grid_point(i) + *offset);
    }
  for (int pass = 0; pass < 4 && from.size() >= kMinMeasured; ++pass) {
    const Homography correction(from, to);
    std::vector<double> errors;
    for (std::size_t i = 0; i < from.size(); ++i) errors.push_back(length(correction(from[i]) - to[i]));
    std::vector<double> sorted = errors;
    std::sort(sorted.begin(), sorted.end());
    const double limit = std::max(0.02, 2.5 * sorted[sorted.size() / 2]);
    if (sorted.back() <= limit || pass == 3) {
      Corners result{};
      for (std::size_t k = 0; k < 4; ++k) result[k] = to_view(correction(kChartCorners[k]));
      return result;
    }
    std::vector<Point> kept_from, kept_to;
    for (std::size_t i = 0; i < from.size(); ++i)
      if (errors[i] <= limit) {
        kept_from.push_back(from[i]);
        kept_to.push_back(to[i]);
      }
    from = std::move(kept_from);
    to = std::move(kept_to);
  }
  return corners;
}

}  // namespace

Corners align_to_patches(const Photo& photo, const Corners& photo_corners) {
  const SmallPicture view = view_of(photo, photo_corners);
  const Corners corners = in_view(view, photo_corners);
  // Pattern search over shift, turn, size and the eight corner coordinates, steps from a quarter of a patch
  // down to a hundredth. The variance has one valley as long as the windows are nearer to their own patch
  // than to the next.
  using Move = std::array<Point, 4>;
  const double pitch = patch_pitch_px(corners);
  std::vector<Move> moves;
  for (const Point& d : {Point{1, 0}, Point{0, 1}}) moves.push_back({d, d, d, d});
  const Point centre = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  Move grow{}, turn{};
  const double radius = std::max(length(corners[0] - centre), 1.0);
  for (std::size_t i = 0; i < 4; ++i) {
    const Point arm = (1.0 / radius) * (corners[i] - centre);
    grow[i] = arm;
    turn[i] = {-arm.y, arm.x};
  }
  moves.push_back(grow);
  moves.push_back(turn);
  for (std::size_t i = 0; i < 4; ++i)
    for (const Point& d : {Point{1, 0}, Point{0, 1}}) {
      Move one{};
      one[i] = d;
      moves.push_back(one);
    }
  const Windows windows = windows_of(corners);
  Corners best = corners;
  double least = disorder(view, best, windows);
  for (double step = 0.25 * pitch; step > 0.01 * pitch;) {
    bool moved = false;
    for (const Move& move : moves)
      for (const double sign : {1.0, -1.0}) {
        Corners trial = best;
        for (std::size_t i = 0; i < 4; ++i) trial[i] = trial[i] + sign * step * move[i];
        double value = INFINITY;
        try {
          value = disorder(view, trial, windows);
        } catch (const UserError&) {
          continue;  // collapsed to a line
        }
        if (value < least) {
          least = value;
          best = trial;
          moved = true;
        }
      }
    if (!moved) step *= 0.5;
  }
  Corners aligned = centre_between_edges(view, centre_between_edges(view, best));
  for (Point& p : aligned) p = view.to_photo(p);
  return aligned;
}

double chart_edge_width(const Photo& photo, const Corners& corners) {
  const SmallPicture view = view_of(photo, corners);
  const Homography to_view(in_view(view, corners));
  constexpr int kSamples = 64;  // from one centre to the next
  std::vector<double> widths;
  const auto profile = [&](const Point& from, const Point& to) {
    std::array<double, kSamples + 1> values{};
    for (int i = 0; i <= kSamples; ++i) {
      const double t = static_cast<double>(i) / kSamples;
      const Colour colour = lightness_at(view, to_view((1.0 - t) * from + t * to));
      values[static_cast<std::size_t>(i)] = (colour[0] + colour[1] + colour[2]) / 3.0;
    }
    // From the patch down (or up) to the most different value before the next centre: the gap, or the next
    // patch.
    for (const bool reversed : {false, true}) {
      if (reversed) std::reverse(values.begin(), values.end());
      std::size_t far = 0;
      for (std::size_t i = 0; i <= kSamples * 3 / 4; ++i)
        if (std::fabs(values[i] - values[0]) > std::fabs(values[far] - values[0])) far = i;
      const double contrast = std::fabs(values[far] - values[0]);
      if (contrast < 0.08) continue;  // too little to measure: 8 steps of lightness
      std::size_t begin = far, end = far;
      while (begin > 0 && std::fabs(values[begin] - values[0]) > 0.1 * contrast) --begin;
      for (std::size_t i = begin; i <= far; ++i)
        if (std::fabs(values[i] - values[0]) > 0.9 * contrast) {
          end = i;
          break;
        }
      widths.push_back(static_cast<double>(end - begin) / kSamples);
    }
  };
  for (int row = 0; row < kChartRows; ++row)
    for (int column = 0; column < kChartColumns; ++column) {
      const Point here{static_cast<double>(column), static_cast<double>(row)};
      if (column + 1 < kChartColumns) profile(here, here + Point{1, 0});
      if (row + 1 < kChartRows) profile(here, here + Point{0, 1});
    }
  if (widths.empty()) return 1.0;  // no contrast anywhere
  std::nth_element(widths.begin(), widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2),
                   widths.end());
  return widths[widths.size() / 2];
}

}  // namespace aluminate::calibration
