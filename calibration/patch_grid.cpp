#include "calibration/patch_grid.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <queue>
#include <utility>

#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::calibration {
namespace {

// One connected area without edges, described by its moments.
struct Area {
  Point centre;
  double size = 0.0;  // px
  double side = 0.0;  // of the square of the same area
};

float lightness(float linear) { return std::cbrt(std::max(linear, 0.0f)); }

std::vector<Area> square_areas(const std::vector<float>& steepness, float edge, int w, int h) {
  std::vector<std::uint8_t> flat(steepness.size());
  for (std::size_t i = 0; i < flat.size(); ++i) flat[i] = steepness[i] < edge ? 1 : 0;
  constexpr double kMinPixels = 6.0;
  const double most_pixels =
      static_cast<double>(w) * h / 20.0;  // 24 patches fill at most most of the picture
  std::vector<Area> areas;
  std::vector<std::pair<int, int>> stack;
  for (int y0 = 1; y0 + 1 < h; ++y0)
    for (int x0 = 1; x0 + 1 < w; ++x0) {
      const auto index = [&](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x);
      };
      if (flat[index(x0, y0)] == 0) continue;
      double n = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
      stack.assign(1, {x0, y0});
      flat[index(x0, y0)] = 0;
      while (!stack.empty()) {
        const auto [x, y] = stack.back();
        stack.pop_back();
        const double dx = x - x0, dy = y - y0;
        n += 1;
        sx += dx;
        sy += dy;
        sxx += dx * dx;
        syy += dy * dy;
        sxy += dx * dy;
        for (const auto& [nx, ny] :
             {std::pair{x + 1, y}, {x - 1, y}, {x, y + 1}, {x, y - 1}})  // the border is never flat
          if (flat[index(nx, ny)] != 0) {
            flat[index(nx, ny)] = 0;
            stack.emplace_back(nx, ny);
          }
      }
      if (n < kMinPixels || n > most_pixels) continue;
      const double mx = sx / n, my = sy / n;
      // 1/12: the variance of a pixel itself.
      const double vxx = sxx / n - mx * mx + 1.0 / 12.0, vyy = syy / n - my * my + 1.0 / 12.0,
                   vxy = sxy / n - mx * my;
      const double determinant = vxx * vyy - vxy * vxy, half_trace = 0.5 * (vxx + vyy);
      // A filled rectangle has area 12 sqrt(det); holes, arms and bends have less.
      const double fill = n / (12.0 * std::sqrt(std::max(determinant, 1e-12)));
      const double spread = std::sqrt(std::max(half_trace * half_trace - determinant, 0.0));
      const double slimness =
          (half_trace - spread) / (half_trace + spread);  // short side squared over long side squared
      if (fill < 0.80 || fill > 1.15 || slimness < 0.3) continue;
      areas.push_back({{x0 + mx, y0 + my}, n, std::sqrt(n)});
    }
  return areas;
}

// Areas by place, for "what lies near p": indices sorted by square cell, and where each cell begins.
class Neighbourhood {
 public:
  Neighbourhood(const std::vector<Area>& areas, double cell, int width, int height)
      : areas_(areas), cell_(cell), columns_(cell_of(width) + 1), rows_(cell_of(height) + 1) {
    begin_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
    for (const Area& area : areas) ++begin_[key(area) + 1];
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    sorted_.resize(areas.size());
    std::vector<std::size_t> next = begin_;
    for (std::size_t i = 0; i < areas.size(); ++i) sorted_[next[key(areas[i])]++] = i;
  }
  template <class Visit>
  void near(const Point& p, double radius, Visit&& visit) const {
    const int left = std::max(cell_of(p.x - radius), 0),
              right = std::min(cell_of(p.x + radius), columns_ - 1);
    const int top = std::max(cell_of(p.y - radius), 0), bottom = std::min(cell_of(p.y + radius), rows_ - 1);
    for (int y = top; y <= bottom; ++y)
      for (int x = left; x <= right; ++x)
        for (std::size_t at = begin_[key(x, y)]; at < begin_[key(x, y) + 1]; ++at)
          if (length(areas_[sorted_[at]].centre - p) <= radius) visit(sorted_[at]);
  }

