#include "scenes/generator/paint.hpp"

#include <algorithm>
#include <cmath>

namespace aluminate::scenes::generator {
namespace {

/// Hash of a lattice point to [0, 1]: 32-bit integer mixing, exact everywhere.
double lattice(int x, int y, std::uint32_t seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x85EBCA6Bu ^
                    static_cast<std::uint32_t>(y) * 0xC2B2AE35u ^ seed * 0x27D4EB2Fu;
  h ^= h >> 15;
  h *= 0x2C1B3C6Du;
  h ^= h >> 12;
  h *= 0x297A2D39u;
  h ^= h >> 15;
  return h / 4294967295.0;
}

int wrapped(int i, int period) { return ((i % period) + period) % period; }

std::uint8_t code(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 1.0) * 255));
}

}  // namespace

double Dice::unit() {
  // xorshift64*: the high 53 bits of a full-period generator.
  state_ ^= state_ >> 12;
  state_ ^= state_ << 25;
  state_ ^= state_ >> 27;
  return static_cast<double>((state_ * 0x2545F4914F6CDD1Du) >> 11) * 0x1p-53;
}

double noise(double x, double y, int period_x, int period_y, std::uint32_t seed) {
  const double fx = std::floor(x), fy = std::floor(y), tx = x - fx, ty = y - fy;
  const int x0 = wrapped(static_cast<int>(fx), period_x), y0 = wrapped(static_cast<int>(fy), period_y);
  const int x1 = (x0 + 1) % period_x, y1 = (y0 + 1) % period_y;
  const double sx = tx * tx * (3 - 2 * tx), sy = ty * ty * (3 - 2 * ty);
  const double top = lattice(x0, y0, seed) * (1 - sx) + lattice(x1, y0, seed) * sx;
  const double bottom = lattice(x0, y1, seed) * (1 - sx) + lattice(x1, y1, seed) * sx;
  return top * (1 - sy) + bottom * sy;
}

double cloudy(double u, double v, int cells_x, int cells_y, int octaves, std::uint32_t seed) {
  double sum = 0, weight = 0, height = 1;
  for (int i = 0; i < octaves; ++i) {
    sum += height * noise(u * cells_x, v * cells_y, cells_x, cells_y, seed + static_cast<std::uint32_t>(i));
    weight += height;
    height /= 2;
    cells_x *= 2;
    cells_y *= 2;
  }
  return sum / weight;
}

double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

host::Image8 paint_rgba(int width, int height, const std::function<glm::dvec4(double, double)>& shade) {
  host::Image8 image{width, height, 4, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::dvec4 c = shade((x + 0.5) / width, (y + 0.5) / height);
      for (int k = 0; k < 4; ++k) image.texels.push_back(code(c[k]));
    }
  }
  return image;
}

host::Image8 paint_rgb(int width, int height, const std::function<glm::dvec3(double, double)>& shade) {
  host::Image8 image{width, height, 3, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::dvec3 c = shade((x + 0.5) / width, (y + 0.5) / height);
      for (int k = 0; k < 3; ++k) image.texels.push_back(code(c[k]));
    }
  }
  return image;
}

host::Image8 paint_normals(int width, int height, double strength,
                           const std::function<double(double, double)>& height_at) {
  const double du = 1.0 / width, dv = 1.0 / height;
  return paint_rgb(width, height, [&](double u, double v) {
    const double slope_x = (height_at(u + du, v) - height_at(u - du, v)) / (2 * du);
    const double slope_y =
        (height_at(u, v - dv) - height_at(u, v + dv)) / (2 * dv);  // up is towards smaller v
    const glm::dvec3 n(-strength * slope_x, -strength * slope_y, 1);
    return n / std::sqrt(glm::dot(n, n)) * 0.5 + 0.5;
  });
}

}  // namespace aluminate::scenes::generator
