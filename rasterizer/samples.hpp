// Where a pixel is sampled: once at its centre, or four times in the standard pattern of Direct3D [D3D11-FS].
// Coverage, depth and visibility are decided at the samples; colour is shaded once per pixel and triangle.
#pragma once

#include <cstdint>

#include "rasterizer/limits.hpp"

namespace aluminate::raster {

inline constexpr int kMaxSamples = 4;

/// Positions in sub from the pixel's top left corner; kLow and kHigh bound them on both axes.
template <int kSamples>
struct SamplePattern;
template <>
struct SamplePattern<1> {
  static constexpr std::int32_t kX[1] = {kHalfPixel}, kY[1] = {kHalfPixel};
  static constexpr std::int32_t kLow = kHalfPixel, kHigh = kHalfPixel;
};
/// (-2,-6) (6,-2) (-6,2) (2,6) sixteenths of a pixel from the centre: no two share a row or column, all
/// equally far from it.
template <>
struct SamplePattern<4> {
  static constexpr std::int32_t kX[4] = {96, 224, 32, 160}, kY[4] = {32, 96, 160, 224};
  static constexpr std::int32_t kLow = 32, kHigh = 224;
};

/// First and last pixel along an axis that can hold a sample in [low, high] sub: ceil((low - highest) / 256)
/// and floor((high - lowest) / 256); shifts floor. Empty when first > last.
template <int kSamples>
constexpr std::int32_t first_pixel(std::int32_t low) {
  return (low + kSubpixels - 1 - SamplePattern<kSamples>::kHigh) >> kSubpixelBits;
}
template <int kSamples>
constexpr std::int32_t last_pixel(std::int32_t high) {
  return (high - SamplePattern<kSamples>::kLow) >> kSubpixelBits;
}
static_assert(first_pixel<1>(128) == 0 && first_pixel<1>(129) == 1 && last_pixel<1>(128) == 0 &&
              last_pixel<1>(127) == -1);
static_assert(first_pixel<4>(224) == 0 && first_pixel<4>(225) == 1 && last_pixel<4>(32) == 0 &&
              last_pixel<4>(31) == -1);

}  // namespace aluminate::raster
