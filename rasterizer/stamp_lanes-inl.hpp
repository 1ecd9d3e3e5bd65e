// A 4x4 stamp as 16 int32 lanes: the vectors of the tile stage, for code compiled once per vector unit (the guard toggles
// with the target). Included by the other -inl files of this folder alone.
#if defined(ALUMINATE_STAMP_LANES) == defined(HWY_TARGET_TOGGLE)
#ifdef ALUMINATE_STAMP_LANES
#undef ALUMINATE_STAMP_LANES
#else
#define ALUMINATE_STAMP_LANES
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "rasterizer/bill.hpp"
#include "rasterizer/limits.hpp"
#include "rasterizer/record_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace aluminate::raster::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// 16 lanes as 1, 2 or 4 vectors.
using Tag = hn::CappedTag<std::int32_t, 16>;
using Vector = hn::Vec<Tag>;
constexpr Tag kTag;
constexpr std::size_t kLanes = hn::MaxLanes(Tag());
constexpr std::size_t kParts = 16 / kLanes;
static_assert(kParts * kLanes == 16);

struct Vector16 {
  Vector part[kParts];
};

alignas(64) constexpr std::int32_t kLaneX[16] = {0, 1, 0, 1, 2, 3, 2, 3, 0, 1, 0, 1, 2, 3, 2, 3};
alignas(64) constexpr std::int32_t kLaneY[16] = {0, 0, 1, 1, 0, 0, 1, 1, 2, 2, 3, 3, 2, 2, 3, 3};

/// Lanes below 0 of one part.
HWY_INLINE std::uint32_t sign_bits(Vector v, std::size_t part) { return mask_bits(kTag, hn::Lt(v, hn::Zero(kTag))) << (part * kLanes); }

/// x * lane_x + y * lane_y, modulo 2^32.
HWY_INLINE Vector16 lane_plane(std::int32_t x, std::int32_t y) {
  Vector16 out;
  for (std::size_t p = 0; p < kParts; ++p)
    out.part[p] = hn::Add(hn::Mul(hn::Set(kTag, x), hn::Load(kTag, kLaneX + p * kLanes)),
                          hn::Mul(hn::Set(kTag, y), hn::Load(kTag, kLaneY + p * kLanes)));
  return out;
}

/// Covered lanes of a stamp by sample, as signs and as bits.
template <int kSamples>
struct Coverage {
  Vector outside[kSamples][kParts];  // below 0 where the sample is not covered
  std::uint32_t bits[kSamples];
  std::uint32_t any;                 // lanes with a covered sample
};

/// Every sample covered; only the bits, the signs are not read then.
template <int kSamples>
HWY_INLINE Coverage<kSamples> everything() {
  Coverage<kSamples> every;
  for (std::uint32_t& bits : every.bits) bits = 0xffff;
  every.any = 0xffff;
  return every;
}

/// From the three edges at the stamp's first pixel and their steps to its lanes.
HWY_INLINE void cover(Coverage<1>& coverage, Vector a, Vector b, Vector c, const Vector16 (&lanes)[3]) {
  std::uint32_t outside = 0;
  for (std::size_t p = 0; p < kParts; ++p) {
    coverage.outside[0][p] = hn::Or(hn::Or(hn::Add(a, lanes[0].part[p]), hn::Add(b, lanes[1].part[p])), hn::Add(c, lanes[2].part[p]));
    outside |= sign_bits(coverage.outside[0][p], p);
  }
  coverage.any = coverage.bits[0] = ~outside & 0xffffu;
}

/// The stamp `lane` (x = lane_x, y = lane_y stamps) further right and down. Both numbers interleave x and y bits alike, so each is
/// added with carries passed through the other's bits.
HWY_INLINE int stamp_beyond(int stamp, int lane) {
  constexpr int kX = 0x55, kY = 0xaa;
  return (((stamp | kY) + (lane & kX)) & kX) | (((stamp | kX) + (lane & kY)) & kY);
}

/// Maximum over `count` consecutive groups of 16.
HWY_INLINE std::uint32_t max_of_depths(const std::uint32_t* depth, int count) {
  Vector most = hn::Zero(kTag);
  for (std::size_t i = 0; i < static_cast<std::size_t>(count) * kParts; ++i)
    most = hn::Max(most, hn::Load(kTag, reinterpret_cast<const std::int32_t*>(depth) + i * kLanes));
  return static_cast<std::uint32_t>(hn::GetLane(hn::MaxOfLanes(kTag, most)));
}

// Stamp number from the stamp's column and row in the tile: one or of two table entries.
struct StampNumbers {
  std::uint8_t column[16], row[16];
};
constexpr StampNumbers make_stamp_numbers() {
  StampNumbers numbers{};
  for (int i = 0; i < 16; ++i) {
    numbers.column[i] = static_cast<std::uint8_t>(stamp_of(i * kStampPx, 0));
    numbers.row[i] = static_cast<std::uint8_t>(stamp_of(0, i * kStampPx));
  }
  return numbers;
}
constexpr StampNumbers kStampNumbers = make_stamp_numbers();
HWY_INLINE int stamp_at(int x, int y) { return kStampNumbers.column[x >> 2] | kStampNumbers.row[y >> 2]; }

}  // namespace aluminate::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