 private:
  int cell_of(double px) const { return static_cast<int>(std::floor(px / cell_)); }
  std::size_t key(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
  }
  std::size_t key(const Area& area) const { return key(cell_of(area.centre.x), cell_of(area.centre.y)); }
  const std::vector<Area>& areas_;
  double cell_;
  int columns_, rows_;
  std::vector<std::size_t> begin_, sorted_;
};

struct Step {
  Point along_column, along_row;
};

// Grows a lattice from one area with two first steps: each node passes on the steps that led to it, so that
// perspective may change them slowly.
PatchGrid grow(const std::vector<Area>& areas, const Neighbourhood& near, std::size_t seed,
               const Step& first) {
  struct Node {
    std::size_t area;
    Step step;
  };
  std::map<std::pair<int, int>, Node> nodes{{{0, 0}, {seed, first}}};
  std::vector<std::size_t> taken{
      seed};  // a lattice is small: searching it beats a flag for each of 10^5 areas
  std::queue<std::pair<int, int>> open;
  open.push({0, 0});
  while (!open.empty()) {
    const auto [column, row] = open.front();
    open.pop();
    const Node node = nodes.at({column, row});
    const Point from = areas[node.area].centre;
    for (const auto& [dc, dr] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      if (nodes.contains({column + dc, row + dr}) || std::abs(column + dc) > 12 || std::abs(row + dr) > 12)
        continue;
      const Point step = dc != 0 ? static_cast<double>(dc) * node.step.along_column
                                 : static_cast<double>(dr) * node.step.along_row;
      const Point expected = from + step;
      double nearest = 0.22 * length(step);
      std::size_t found = areas.size();
      near.near(expected, nearest, [&](std::size_t i) {
        const double ratio = areas[i].size / areas[node.area].size;
        const double distance = length(areas[i].centre - expected);
        if (ratio > 0.4 && ratio < 2.5 && distance < nearest &&
            std::find(taken.begin(), taken.end(), i) == taken.end()) {
          nearest = distance;
          found = i;
        }
      });
      if (found == areas.size()) continue;
      Step next = node.step;
      const Point actual = areas[found].centre - from;
      (dc != 0 ? next.along_column : next.along_row) = static_cast<double>(dc + dr) * actual;
      taken.push_back(found);
      nodes.insert({{column + dc, row + dr}, {found, next}});
      open.push({column + dc, row + dr});
    }
  }
  PatchGrid grid;
  for (const auto& [place, node] : nodes)
    grid.nodes.push_back({areas[node.area].centre, place.first, place.second});
  return grid;
}

}  // namespace

SmallPicture scaled_part(const Photo& photo, double scale, int x0, int y0, int x1, int y1) {
  ALU_CHECK(scale > 0.0 && scale <= 1.0, "scale {}", scale);
  x0 = std::max(x0, 0);
  y0 = std::max(y0, 0);
  x1 = std::min(x1, photo.width);
  y1 = std::min(y1, photo.height);
  if (x1 <= x0 || y1 <= y0) throw UserError("a part of the photograph lies outside of it");
  SmallPicture picture;
  picture.scale = scale;
  picture.origin = {static_cast<double>(x0), static_cast<double>(y0)};
  picture.width = std::max(1, static_cast<int>(std::floor((x1 - x0) * scale)));
  picture.height = std::max(1, static_cast<int>(std::floor((y1 - y0) * scale)));
  picture.rgb.resize(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) * 3);
  const auto first_px = [&](int at) { return static_cast<int>(at / scale); };
  host::parallel_for(
      picture.height,
      [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        const int top = y0 + first_px(y), bottom = std::clamp(y0 + first_px(y + 1), top + 1, y1);
        float* to =
            picture.rgb.data() + 3 * static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width);
        for (int x = 0; x < picture.width; ++x, to += 3) {
          const int left = x0 + first_px(x), right = std::clamp(x0 + first_px(x + 1), left + 1, x1);
          double r = 0.0, g = 0.0, b = 0.0;
          for (int yy = top; yy < bottom; ++yy) {
            const float* from = photo.pixel(left, yy);
            for (int xx = left; xx < right; ++xx, from += 3) {
              r += static_cast<double>(from[0]);
              g += static_cast<double>(from[1]);
              b += static_cast<double>(from[2]);
            }
          }
          const double share = 1.0 / (static_cast<double>(right - left) * static_cast<double>(bottom - top));
          to[0] = lightness(static_cast<float>(r * share));
          to[1] = lightness(static_cast<float>(g * share));
          to[2] = lightness(static_cast<float>(b * share));
        }
      },
      4);
  return picture;
}

