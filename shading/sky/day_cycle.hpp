// The artists' day: sky colours keyed over 24 hours. In: keys, a time. Out: the Sky of that moment, ready to
// draw or project.
#pragma once

#include <vector>

#include "shading/sky/sky.hpp"
#include "shading/sky/sun.hpp"

namespace aluminate::sky {

/// Colours at one time of day, linear; the gradient runs from horizon to zenith in cos Z.
struct SkyKey {
  double hours = 12;  // [0, 24)
  glm::dvec3 zenith_lin{1}, horizon_lin{1};
  double intensity = 1;
};

/// Keys in rising order of hours; between keys, and from the last over midnight to the first, everything is
/// linear in time. UserError when there is no key, a key is out of range or out of order.
class DayCycle {
 public:
  explicit DayCycle(std::vector<SkyKey> keys);
  [[nodiscard]] SkyKey at(double hours) const noexcept;  // hours taken modulo 24
  [[nodiscard]] const std::vector<SkyKey>& keys() const noexcept { return keys_; }

 private:
  std::vector<SkyKey> keys_;
};

/// A clear tropical day, colours of ours: chromaticities only (the largest component is 1), so that
/// brightness stays with the CIE model; the night key is a dim blue.
[[nodiscard]] const DayCycle& clear_day();

/// Sun on its path, colours from the cycle. `night` is the cycle's colour at midnight times its intensity
/// there.
[[nodiscard]] Sky sky_at(double hours, const DayCycle& cycle, const CieParameters& cie = kFarCry3Sky,
                         Relative relative = Relative::Sun, const SunPath& path = {});

}  // namespace aluminate::sky
