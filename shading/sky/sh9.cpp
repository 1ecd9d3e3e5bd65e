#include "shading/sky/sh9.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "shading/brdf/quadrature.hpp"

namespace aluminate::sky {
namespace {

constexpr double kPi = std::numbers::pi;
const double kY0 = std::sqrt(1.0 / (4.0 * kPi));
const double kY1 = std::sqrt(3.0 / (4.0 * kPi));
const double kY2 = std::sqrt(15.0 / (4.0 * kPi));
const double kY20 = std::sqrt(5.0 / (16.0 * kPi));
constexpr double kTolerance = 1e-10;

/// The six coefficients that a sky with its sun at azimuth 0 can have; sines vanish by symmetry.
struct Symmetric {
  glm::dvec3 y00{0}, y10{0}, y11{0}, y20{0}, y21{0}, y22{0};
  friend Symmetric operator+(const Symmetric& a, const Symmetric& b) {
    return {a.y00 + b.y00, a.y10 + b.y10, a.y11 + b.y11, a.y20 + b.y20, a.y21 + b.y21, a.y22 + b.y22};
  }
  friend Symmetric operator*(const Symmetric& a, double s) {
    return {a.y00 * s, a.y10 * s, a.y11 * s, a.y20 * s, a.y21 * s, a.y22 * s};
  }
};

double largest(const glm::dvec3& v) { return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}); }
double largest(const Symmetric& v) {
  return std::max(
      {largest(v.y00), largest(v.y10), largest(v.y11), largest(v.y20), largest(v.y21), largest(v.y22)});
}

}  // namespace

std::array<double, 9> sh9_basis(const glm::dvec3& d) noexcept {
  return {kY0,
          kY1 * d.y,
          kY1 * d.z,
          kY1 * d.x,
          kY2 * d.x * d.y,
          kY2 * d.y * d.z,
          kY20 * (3.0 * d.z * d.z - 1.0),
          kY2 * d.x * d.z,
          0.5 * kY2 * (d.x * d.x - d.y * d.y)};
}

Sh9 project(const Sky& sky) {
  const double sun_zenith = angle_between(sky.to_sun, {0, 0, 1});
  const double sun_azimuth = std::atan2(sky.to_sun.y, sky.to_sun.x);
  const glm::dvec3 sun = direction(sun_zenith, 0.0);
  const double day = day_share(sky.to_sun);
  const double scale = day * sky.intensity * normalisation(sky.cie, sky.relative, sun);

  // int f(chi), f cos az, f cos 2 az over one turn. The corona's cusp lies at az = 0, an end of the interval.
  const auto azimuth_moments = [&](double zenith) {
    return 2.0 * brdf::integrate<glm::dvec3>(
                     [&](double azimuth) {
                       const double f = indicatrix(sky.cie, angle_between(sun, direction(zenith, azimuth)));
                       return f * glm::dvec3(1.0, std::cos(azimuth), std::cos(2.0 * azimuth));
                     },
                     0.0, kPi, kTolerance, [](const glm::dvec3& v) { return largest(v); });
  };
  const auto ring = [&](double zenith) {
    const double c = std::cos(zenith), s = std::sin(zenith);
    glm::dvec3 even(0.0), first(0.0), second(0.0);  // rgb times the three moments
    if (day > 0.0) {
      const glm::dvec3 moments = azimuth_moments(zenith);
      const glm::dvec3 color = sky.gradient.at(c) * (scale * gradation(sky.cie, c));
      even = color * moments.x, first = color * moments.y, second = color * moments.z;
    }
    if (day < 1.0) even += sky.night.at(c) * ((1.0 - day) * 2.0 * kPi);
    return Symmetric{even * kY0,
                     even * (kY1 * c),
                     first * (kY1 * s),
                     even * (kY20 * (3.0 * c * c - 1.0)),
                     first * (kY2 * s * c),
                     second * (0.5 * kY2 * s * s)} *
           s;
  };

  std::vector<double> edges{0.0, kPi / 2.0, std::min(sun_zenith, kPi / 2.0)};
  for (const SkyGradient* gradient : {&sky.gradient, &sky.night})
    for (const ColorStop& stop : gradient->stops)
      edges.push_back(std::acos(std::clamp(stop.cos_zenith, 0.0, 1.0)));
  std::sort(edges.begin(), edges.end());
  Symmetric sum;
  for (std::size_t i = 1; i < edges.size(); ++i)
    sum = sum + brdf::integrate<Symmetric>(ring, edges[i - 1], edges[i], kTolerance,
                                           [](const Symmetric& v) { return largest(v); });

  // A constant below the horizon has only these two moments: 2 pi Y00 and int z = -pi.
  sum.y00 += sky.ground * (2.0 * kPi * kY0);
  sum.y10 += sky.ground * (-kPi * kY1);

  const double c1 = std::cos(sun_azimuth), s1 = std::sin(sun_azimuth);
  const double c2 = std::cos(2.0 * sun_azimuth), s2 = std::sin(2.0 * sun_azimuth);
  Sh9 turned{sum.y00,      sum.y11 * s1, sum.y10,      sum.y11 * c1, sum.y22 * s2,
             sum.y21 * s1, sum.y20,      sum.y21 * c1, sum.y22 * c2};
  for (glm::dvec3& c : turned) c += 0.0;  // a sine of 0 leaves -0, which prints
  return turned;
}