SmallPicture scaled_picture(const Photo& photo, double scale) {
  if (scale <= 1.0) return scaled_part(photo, scale, 0, 0, photo.width, photo.height);
  SmallPicture picture;
  picture.scale = scale;
  picture.width = static_cast<int>(std::floor(photo.width * scale));
  picture.height = static_cast<int>(std::floor(photo.height * scale));
  picture.rgb.resize(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) * 3);
  host::parallel_for(
      picture.height,
      [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        float* to =
            picture.rgb.data() + 3 * static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width);
        for (int x = 0; x < picture.width; ++x, to += 3) {
          const Point p = picture.to_photo({static_cast<double>(x), static_cast<double>(y)});
          const double px = std::clamp(p.x, 0.0, photo.width - 1.0),
                       py = std::clamp(p.y, 0.0, photo.height - 1.0);
          const int x0 = static_cast<int>(px), y0 = static_cast<int>(py);
          const int x1 = std::min(x0 + 1, photo.width - 1), y1 = std::min(y0 + 1, photo.height - 1);
          const double fx = px - x0, fy = py - y0;
          for (int c = 0; c < 3; ++c) {
            const double linear = (1 - fy) * ((1 - fx) * static_cast<double>(photo.pixel(x0, y0)[c]) +
                                              fx * static_cast<double>(photo.pixel(x1, y0)[c])) +
                                  fy * ((1 - fx) * static_cast<double>(photo.pixel(x0, y1)[c]) +
                                        fx * static_cast<double>(photo.pixel(x1, y1)[c]));
            to[c] = lightness(static_cast<float>(linear));
          }
        }
      },
      4);
  return picture;
}

std::vector<float> steepness_of(const SmallPicture& picture) {
  const int w = picture.width, h = picture.height;
  const std::size_t row = 3 * static_cast<std::size_t>(w);
  // Sensor noise and JPEG blocks must not cut a patch into pieces: a box of 3 x 3, along rows, then along
  // columns.
  std::vector<float> along(picture.rgb.size()), smooth(picture.rgb.size());
  host::parallel_for(
      h,
      [&](std::int64_t y) {
        const float* from = picture.rgb.data() + static_cast<std::size_t>(y) * row;
        float* to = along.data() + static_cast<std::size_t>(y) * row;
        for (std::size_t i = 0; i < row; ++i) {
          const std::size_t left = i >= 3 ? i - 3 : i, right = i + 3 < row ? i + 3 : i;
          to[i] = from[left] + from[i] + from[right];
        }
      },
      16);
  const auto row_of = [&](const std::vector<float>& values, int y) {
    return values.data() + static_cast<std::size_t>(std::clamp(y, 0, h - 1)) * row;
  };
  host::parallel_for(
      h,
      [&](std::int64_t line) {
        const int y = static_cast<int>(line);
        const float *up = row_of(along, y - 1), *here = row_of(along, y), *down = row_of(along, y + 1);
        float* to = smooth.data() + static_cast<std::size_t>(y) * row;
        for (std::size_t i = 0; i < row; ++i) to[i] = (up[i] + here[i] + down[i]) / 9.0f;
      },
      16);
  std::vector<float> steepness(static_cast<std::size_t>(w) * static_cast<std::size_t>(h),
                               std::numeric_limits<float>::infinity());
  host::parallel_for(
      std::max(h - 2, 0),
      [&](std::int64_t line) {
        const int y = static_cast<int>(line) + 1;
        const float *up = row_of(smooth, y - 1), *here = row_of(smooth, y), *down = row_of(smooth, y + 1);
        float* to = steepness.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(w);
        for (std::size_t x = 1; x + 1 < static_cast<std::size_t>(w); ++x) {
          float largest = 0.0f;
          for (std::size_t i = 3 * x; i < 3 * x + 3; ++i) {
            largest = std::max(largest, std::fabs(here[i + 3] - here[i - 3]));
            largest = std::max(largest, std::fabs(down[i] - up[i]));
          }
          to[x] = largest;
        }
      },
      16);
  return steepness;
}

