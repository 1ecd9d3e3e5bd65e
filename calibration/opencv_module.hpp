// The C-like border between calibration and its OpenCV module: plain data only, no exception crosses it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace aluminate::calibration::opencv_module {

inline constexpr const char* kFile = "libaluminate_opencv_module.so";
inline constexpr const char* kSymbol = "aluminate_find_charts_v1";

/// bgr: width*height*3 sRGB codes. Writes up to `most` quadrilaterals of 8 floats (x, y of dark skin, bluish
/// green, black, white patch centre) and returns how many; -1 when OpenCV failed.
using FindCharts = int (*)(const std::uint8_t* bgr, int width, int height, int most, float* quadrilaterals);

}  // namespace aluminate::calibration::opencv_module
