// Procedural textures, tiling in both directions: 8-bit images as they are stored (sRGB for colours). Integer
// hashing and IEEE arithmetic only, so the texels are the same everywhere.
#pragma once

#include "platform/host/image_file.hpp"

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>

namespace aluminate::scenes::generator {

/// Small deterministic stream of numbers.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
  double unit();  // [0, 1)
  double between(double low, double high) { return low + (high - low) * unit(); }

 private:
  std::uint64_t state_;
};

/// Value noise in [0, 1] that repeats every `period` cells in x and y; smooth between lattice points.
double noise(double x, double y, int period_x, int period_y, std::uint32_t seed);

/// `octaves` of it, each of twice the frequency and half the height; [0, 1], mean 1/2.
double cloudy(double u, double v, int cells_x, int cells_y, int octaves, std::uint32_t seed);

double smooth_step(double low, double high, double x);

/// shade(u, v) in [0, 1] each; texel centres, row 0 = top = v near 0.
host::Image8 paint_rgb(int width, int height, const std::function<glm::dvec3(double, double)>& shade);
host::Image8 paint_rgba(int width, int height, const std::function<glm::dvec4(double, double)>& shade);

/// Tangent-space normals (x right, y up) of a tiling height field in texels' units of uv; `strength`
/// multiplies the slope.
host::Image8 paint_normals(int width, int height, double strength,
                           const std::function<double(double, double)>& height_at);

}  // namespace aluminate::scenes::generator
