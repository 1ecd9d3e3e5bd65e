#include "shading/sky/day_cycle.hpp"

#include <fmt/format.h>

#include <cmath>

namespace aluminate::sky {

DayCycle::DayCycle(std::vector<SkyKey> keys) : keys_(std::move(keys)) {
  if (keys_.empty())
    throw UserError("a day cycle without keys, expected at least one", "one key makes a constant sky");
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (!(keys_[i].hours >= 0.0 && keys_[i].hours < 24.0))
      throw UserError(fmt::format("day cycle key {} is at {} hours, expected 0 up to but not including 24", i,
                                  keys_[i].hours));
    if (i > 0 && !(keys_[i].hours > keys_[i - 1].hours))
      throw UserError(fmt::format("day cycle key {} is at {} hours, expected a time after {}", i,
                                  keys_[i].hours, keys_[i - 1].hours),
                      "sort the keys by time");
  }
}

SkyKey DayCycle::at(double hours) const noexcept {
  hours -= 24.0 * std::floor(hours / 24.0);
  std::size_t next = 0;
  while (next < keys_.size() && keys_[next].hours <= hours) ++next;
  const SkyKey& a = keys_[next == 0 ? keys_.size() - 1 : next - 1];
  const SkyKey& b = keys_[next == keys_.size() ? 0 : next];
  const auto forward = [](double from, double to) { return to > from ? to - from : to - from + 24.0; };
  const double since = a.hours == hours ? 0.0 : forward(a.hours, hours);
  const double t = since / forward(a.hours, b.hours);
  return {hours, glm::mix(a.zenith_lin, b.zenith_lin, t), glm::mix(a.horizon_lin, b.horizon_lin, t),
          a.intensity + (b.intensity - a.intensity) * t};
}

const DayCycle& clear_day() {
  static const DayCycle cycle({
      {0.0, {0.30, 0.45, 1.00}, {0.40, 0.55, 1.00}, 0.002},
      {5.5, {0.25, 0.40, 1.00}, {1.00, 0.70, 0.60}, 4.0},
      {7.0, {0.25, 0.50, 1.00}, {1.00, 0.85, 0.70}, 4.0},
      {10.0, {0.22, 0.50, 1.00}, {0.75, 0.88, 1.00}, 4.0},
      {15.0, {0.22, 0.50, 1.00}, {0.75, 0.88, 1.00}, 4.0},
      {17.0, {0.25, 0.48, 1.00}, {1.00, 0.80, 0.60}, 4.0},
      {18.5, {0.28, 0.38, 1.00}, {1.00, 0.55, 0.40}, 4.0},
  });
  return cycle;
}

Sky sky_at(double hours, const DayCycle& cycle, const CieParameters& cie, Relative relative,
           const SunPath& path) {
  const SkyKey now = cycle.at(hours), midnight = cycle.at(0.0);
  Sky sky;
  sky.cie = cie;
  sky.relative = relative;
  sky.to_sun = to_sun(sun_at(hours, path));
  sky.gradient = zenith_horizon_gradient(now.zenith_lin, now.horizon_lin);
  sky.intensity = now.intensity;
  sky.night = zenith_horizon_gradient(midnight.zenith_lin * midnight.intensity,
                                      midnight.horizon_lin * midnight.intensity);
  return sky;
}

}  // namespace aluminate::sky
