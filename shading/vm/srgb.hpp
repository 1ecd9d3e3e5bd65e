// sRGB transfer function, exact: a table for decoding, thresholds for encoding, no libm at run time. [IEC61966-2-1]
//   decode  8-bit code -> 16-bit linear integer (65535 = 1), nearest
//   encode  linear binary64 -> 8-bit code, round(255 f(x)) with f exact; monotone; NaN and x <= 0 give 0, x >= 1 gives 255
// encode(decode(c) / 65535) == c for every code.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "shading/vm/srgb_tables.hpp"

namespace aluminate::vm {

constexpr std::uint16_t srgb_decode16(std::uint8_t code) { return kSrgbDecode16[code]; }

namespace detail {

// [2^-13, 1) in 128 buckets an octave: the top bits of the binary64 itself. No bucket holds more than one threshold.
inline constexpr int kSrgbOctaves = 13, kSrgbBucketBits = 7;
inline constexpr int kSrgbBuckets = kSrgbOctaves << kSrgbBucketBits;
inline constexpr int kSrgbShift = 52 - kSrgbBucketBits;
inline constexpr std::uint64_t kSrgbFirstBucket = std::bit_cast<std::uint64_t>(0x1p-13) >> kSrgbShift;

// Code of the smallest value of each bucket.
inline constexpr std::array<std::uint8_t, kSrgbBuckets> kSrgbBucketCode = [] {
  std::array<std::uint8_t, kSrgbBuckets> codes{};
  int code = 0;
  for (std::uint64_t b = 0; b < kSrgbBuckets; ++b) {
    const double start = std::bit_cast<double>((kSrgbFirstBucket + b) << kSrgbShift);
    while (code < 255 && start >= kSrgbThreshold[code + 1]) ++code;
    codes[b] = static_cast<std::uint8_t>(code);
  }
  return codes;
}();

constexpr bool one_threshold_per_bucket() {
  for (std::uint64_t b = 0; b < kSrgbBuckets; ++b) {
    const double end = std::bit_cast<double>((kSrgbFirstBucket + b + 1) << kSrgbShift);
    const int code = kSrgbBucketCode[b];
    if (code + 2 < 256 && kSrgbThreshold[code + 2] < end) return false;
  }
  return true;
}
static_assert(one_threshold_per_bucket());
static_assert(kSrgbThreshold[1] > 0x1p-13, "values below the first bucket encode to 0");

}  // namespace detail

constexpr std::uint8_t srgb_encode8(double linear) {
  if (!(linear >= 0x1p-13)) return 0;
  if (linear >= 1.0) return 255;
  const std::uint64_t bucket = (std::bit_cast<std::uint64_t>(linear) >> detail::kSrgbShift) - detail::kSrgbFirstBucket;
  const int code = detail::kSrgbBucketCode[bucket];
  return static_cast<std::uint8_t>(code + (code < 255 && linear >= kSrgbThreshold[code + 1] ? 1 : 0));
}

namespace detail {

// The same buckets for a binary32: its exponent and 7 bits are the bucket, the 16 bits below are compared with the
// bucket's threshold by a carry. An entry is code * 2^16 + (2^16 - low half of the least binary32 at or above the
// threshold), or code * 2^16 where the bucket holds none: entry + low half has the code in its upper half.
inline constexpr std::uint32_t kSrgbFirstBucket32 = std::bit_cast<std::uint32_t>(0x1p-13f) >> 16;
inline constexpr std::array<std::uint32_t, kSrgbBuckets> kSrgbEntry32 = [] {
  std::array<std::uint32_t, kSrgbBuckets> entries{};
  for (std::uint32_t b = 0; b < kSrgbBuckets; ++b) {
    const std::uint32_t code = kSrgbBucketCode[b];
    entries[b] = code << 16;
    if (code == 255) continue;
    const double threshold = kSrgbThreshold[code + 1];
    auto least = static_cast<float>(threshold);
    if (static_cast<double>(least) < threshold) least = std::bit_cast<float>(std::bit_cast<std::uint32_t>(least) + 1);
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(least);
    if (bits >> 16 == kSrgbFirstBucket32 + b) entries[b] += 0x10000u - (bits & 0xffffu);
  }
  return entries;
}();

}  // namespace detail

/// srgb_encode8 of a binary32, without a branch.
constexpr std::uint8_t srgb_encode8_single(float linear) {
  const float above = linear > 0x1p-13f ? linear : 0x1p-13f;  // NaN too
  const float within = above < 0x1.fffffep-1f ? above : 0x1.fffffep-1f;
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(within);
  return static_cast<std::uint8_t>((detail::kSrgbEntry32[(bits >> 16) - detail::kSrgbFirstBucket32] + (bits & 0xffffu)) >> 16);
}
static_assert(kSrgbThreshold[255] < 0x1.fffffep-1, "the greatest binary32 below 1 encodes to 255");

}  // namespace aluminate::vm
