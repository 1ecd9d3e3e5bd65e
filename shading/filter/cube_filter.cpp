#include "shading/filter/cube_filter.hpp"

#include <bit>
#include <cmath>

#include "platform/host/parallel.hpp"

namespace aluminate::filter {
namespace {

int log2_of(int size) { return std::countr_zero(static_cast<unsigned>(size)); }

/// The power of a level is 2^this.
int power_exponent(int level, int size) { return 13 - 2 * (level - log2_of(size) + 6); }

/// Texels as rows of numbers.
struct Source {
  std::vector<double> x, y, z, solid_angle;
  std::vector<glm::dvec4> light;

  explicit Source(const CubeLevel& level) : light(level.texels) {
    for (int face = 0; face < 6; ++face)
      for (int row = 0; row < level.size; ++row)
        for (int column = 0; column < level.size; ++column) {
          const glm::dvec3 d = cube_direction(face, column, row, level.size);
          x.push_back(d.x);
          y.push_back(d.y);
          z.push_back(d.z);
          solid_angle.push_back(cube_solid_angle(column, row, level.size));
        }
  }

  /// squarings: (n.h)^m = ((1 + r.l) / 2)^(m / 2) with m / 2 = 2^squarings.
  glm::dvec4 gathered(const glm::dvec3& r, int squarings, double least) const {
    glm::dvec4 sum(0.0);
    double weights = 0;
    for (std::size_t i = 0; i < light.size(); ++i) {
      const double r_dot_l = r.x * x[i] + r.y * y[i] + r.z * z[i];
      double lobe = 0.5 + 0.5 * r_dot_l;
      if (r_dot_l <= 0.0 || lobe < least) continue;
      for (int k = 0; k < squarings; ++k) lobe *= lobe;
      const double weight = lobe * r_dot_l * solid_angle[i];
      sum += light[i] * weight;
      weights += weight;
    }
    return sum / weights;
  }
};

}  // namespace

bool is_cube_size(int size) noexcept {
  return size >= kMinCubeFacePx && size <= kMaxCubeFacePx && std::has_single_bit(static_cast<unsigned>(size));
}

glm::dvec3 cube_direction(int face, int x, int y, int size) noexcept {
  const double s = (2 * x + 1) / static_cast<double>(size) - 1,
               t = (2 * y + 1) / static_cast<double>(size) - 1;
  const glm::dvec3 faces[6] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t}, {s, -1, -t}, {s, -t, 1}, {-s, -t, -1}};
  return faces[face] / std::sqrt(1 + s * s + t * t);
}

double cube_solid_angle(int x, int y, int size) noexcept {
  const double s = (2 * x + 1) / static_cast<double>(size) - 1,
               t = (2 * y + 1) / static_cast<double>(size) - 1;
  const double near = 1 / std::sqrt(1 + s * s + t * t);
  return 4.0 / (static_cast<double>(size) * size) * (near * near * near);
}

double cube_level_power(int level, int size) noexcept { return std::ldexp(1.0, power_exponent(level, size)); }

double cube_level_bias(int size) noexcept { return log2_of(size) + 0.5; }

std::vector<CubeLevel> prefilter(CubeLevel capture) {
  const int size = capture.size;
  std::vector<CubeLevel> chain;
  chain.push_back(std::move(capture));
  const Source source(chain.front());
  for (int level = 1; size >> level > 0; ++level) {
    CubeLevel next{size >> level, {}};
    next.texels.resize(6 * static_cast<std::size_t>(next.size) * static_cast<std::size_t>(next.size));
    const int squarings = power_exponent(level, size) - 1;
    double least = 0x1p-30;
    for (int k = 0; k < squarings; ++k) least = std::sqrt(least);
    host::parallel_for(6 * next.size, [&](std::int64_t row) {
      const int face = static_cast<int>(row) / next.size, y = static_cast<int>(row) % next.size;
      for (int x = 0; x < next.size; ++x)
        next.texels[next.index(face, x, y)] =
            source.gathered(cube_direction(face, x, y, next.size), squarings, least);
    });
    chain.push_back(std::move(next));
  }
  return chain;
}

}  // namespace aluminate::filter
