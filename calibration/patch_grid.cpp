#include "calibration/patch_grid.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <queue>
#include <utility>

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

// 3 x 3 box blur: sensor noise and JPEG blocks must not cut a patch into pieces.
std::vector<float> blurred(const SmallPicture& picture) {
  std::vector<float> result(picture.rgb.size());
  const int w = picture.width, h = picture.height;
  for (int y = 0; y < h; ++y) {
    const int up = std::max(y - 1, 0), down = std::min(y + 1, h - 1);
    for (int x = 0; x < w; ++x) {
      const int left = std::max(x - 1, 0), right = std::min(x + 1, w - 1);
      float* to = result.data() + (picture.pixel(x, y) - picture.rgb.data());
      for (int c = 0; c < 3; ++c) {
        float sum = 0.0f;
        for (const int yy : {up, y, down})
          for (const int xx : {left, x, right}) sum += picture.pixel(xx, yy)[c];
        to[c] = sum / 9.0f;
      }
    }
  }
  return result;
}

std::vector<std::uint8_t> flat_pixels(const SmallPicture& picture, double edge) {
  const std::vector<float> smooth = blurred(picture);
  const int w = picture.width, h = picture.height;
  const auto at = [&](int x, int y) {
    return smooth.data() +
           3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x));
  };
  std::vector<std::uint8_t> flat(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), 0);
  for (int y = 1; y + 1 < h; ++y)
    for (int x = 1; x + 1 < w; ++x) {
      float largest = 0.0f;
      for (int c = 0; c < 3; ++c) {
        largest = std::max(largest, std::fabs(at(x + 1, y)[c] - at(x - 1, y)[c]));
        largest = std::max(largest, std::fabs(at(x, y + 1)[c] - at(x, y - 1)[c]));
      }
      flat[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)] =
          static_cast<double>(largest) < edge ? 1 : 0;
    }
  return flat;
}

std::vector<Area> square_areas(std::vector<std::uint8_t> flat, int w, int h) {
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

// Areas by place, for "what lies near p".
class Neighbourhood {
 public:
  Neighbourhood(const std::vector<Area>& areas, double cell) : areas_(areas), cell_(cell) {
    for (std::size_t i = 0; i < areas.size(); ++i) cells_[key(areas[i].centre)].push_back(i);
  }
  template <class Visit>
  void near(const Point& p, double radius, Visit&& visit) const {
    const int reach = static_cast<int>(std::ceil(radius / cell_));
    const auto [cx, cy] = key(p);
    for (int y = cy - reach; y <= cy + reach; ++y)
      for (int x = cx - reach; x <= cx + reach; ++x)
        if (const auto found = cells_.find({x, y}); found != cells_.end())
          for (const std::size_t i : found->second)
            if (length(areas_[i].centre - p) <= radius) visit(i);
  }

 private:
  std::pair<int, int> key(const Point& p) const {
    return {static_cast<int>(std::floor(p.x / cell_)), static_cast<int>(std::floor(p.y / cell_))};
  }
  const std::vector<Area>& areas_;
  double cell_;
  std::map<std::pair<int, int>, std::vector<std::size_t>> cells_;
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
  std::vector<bool> taken(areas.size(), false);
  taken[seed] = true;
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
        if (!taken[i] && ratio > 0.4 && ratio < 2.5 && distance < nearest) {
          nearest = distance;
          found = i;
        }
      });
      if (found == areas.size()) continue;
      Step next = node.step;
      const Point actual = areas[found].centre - from;
      (dc != 0 ? next.along_column : next.along_row) = static_cast<double>(dc + dr) * actual;
      taken[found] = true;
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

SmallPicture scaled_picture(const Photo& photo, double scale) {
  SmallPicture picture;
  picture.scale = scale;
  picture.width = std::max(1, static_cast<int>(std::floor(photo.width * scale)));
  picture.height = std::max(1, static_cast<int>(std::floor(photo.height * scale)));
  picture.rgb.resize(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) * 3);
  host::parallel_for(
      picture.height,
      [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        float* to =
            picture.rgb.data() + 3 * static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width);
        for (int x = 0; x < picture.width; ++x, to += 3) {
          double sum[3]{};
          if (scale < 1.0) {
            const int x0 = static_cast<int>(x / scale),
                      x1 = std::clamp(static_cast<int>((x + 1) / scale), x0 + 1, photo.width);
            const int y0 = static_cast<int>(y / scale),
                      y1 = std::clamp(static_cast<int>((y + 1) / scale), y0 + 1, photo.height);
            for (int yy = y0; yy < y1; ++yy)
              for (int xx = x0; xx < x1; ++xx)
                for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(photo.pixel(xx, yy)[c]);
            for (double& s : sum) s /= static_cast<double>((x1 - x0) * (y1 - y0));
          } else {
            const Point p = picture.to_photo({static_cast<double>(x), static_cast<double>(y)});
            const double px = std::clamp(p.x, 0.0, photo.width - 1.0),
                         py = std::clamp(p.y, 0.0, photo.height - 1.0);
            const int x0 = static_cast<int>(px), y0 = static_cast<int>(py);
            const int x1 = std::min(x0 + 1, photo.width - 1), y1 = std::min(y0 + 1, photo.height - 1);
            const double fx = px - x0, fy = py - y0;
            for (int c = 0; c < 3; ++c) {
              sum[c] = (1 - fy) * ((1 - fx) * static_cast<double>(photo.pixel(x0, y0)[c]) +
                                   fx * static_cast<double>(photo.pixel(x1, y0)[c])) +
                       fy * ((1 - fx) * static_cast<double>(photo.pixel(x0, y1)[c]) +
                             fx * static_cast<double>(photo.pixel(x1, y1)[c]));
            }
          }
          for (int c = 0; c < 3; ++c) to[c] = lightness(static_cast<float>(sum[c]));
        }
      },
      4);
  return picture;
}

std::vector<PatchGrid> find_grids(const SmallPicture& picture, double edge, std::size_t min_nodes) {
  std::vector<PatchGrid> grids;
  if (picture.width < 3 || picture.height < 3) return grids;
  const std::vector<Area> areas = square_areas(flat_pixels(picture, edge), picture.width, picture.height);
  if (areas.size() < min_nodes) return grids;
  std::vector<double> sides;
  for (const Area& area : areas) sides.push_back(area.side);
  std::nth_element(sides.begin(), sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2), sides.end());
  const Neighbourhood near(areas, std::max(4.0, 2.0 * sides[sides.size() / 2]));

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
