#include "shading/sky/dome.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shading/brdf/quadrature.hpp"

namespace aluminate::sky {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTolerance = 1e-10;

double largest(const glm::dvec3& v) { return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}); }

/// int over the upper hemisphere of radiance times weight(direction), for a weight that is smooth but for
/// kinks at the given zenith angles and, on a ring, at the azimuths that `ring_kinks(zenith, out)` appends.
/// Azimuths in (-pi, pi].
template <class Weight, class RingKinks>
glm::dvec3 integrate_dome(const Sky& sky, std::vector<double> zenith_edges, const RingKinks& ring_kinks,
                          const Weight& weight) {
  const double sun_azimuth = std::atan2(sky.to_sun.y, sky.to_sun.x);
  zenith_edges.insert(zenith_edges.end(),
                      {0.0, kPi / 2.0, std::min(angle_between(sky.to_sun, {0, 0, 1}), kPi / 2.0)});
  for (const SkyGradient* gradient : {&sky.gradient, &sky.night})
    for (const ColorStop& stop : gradient->stops)
      zenith_edges.push_back(std::acos(std::clamp(stop.cos_zenith, 0.0, 1.0)));
  std::sort(zenith_edges.begin(), zenith_edges.end());

  const auto magnitude = [](const glm::dvec3& v) { return largest(v); };
  std::vector<double> edges;
  const auto ring = [&](double zenith) {
    edges.assign({-kPi, kPi, sun_azimuth});
    ring_kinks(zenith, edges);
    std::sort(edges.begin(), edges.end());
    glm::dvec3 sum(0.0);
    for (std::size_t i = 1; i < edges.size(); ++i)
      sum += brdf::integrate<glm::dvec3>(
          [&](double azimuth) {
            const glm::dvec3 d = direction(zenith, azimuth);
            return extended_radiance(sky, d) * weight(d);
          },
          edges[i - 1], edges[i], kTolerance, magnitude);
    return sum * std::sin(zenith);
  };
  glm::dvec3 sum(0.0);
  for (std::size_t i = 1; i < zenith_edges.size(); ++i)
    sum += brdf::integrate<glm::dvec3>(ring, zenith_edges[i - 1], zenith_edges[i], kTolerance, magnitude);
  return sum;
}

}  // namespace

DomeIntegral dome_integral(const Sky& sky) {
  const auto no_kinks = [](double, std::vector<double>&) {};
  return {integrate_dome(sky, {}, no_kinks, [](const glm::dvec3&) { return 1.0; }),
          integrate_dome(sky, {}, no_kinks, [](const glm::dvec3& d) { return d.z; })};
}

glm::dvec3 direct_irradiance(const Sky& sky, const glm::dvec3& normal) {
  const double across = std::hypot(normal.x, normal.y);
  const double facing = std::atan2(normal.y, normal.x);
  // A ring meets the normal's horizon where n.z cos Z + across sin Z cos(az - facing) = 0, from Z = |pi/2 -
  // Zn| on.
  const double first = std::fabs(std::atan2(normal.z, across));
  const auto kinks = [&](double zenith, std::vector<double>& edges) {
    const double reach = across * std::sin(zenith), height = normal.z * std::cos(zenith);
    if (!(std::fabs(height) < reach)) return;
    const double half = std::acos(-height / reach);
    edges.push_back(std::remainder(facing + half, 2.0 * kPi));
    edges.push_back(std::remainder(facing - half, 2.0 * kPi));
  };
  const glm::dvec3 above = integrate_dome(
      sky, {first}, kinks, [&](const glm::dvec3& d) { return std::max(0.0, glm::dot(normal, d)); });
  return above + sky.ground * (kPi * 0.5 * (1.0 - normal.z));
}

glm::dvec3 latlong_direction(int x, int y, int width, int height) noexcept {
  return direction(kPi * (y + 0.5) / height, 2.0 * kPi * (x + 0.5) / width - kPi);
}

double latlong_solid_angle(int y, int width, int height) noexcept {
  return 2.0 * kPi / width * (std::cos(kPi * y / height) - std::cos(kPi * (y + 1) / height));
}

std::vector<float> dome_image(const Sky& sky, const DomeImageOptions& options) {
  constexpr int kMaxSide = 16384;
  if (options.width < 1 || options.height < 1 || options.width > kMaxSide || options.height > kMaxSide)
    throw UserError(fmt::format("dome image of {}x{}, expected 1 to {} pixels a side", options.width,
                                options.height, kMaxSide),
                    "a latitude-longitude map is twice as wide as high, 1024x512 for example");
  std::vector<float> pixels;
  pixels.reserve(static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height) * 3);
  for (int y = 0; y < options.height; ++y)
    for (int x = 0; x < options.width; ++x) {
      const glm::dvec3 d = latlong_direction(x, y, options.width, options.height);
      const glm::dvec3 seen =
          options.below == BelowHorizon::Extend ? extended_radiance(sky, d) : radiance(sky, d);
      const glm::dvec3 color = seen * options.post_process;
      for (int i = 0; i < 3; ++i) pixels.push_back(static_cast<float>(color[i]));
    }
  return pixels;
}

}  // namespace aluminate::sky