Sh9 snapped(const Sh9& light) noexcept {
  constexpr double kGrid = 1048576.0;
  Sh9 out;
  for (std::size_t i = 0; i < light.size(); ++i)
    for (int k = 0; k < 3; ++k) out[i][k] = std::nearbyint(light[i][k] * kGrid) / kGrid;
  return out;
}

glm::dvec3 irradiance(const Sh9& light, const glm::dvec3& normal, int bands) noexcept {
  constexpr double kA[9] = {kPi,     2 * kPi / 3, 2 * kPi / 3, 2 * kPi / 3, kPi / 4,
                            kPi / 4, kPi / 4,     kPi / 4,     kPi / 4};
  const std::array<double, 9> basis = sh9_basis(normal);
  glm::dvec3 sum(0.0);
  for (int i = 0; i < std::min(bands * bands, 9); ++i) {
    const auto at = static_cast<std::size_t>(i);
    sum += light[at] * (kA[at] * basis[at]);
  }
  return sum;
}

glm::dvec3 irradiance_polynomial(const Sh9& light, const glm::dvec3& n) noexcept {
  const double c1 = kPi / 4.0 * 0.5 * kY2;
  const double c2 = kPi / 3.0 * kY1;
  const double c3 = kPi / 4.0 * 3.0 * kY20;
  const double c4 = kPi * kY0;
  const double c5 = kPi / 4.0 * kY20;
  const auto& [l00, l1m1, l10, l11, l2m2, l2m1, l20, l21, l22] = light;
  return c4 * l00 - c5 * l20 + 2.0 * c2 * (l11 * n.x + l1m1 * n.y + l10 * n.z) +
         c1 * l22 * (n.x * n.x - n.y * n.y) + c3 * l20 * (n.z * n.z) +
         2.0 * c1 * (l2m2 * (n.x * n.y) + l21 * (n.x * n.z) + l2m1 * (n.y * n.z));
}

glm::dvec3 HemisphereAmbient::at(double n_dot_up) const noexcept {
  return glm::mix(lower, upper, 0.5 * n_dot_up + 0.5);
}

HemisphereAmbient hemisphere_ambient(const Sh9& light) noexcept {
  const glm::dvec3 middle = light[0] * kY0;               // pi Y00 c00 / pi
  const glm::dvec3 slope = light[2] * (2.0 / 3.0 * kY1);  // (2 pi / 3) Y10 c10 / pi at n = up
  return {middle + slope, glm::max(middle - slope, glm::dvec3(0.0))};
}

}  // namespace aluminate::sky
