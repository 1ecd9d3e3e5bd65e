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
  Point origin;            // px of the photograph left of and above this picture
  std::vector<float> rgb;  // width*height*3
  const float* pixel(int x, int y) const {
    return rgb.data() +
           3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
  /// Pixel centres of both pictures are at integers.
  Point to_photo(const Point& p) const {
    return {origin.x + (p.x + 0.5) / scale - 0.5, origin.y + (p.y + 0.5) / scale - 0.5};
  }
  Point from_photo(const Point& p) const {
    return {(p.x - origin.x + 0.5) * scale - 0.5, (p.y - origin.y + 0.5) * scale - 0.5};
  }
};

/// Area average when smaller, bilinear when larger.
SmallPicture scaled_picture(const Photo& photo, double scale);
/// Of the part of the photograph that [x0, x1) x [y0, y1) has in common with it; scale <= 1. UserError when
/// that is nothing.
SmallPicture scaled_part(const Photo& photo, double scale, int x0, int y0, int x1, int y1);

struct GridNode {
  Point centre;             // in the small picture
  int column = 0, row = 0;  // lattice coordinates, any origin
};

struct PatchGrid {
  std::vector<GridNode> nodes;
};

/// Per pixel the largest difference between its neighbours in any channel, after a 3 x 3 box blur; infinite
/// at the border. width*height.
std::vector<float> steepness_of(const SmallPicture& picture);

/// Grids of at least min_nodes areas. edge: a pixel that is steeper belongs to no area.
std::vector<PatchGrid> find_grids(const SmallPicture& picture, const std::vector<float>& steepness,
                                  float edge, std::size_t min_nodes);

}  // namespace aluminate::calibration
