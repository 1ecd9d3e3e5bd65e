// Photographs of a chart made by the tests: any position, any camera, any background, with a known answer.
#pragma once

#include <functional>
#include <string>

#include "calibration/chart_geometry.hpp"
#include "calibration/photo.hpp"
#include "tests/calibration/photo_model.hpp"

namespace aluminate::calibration::test {

struct Scene {
  int width = 640, height = 480;
  Corners corners{{{160, 130}, {480, 130}, {480, 322}, {160, 322}}};
  ChartEdition edition = ChartEdition::After2014;
  Camera camera;
  bool has_chart = true;
  double blur_px = 0.0;  // sigma of a Gaussian over linear light
  unsigned seed = 1;
  std::function<Colour(const Point& chart, const Colour& colour)>
      change;  // applied to chart colours, in chart coordinates
};

/// Chart colours, or the background, at a point: black card around the patches, a soft pattern behind it.
Colour scene_colour(const Scene& scene, const Homography& to_chart, const Point& p);

/// Linear light, no camera.
Photo ideal_photo(const Scene& scene);
/// Through the camera, as encoded values in [0, 1].
host::ImageFloat photograph(const Scene& scene);
/// The same as a file: .png of 8 or 16 bits by scene.camera.code_max.
void write_photograph(const Scene& scene, const std::string& path);

}  // namespace aluminate::calibration::test
