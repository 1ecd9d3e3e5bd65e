// What a camera does to the chart, for tests: white balance, cross-talk, a wrong gamma, noise, 8-bit codes.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "calibration/chart.hpp"
#include "calibration/fit.hpp"

namespace aluminate::calibration::test {

struct Camera {
  Colour balance{1.0, 1.0, 1.0};
  Matrix3 cross_talk{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  double gamma = 1.0;  // exponent applied to linear light before sRGB encoding
  int code_max = 0;    // 255, 65535; 0: no quantisation
  double noise = 0.0;  // standard deviation, of encoded values
};

/// White balance, cross-talk between neighbours, gamma wrong by a tenth, 8 bits.
inline Camera realistic_camera() {
  Camera camera;
  camera.balance = {0.95, 0.80, 0.55};
  camera.cross_talk = {{{0.80, 0.15, 0.05}, {0.10, 0.80, 0.10}, {0.04, 0.16, 0.80}}};
  camera.gamma = 1.0 / 1.1;
  camera.code_max = 255;
  return camera;
}

/// Encoded sRGB value in [0, 1] that the camera stores for a linear colour.
inline Colour photograph_encoded(const Camera& camera, const Colour& rgb_lin,
                                 std::mt19937* random = nullptr) {
  Colour seen = multiply(camera.cross_talk, rgb_lin);
  for (std::size_t c = 0; c < 3; ++c) {
    double value = seen[c] * camera.balance[c];
    value = std::copysign(std::pow(std::fabs(value), camera.gamma), value);
    value = linear_to_srgb(value);
    if (random != nullptr && camera.noise > 0.0) {
      double sum = 0.0;  // twelve uniforms: variance 1, the same on every machine
      for (int i = 0; i < 12; ++i) sum += static_cast<double>((*random)()) / 4294967296.0;
      value += camera.noise * (sum - 6.0);
    }
    if (camera.code_max > 0)
      value = std::round(std::min(std::max(value, 0.0), 1.0) * camera.code_max) / camera.code_max;
    seen[c] = value;
  }
  return seen;
}

inline PatchColours photographed_patches(const Camera& camera, const ChartReference& reference) {
  PatchColours samples;
  samples.usable.fill(true);
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    samples.rgb_lin[i] = photograph_encoded(camera, reference.rgb_lin[i]);
    for (double& value : samples.rgb_lin[i]) value = srgb_to_linear(value);
  }
  return samples;
}

}  // namespace aluminate::calibration::test