std::vector<PatchGrid> find_grids(const SmallPicture& picture, const std::vector<float>& steepness,
                                  float edge, std::size_t min_nodes) {
  std::vector<PatchGrid> grids;
  if (picture.width < 3 || picture.height < 3) return grids;
  const std::vector<Area> areas = square_areas(steepness, edge, picture.width, picture.height);
  if (areas.size() < min_nodes) return grids;
  std::vector<double> sides;
  for (const Area& area : areas) sides.push_back(area.side);
  std::nth_element(sides.begin(), sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2), sides.end());
  const Neighbourhood near(areas, std::max(4.0, 2.0 * sides[sides.size() / 2]), picture.width,
                           picture.height);

  std::vector<bool> in_a_grid(areas.size(), false);
  for (std::size_t seed = 0; seed < areas.size(); ++seed) {
    if (in_a_grid[seed]) continue;
    // First steps: pairs of neighbours of like size, at right angles within what perspective does, one to two
    // sides away. (The flat part of a patch is smaller than the patch.)
    std::vector<std::pair<double, std::size_t>> neighbours;
    near.near(areas[seed].centre, 2.6 * areas[seed].side + 4.0, [&](std::size_t i) {
      const double ratio = areas[i].size / areas[seed].size;
      const double distance = length(areas[i].centre - areas[seed].centre);
      if (i != seed && ratio > 0.4 && ratio < 2.5 && distance > 0.9 * areas[seed].side)
        neighbours.emplace_back(distance, i);
    });
    std::sort(neighbours.begin(), neighbours.end());
    if (neighbours.size() > 6) neighbours.resize(6);
    PatchGrid best;
    for (std::size_t a = 0; a < neighbours.size(); ++a)
      for (std::size_t b = a + 1; b < neighbours.size(); ++b) {
        const Point u = areas[neighbours[a].second].centre - areas[seed].centre,
                    v = areas[neighbours[b].second].centre - areas[seed].centre;
        const double sine = cross(u, v) / (length(u) * length(v)), ratio = length(u) / length(v);
        if (std::fabs(sine) < 0.75 || ratio < 0.55 || ratio > 1.8) continue;
        // Columns and rows turn clockwise, like the axes of the picture.
        PatchGrid grid = grow(areas, near, seed, sine > 0.0 ? Step{u, v} : Step{v, u});
        if (grid.nodes.size() > best.nodes.size()) best = std::move(grid);
      }
    if (best.nodes.size() < min_nodes) continue;
    for (const GridNode& node : best.nodes)
      near.near(node.centre, 0.5, [&](std::size_t i) { in_a_grid[i] = true; });
    grids.push_back(std::move(best));
  }
  std::stable_sort(grids.begin(), grids.end(),
                   [](const PatchGrid& a, const PatchGrid& b) { return a.nodes.size() > b.nodes.size(); });
  return grids;
}

}  // namespace aluminate::calibration
