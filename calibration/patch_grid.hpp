// Finds grids of uniform, roughly square areas in a small picture: candidates for a chart, whatever their
// colours. In: a perceptually spaced RGB picture. Out: lattices of areas, each with its integer coordinates,
// largest first. Never decides whether a grid is a ColorChecker: see calibration/find_chart.hpp.
#pragma once

#include <vector>

#include "calibration/chart_geometry.hpp"
#include "calibration/photo.hpp"

namespace aluminate::calibration {

/// Cube roots of linear values, close to lightness: equal steps are about equally visible, dark or bright.
struct SmallPicture {
  int width = 0, height = 0;
  double scale = 1.0;      // px of this picture per px of the photograph
  std::vector<float> rgb;  // width*height*3
  const float* pixel(int x, int y) const {
    return rgb.data() +
           3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
  /// Pixel centres of both pictures are at integers.
  Point to_photo(const Point& p) const { return {(p.x + 0.5) / scale - 0.5, (p.y + 0.5) / scale - 0.5}; }
};

/// Area average when smaller, bilinear when larger.
SmallPicture scaled_picture(const Photo& photo, double scale);

struct GridNode {
  Point centre;             // in the small picture
  int column = 0, row = 0;  // lattice coordinates, any origin
};

struct PatchGrid {
  std::vector<GridNode> nodes;
};

/// Grids of at least min_nodes areas. edge: a pixel whose neighbours differ by more, in picture values,
/// belongs to no area.
std::vector<PatchGrid> find_grids(const SmallPicture& picture, double edge, std::size_t min_nodes);

}  // namespace aluminate::calibration
