// The C-like border between calibration and its LibRaw module: plain data only, no exception crosses it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace aluminate::calibration::raw_module {

inline constexpr const char* kFile = "libaluminate_raw_module.so";
inline constexpr const char* kSymbol = "aluminate_decode_raw_v2";

struct Facts {
  std::int32_t width, height;  // of the visible sensor area
  std::int32_t flip;           // EXIF orientation 1, 3, 6 or 8
  std::int32_t white;          // code of a full pixel
  std::int32_t black[4];       // of R, G, B, second G
  float multipliers[4];        // as shot, of R, G, B, second G; 0: not stored
  char pattern[5];             // colours of the top left 2 x 2 pixels, "RGGB"
  char maker[64], model[64], lens[128];
  float focal_mm, aperture, distance_m;
};

/// Gives the whole mosaic once: height rows of width codes as the sensor stored them, each row `pitch` codes after the one
/// before. They are gone when it returns.
using Sink = void (*)(void* context, const Facts* facts, const std::uint16_t* samples, std::size_t pitch);

/// False: text says why.
using DecodeRaw = bool (*)(const std::uint8_t* bytes, std::size_t count, Sink sink, void* context, char* text,
                           std::size_t text_size);

}  // namespace aluminate::calibration::raw_module
