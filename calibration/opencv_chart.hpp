// Charts that OpenCV's mcc module proposes. OpenCV takes ~0.2 s to load, so it lives in a module of its own
// (opencv_module.cpp) that is opened on the first call. In: a photograph. Out: quadrilaterals of corner patch
// centres, clockwise, best first; they may be no charts at all. Without the module the list is empty and a
// warning says so.
#pragma once

#include <vector>

#include "calibration/chart_geometry.hpp"
#include "calibration/photo.hpp"

namespace aluminate::calibration {

std::vector<Corners> opencv_charts(const Photo& photo);

}  // namespace aluminate::calibration
