// Eight triangles at once, one a lane: transposing between structures in memory (16-byte pieces of vertices and records) and
// one vector per field. Included by the kernels of set-up and of the tile stage.
#if defined(ALUMINATE_RECORD_LANES) == defined(HWY_TARGET_TOGGLE)
#ifdef ALUMINATE_RECORD_LANES
#undef ALUMINATE_RECORD_LANES
#else
#define ALUMINATE_RECORD_LANES
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace aluminate::raster::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Corner = hn::CappedTag<std::int32_t, 8>;
using CornerVector = hn::Vec<Corner>;
using CornerMask = hn::Mask<Corner>;
constexpr Corner kCorner;
constexpr std::size_t kCornerLanes = hn::MaxLanes(Corner());
constexpr std::uint32_t kAllCorners = (1u << kCornerLanes) - 1;

/// At most 16 lanes.
template <class AnyTag, class AnyMask>
HWY_INLINE std::uint32_t mask_bits(AnyTag tag, AnyMask mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(tag, mask, bytes);
  if constexpr (hn::MaxLanes(AnyTag()) <= 8) return bytes[0];
  std::uint16_t bits;
  std::memcpy(&bits, bytes, sizeof bits);
  return bits;
}
HWY_INLINE std::uint32_t corner_bits(CornerMask mask) { return mask_bits(kCorner, mask); }

#if HWY_TARGET != HWY_SCALAR
/// 4x4 in each 128-bit block; its own inverse.
HWY_INLINE void transpose(CornerVector (&v)[4]) {
  const hn::RepartitionToWide<Corner> pairs;
  const auto ab01 = hn::BitCast(pairs, hn::InterleaveLower(kCorner, v[0], v[1])), cd01 = hn::BitCast(pairs, hn::InterleaveLower(kCorner, v[2], v[3]));
  const auto ab23 = hn::BitCast(pairs, hn::InterleaveUpper(kCorner, v[0], v[1])), cd23 = hn::BitCast(pairs, hn::InterleaveUpper(kCorner, v[2], v[3]));
  v[0] = hn::BitCast(kCorner, hn::InterleaveLower(pairs, ab01, cd01));
  v[1] = hn::BitCast(kCorner, hn::InterleaveUpper(pairs, ab01, cd01));
  v[2] = hn::BitCast(kCorner, hn::InterleaveLower(pairs, ab23, cd23));
  v[3] = hn::BitCast(kCorner, hn::InterleaveUpper(pairs, ab23, cd23));
}
#endif

/// field[f] = element f of the 16-byte piece that piece(lane) points at, for every lane.
template <class Piece>
HWY_INLINE void load_fields(Piece&& piece, CornerVector (&field)[4]) {
#if HWY_TARGET == HWY_SCALAR
  for (std::size_t f = 0; f < 4; ++f) field[f] = hn::Set(kCorner, piece(0)[f]);
#else
  const hn::CappedTag<std::int32_t, 4> four;
  for (std::size_t r = 0; r < 4; ++r) {
#if HWY_MAX_BYTES >= 32
    field[r] = hn::Combine(kCorner, hn::Load(four, piece(r + 4)), hn::Load(four, piece(r)));
#else
    field[r] = hn::Load(four, piece(r));
#endif
  }
  transpose(field);
#endif
}

/// The inverse, for the pieces of all lanes of several fields at once: rows[lane] are then ready to be stored.
template <std::size_t kPieces>
struct PieceRows {
  CornerVector row[kPieces][4];
  HWY_INLINE explicit PieceRows(const CornerVector (&field)[4 * kPieces]) {
    for (std::size_t piece = 0; piece < kPieces; ++piece) {
      for (std::size_t f = 0; f < 4; ++f) row[piece][f] = field[4 * piece + f];
#if HWY_TARGET != HWY_SCALAR
      transpose(row[piece]);
#endif
    }
  }
  /// to: 16-byte aligned, 4 kPieces elements.
  HWY_INLINE void store(std::size_t lane, std::int32_t* to) const {
    for (std::size_t piece = 0; piece < kPieces; ++piece) {
#if HWY_TARGET == HWY_SCALAR
      (void)lane;
      for (std::size_t f = 0; f < 4; ++f) to[4 * piece + f] = hn::GetLane(row[piece][f]);
#else
      const hn::CappedTag<std::int32_t, 4> four;
#if HWY_MAX_BYTES >= 32
      if (lane >= 4) hn::Store(hn::UpperHalf(four, row[piece][lane - 4]), four, to + 4 * piece);
      else hn::Store(hn::LowerHalf(four, row[piece][lane]), four, to + 4 * piece);
#else
      hn::Store(row[piece][lane], four, to + 4 * piece);
#endif
#endif
    }
  }
};

}  // namespace aluminate::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
