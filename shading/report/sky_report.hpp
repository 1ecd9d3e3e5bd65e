// The sky's numbers for scripts: luminance tables, SH coefficients, the dome as an image.
#pragma once

#include <glm/glm.hpp>
#include <string>

#include "shading/report/evaluate.hpp"
#include "shading/sky/sky.hpp"

namespace aluminate::report {

/// Columns sun_zenith_deg,view_zenith_deg,azimuth_from_sun_deg in any order; adds
/// L_over_L_zenith,L_over_L_sun.
std::string sky_table(const Csv& inputs, const std::string& path, const sky::CieParameters& parameters);

/// A sky for `sky sh9` and `sky dome`: the sun at (sin Zs, 0, cos Zs), z up.
struct SkyRequest {
  std::string sky = "fc3";
  double sun_zenith_deg = 45;
  glm::dvec3 zenith_color{1}, horizon_color{1};
  std::string relative = "sun";
};
sky::Sky make_sky(const SkyRequest& request);

/// 9 coefficients x rgb in the order 00,1-1,10,11,2-2,2-1,20,21,22.
std::string sh9_json(const SkyRequest& request);
std::string sh9_text(const SkyRequest& request);

/// "r,g,b" or one number for all three; finite and not negative.
glm::dvec3 parse_color(const std::string& option, const std::string& text);

}  // namespace aluminate::report
