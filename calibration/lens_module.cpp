// The only file that includes lensfun. Built as a module that nothing links: see lens_module.hpp.
#include "calibration/lens_module.hpp"

#include <lensfun/lensfun.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>

namespace {

using namespace aluminate::calibration::lens_module;

struct DestroyDatabase {
  void operator()(lfDatabase* database) const { lf_db_destroy(database); }
};
struct FreeList {
  void operator()(void* list) const { lf_free(list); }
};

bool find(const Query& query, Profile& profile, char* text, std::size_t text_size) {
  const auto fail = [&](const char* what, const char* name) {
    std::snprintf(text, text_size, "%s '%s'", what, name);
    return false;
  };
  const std::unique_ptr<lfDatabase, DestroyDatabase> database(lf_db_new());
  if (!database || database->Load() != LF_NO_ERROR)
    return fail("lensfun's database cannot be read; the Debian package is", "liblensfun-data-v1");
  const lfCamera* camera = nullptr;
  std::unique_ptr<const lfCamera*, FreeList> cameras;
  if (query.model[0] != '\0') {
    cameras.reset(database->FindCamerasExt(query.maker[0] != '\0' ? query.maker : nullptr, query.model,
                                           LF_SEARCH_LOOSE));
    if (!cameras) return fail("lensfun does not know the camera", query.model);
    camera = *cameras;
  }
  const std::unique_ptr<const lfLens*, FreeList> lenses(
      database->FindLenses(camera, nullptr, query.lens[0] != '\0' ? query.lens : nullptr));
  if (!lenses)
    return fail("lensfun does not know the lens", query.lens[0] != '\0' ? query.lens : query.model);
  const lfLens* lens = *lenses;
  profile.camera_crop = camera != nullptr ? camera->CropFactor : lens->CropFactor;
  profile.lens_crop = lens->CropFactor;
  profile.lens_aspect = lens->AspectRatio;
  profile.centre_x = lens->CenterX;
  profile.centre_y = lens->CenterY;
  std::snprintf(profile.found_lens, sizeof profile.found_lens, "%s", lf_mlstr_get(lens->Model));
  const float focal = query.focal_mm > 0 ? query.focal_mm : lens->MinFocal;

  lfLensCalibDistortion distortion{};
  if (lens->InterpolateDistortion(focal, distortion)) {
    profile.distortion = distortion.Model == LF_DIST_MODEL_POLY3    ? 1
                         : distortion.Model == LF_DIST_MODEL_POLY5  ? 2
                         : distortion.Model == LF_DIST_MODEL_PTLENS ? 3
                                                                    : 0;
    std::copy_n(distortion.Terms, 3, profile.distortion_terms);
  }
  lfLensCalibTCA lateral{};
  if (lens->InterpolateTCA(focal, lateral)) {
    profile.lateral = lateral.Model == LF_TCA_MODEL_LINEAR ? 1 : lateral.Model == LF_TCA_MODEL_POLY3 ? 2 : 0;
    std::copy_n(lateral.Terms, 6, profile.lateral_terms);
  }
  lfLensCalibVignetting vignetting{};
  const float aperture = query.aperture > 0 ? query.aperture : lens->MinAperture;
  if (lens->InterpolateVignetting(focal, aperture, query.distance_m > 0 ? query.distance_m : 1000.0f,
                                  vignetting)) {
    profile.vignetting = vignetting.Model == LF_VIGNETTING_MODEL_PA ? 1 : 0;
    std::copy_n(vignetting.Terms, 3, profile.vignetting_terms);
  }
  return true;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) bool aluminate_find_lens_v1(const Query* query,
                                                                              Profile* profile, char* text,
                                                                              std::size_t text_size) {
  try {
    *profile = {};
    return find(*query, *profile, text, text_size);
  } catch (const std::exception& error) {
    std::snprintf(text, text_size, "%s", error.what());
    return false;
  }
}
