// The C-like border between calibration and its lensfun module: plain data only, no exception crosses it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace aluminate::calibration::lens_module {

inline constexpr const char* kFile = "libaluminate_lens_module.so";
inline constexpr const char* kSymbol = "aluminate_find_lens_v1";

struct Query {
  const char *maker, *model, *lens;
  float focal_mm, aperture, distance_m;
};

struct Profile {
  std::int32_t distortion;  // 0 none, 1 poly3, 2 poly5, 3 ptlens
  float distortion_terms[3];
  std::int32_t lateral;  // 0 none, 1 linear (red, blue), 2 poly3 (v, c, b of red and blue, alternating)
  float lateral_terms[6];
  std::int32_t vignetting;  // 0 none, 1 pa
  float vignetting_terms[3];
  float camera_crop, lens_crop, lens_aspect;  // the calibration's sensor against this one
  float centre_x, centre_y;                   // offset of the optical axis, relative
  char found_lens[160];
};

/// False: text says what is missing.
using FindLens = bool (*)(const Query* query, Profile* profile, char* text, std::size_t text_size);

}  // namespace aluminate::calibration::lens_module
