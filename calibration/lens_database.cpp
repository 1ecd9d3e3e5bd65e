// lensfun's profiles as LensModels.
#include <algorithm>
#include <cmath>

#include "calibration/lens.hpp"
#include "calibration/lens_module.hpp"
#include "platform/host/error.hpp"
#include "platform/host/module_file.hpp"

namespace aluminate::calibration {

LensModel lens_from_database(const LensQuery& query, int width, int height) {
  static const auto find = reinterpret_cast<lens_module::FindLens>(host::open_module(
      lens_module::kFile, ALUMINATE_MODULE_DIR, lens_module::kSymbol, "looks lenses up with lensfun"));
  const lens_module::Query plain{query.maker.c_str(),
                                 query.model.c_str(),
                                 query.lens.c_str(),
                                 static_cast<float>(query.focal_mm),
                                 static_cast<float>(query.aperture),
                                 static_cast<float>(query.distance_m)};
  lens_module::Profile profile{};
  char text[300] = "";
  if (query.model.empty() && query.lens.empty())
    throw UserError("the photograph does not say which camera and lens took it",
                    "name the lens model: --lens ptlens:a,b,c");
  if (!find(&plain, &profile, text, sizeof text))
    throw UserError(text, "name the lens model: --lens ptlens:a,b,c");

  LensModel lens;
  static constexpr LensKind kKinds[] = {LensKind::None, LensKind::Poly3, LensKind::Poly5, LensKind::PtLens};
  lens.kind = kKinds[profile.distortion];
  for (std::size_t i = 0; i < 3; ++i) lens.k[i] = static_cast<double>(profile.distortion_terms[i]);
  // lensfun measures in half short sides of the sensor that the lens was calibrated on [Lensfun].
  const double shorter = std::min(width, height), aspect = std::max(width, height) / shorter;
  const double calibration_aspect = static_cast<double>(profile.lens_aspect > 0 ? profile.lens_aspect : 1.5f);
  const double crop =
      profile.camera_crop > 0 ? static_cast<double>(profile.lens_crop / profile.camera_crop) : 1.0;
  const double correction =
      crop * std::sqrt(calibration_aspect * calibration_aspect + 1.0) / std::sqrt(aspect * aspect + 1.0);
  lens.unit_px = 0.5 * shorter / correction;
  lens.vignette_unit_px = lens.unit_px * std::sqrt(calibration_aspect * calibration_aspect + 1.0);
  lens.centre = {0.5 * (width - 1) + static_cast<double>(profile.centre_x) * 0.5 * shorter,
                 0.5 * (height - 1) + static_cast<double>(profile.centre_y) * 0.5 * shorter};
  const auto term = [&](std::size_t i) { return static_cast<double>(profile.lateral_terms[i]); };
  if (profile.lateral == 1) {
    lens.channel_scale[0] = {term(0), 0, 0};
    lens.channel_scale[2] = {term(1), 0, 0};
  } else if (profile.lateral == 2) {
    lens.channel_scale[0] = {term(0), term(2), term(4)};
    lens.channel_scale[2] = {term(1), term(3), term(5)};
  }
  if (profile.vignetting == 1)
    for (std::size_t i = 0; i < 3; ++i) lens.vignette[i] = static_cast<double>(profile.vignetting_terms[i]);
  return lens;
}

}  // namespace aluminate::calibration
