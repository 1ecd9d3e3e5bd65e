// Depth test, visibility and bill of the stamps of one opaque triangle.
#if defined(ALUMINATE_OPAQUE_STAMPS) == defined(HWY_TARGET_TOGGLE)
#ifdef ALUMINATE_OPAQUE_STAMPS
#undef ALUMINATE_OPAQUE_STAMPS
#else
#define ALUMINATE_OPAQUE_STAMPS
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "rasterizer/stamp_lanes-inl.hpp"
#include "rasterizer/triangle_walk-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace aluminate::raster::HWY_NAMESPACE {
/// Depth of 16 lanes (canonical.hpp).
template <int kSamples>
struct StampDepth {
  Vector16 offset;      // i gx + j gy
  Vector low, high;
  std::uint64_t to_sample[kSamples];
  HWY_INLINE explicit StampDepth(const DepthSteps& steps)
      : offset(lane_plane(static_cast<std::int32_t>(steps.lane_x), static_cast<std::int32_t>(steps.lane_y))),
        low(hn::Set(kTag, steps.z_min)),
        high(hn::Set(kTag, steps.z_max)) {
    for (int s = 0; s < kSamples; ++s) to_sample[s] = sample_plane<kSamples>(steps, s);
  }
  HWY_INLINE std::uint32_t anchor(std::uint64_t plane, int sample) const { return anchor_of(plane + to_sample[sample]); }
  HWY_INLINE Vector at(std::uint32_t anchor, std::size_t p) const {
    const Vector z = hn::ShiftRight<kStampDepthBits>(hn::Add(hn::Set(kTag, static_cast<std::int32_t>(anchor)), offset.part[p]));
    return hn::Min(hn::Max(z, low), high);
  }
};

/// Depth at the centre of one lane of a stamp, plane being P at the centre of its first pixel: the same definition.
HWY_INLINE std::uint32_t pixel_depth(const DepthSteps& steps, std::uint64_t plane, int lane) {
  const std::uint32_t z7 = anchor_of(plane) + steps.lane_x * static_cast<std::uint32_t>(lane_x(lane)) + steps.lane_y * static_cast<std::uint32_t>(lane_y(lane));
  const std::int32_t z = static_cast<std::int32_t>(z7) >> kStampDepthBits;
  return static_cast<std::uint32_t>(std::clamp(z, steps.z_min, steps.z_max));
}

/// Whether depth `nearest` lies before the stored maximum of the bill's block: decides a stamp none of whose samples passes.
template <int kSamples>
HWY_INLINE bool passes_block(const TileMemory& tile, const BillRule& rule, int stamp, std::uint32_t nearest) {
  const int log2_stamps = rule.block_px == 4 ? 0 : rule.block_px == 8 ? 2 : 4;
  const int first = stamp >> log2_stamps << log2_stamps;
  return nearest < max_of_depths(tile.depth + first * 16 * kSamples, kSamples << log2_stamps);
}

/// Draws the stamps of one opaque record.
template <int kSamples, BillRule::Kind kBill>
struct OpaqueStamps {
  using Kind = BillRule::Kind;
  using Covered = Coverage<kSamples>;
  TileMemory& tile;
  const SetupTriangle& record;
  const KernelOptions& options;
  BillBuffer& bill;
  StampDepth<kSamples> depth;
  Vector id;

  HWY_INLINE OpaqueStamps(TileMemory& t, const SetupTriangle& r, const DepthSteps& steps, const KernelOptions& o, BillBuffer& b)
      : tile(t), record(r), options(o), bill(b), depth(steps), id(hn::Set(kTag, static_cast<std::int32_t>(r.id))) {}

  HWY_INLINE void record_bill(int stamp, std::uint32_t lanes) {
    bill.stamps[bill.count++] = {record.draw(), static_cast<std::uint16_t>(lanes), static_cast<std::uint8_t>(stamp)};
  }
  HWY_INLINE void count_writes(int stamp, std::uint32_t samples) {
    tile.block_writes[stamp >> 4] += samples;
    tile.tile_writes += samples;
  }

  HWY_INLINE void all(int stamp, std::uint64_t plane) { count_writes(stamp, draw<true>(stamp, everything<kSamples>(), plane)); }
  HWY_INLINE void some(int stamp, const Covered& covered, std::uint64_t plane) { count_writes(stamp, draw<false>(stamp, covered, plane)); }
  HWY_INLINE void block(int number, std::uint64_t plane, const std::uint64_t* offsets) {
    const Covered every = everything<kSamples>();
    std::uint32_t written = 0;
    for (int i = 0; i < 16; ++i) written += draw<true>(number << 4 | i, every, plane + offsets[i]);
    count_writes(number << 4, written);
  }

  /// Returns the number of samples written, or more (it decides when maxima are recomputed, nothing else).
  template <bool kAll>
  HWY_INLINE std::uint32_t draw(int stamp, const Covered& covered, std::uint64_t plane) {
    auto* stored = reinterpret_cast<std::int32_t*>(tile.depth) + stamp * 16 * kSamples;
    auto* visible = reinterpret_cast<std::int32_t*>(tile.visibility) + stamp * 16 * kSamples;
    // One sample: stores cost less than branches. A stamp covered whole is written whole or, mostly, not at all: whether any
    // lane passes is all that has to be known unless the bill wants each.
    constexpr bool kBranch = kSamples > 1, kEachLane = !kAll || kBranch || kBill == Kind::PerPixel;
    std::uint32_t pass[kSamples], any_pass = 0;
    Vector16 z[kSamples], old[kSamples];
    Vector nearer[kSamples][kParts];  // below 0 where the sample passes: depths have 24 bits, differences do not overflow
    for (int s = 0; s < kSamples; ++s) {
      pass[s] = 0;
      const std::uint32_t anchor = depth.anchor(plane, s);
      Vector any = hn::Zero(kTag);
      for (std::size_t p = 0; p < kParts; ++p) {
        z[s].part[p] = depth.at(anchor, p);
        old[s].part[p] = hn::Load(kTag, stored + s * 16 + p * kLanes);
        nearer[s][p] = hn::Sub(z[s].part[p], old[s].part[p]);
        if constexpr (!kAll) nearer[s][p] = hn::AndNot(covered.outside[s][p], nearer[s][p]);
        if constexpr (kEachLane) pass[s] |= sign_bits(nearer[s][p], p);
        else any = hn::Or(any, nearer[s][p]);
      }
      if constexpr (!kEachLane) pass[s] = sign_bits(any, 0) != 0 ? 0xffff : 0;
      any_pass |= pass[s];
      if constexpr (!kBranch) {
        for (std::size_t p = 0; p < kParts; ++p) {
          const Vector seen = hn::Load(kTag, visible + p * kLanes);
          hn::Store(kAll ? hn::Min(z[s].part[p], old[s].part[p]) : hn::IfNegativeThenElse(nearer[s][p], z[s].part[p], old[s].part[p]), kTag, stored + p * kLanes);
          hn::Store(hn::IfNegativeThenElse(nearer[s][p], id, seen), kTag, visible + p * kLanes);
        }
      }
    }
    if constexpr (kBill == Kind::Everything) {
      const std::uint32_t lanes = covered.any & tile.inside[stamp];
      if (lanes != 0) record_bill(stamp, lanes);
    } else if constexpr (kBill == Kind::PerPixel) {
      if (any_pass != 0) record_bill(stamp, any_pass);
    } else if constexpr (kBill == Kind::Hierarchical) {
      std::uint32_t lanes = covered.any & tile.inside[stamp];
      if constexpr (kSamples > 1) {
        if (options.bill.block_px == 2) lanes = quads_that_reach(stamp, z, covered, lanes, any_pass);
        else if (any_pass == 0 && lanes != 0 && !reaches_block(stamp, z, covered, lanes)) lanes = 0;
        if (lanes != 0) record_bill(stamp, lanes);
      } else {
        // A pixel that passes is nearer than the block's maximum; otherwise the maximum has to be known.
        if (any_pass != 0 || (lanes != 0 && reaches_block(stamp, z, covered, lanes))) record_bill(stamp, lanes);
      }
    }
    if constexpr (!kBranch) return static_cast<std::uint32_t>(std::popcount(any_pass));
    if (any_pass == 0) return 0;
    std::uint32_t written = 0;
    for (int s = 0; s < kSamples; ++s) {
      if (pass[s] == 0) continue;
      if (pass[s] == 0xffff) {
        for (std::size_t p = 0; p < kParts; ++p) {
          hn::Store(z[s].part[p], kTag, stored + s * 16 + p * kLanes);
          hn::Store(id, kTag, visible + s * 16 + p * kLanes);
        }
        written += 16;
        continue;
      }
      for (std::size_t p = 0; p < kParts; ++p) {
        // Whole stores: the next triangle's load can be forwarded from them, from masked ones it cannot.
        hn::Store(hn::IfNegativeThenElse(nearer[s][p], z[s].part[p], old[s].part[p]), kTag, stored + s * 16 + p * kLanes);
        hn::Store(hn::IfNegativeThenElse(nearer[s][p], id, hn::Load(kTag, visible + s * 16 + p * kLanes)), kTag, visible + s * 16 + p * kLanes);
      }
      written += static_cast<std::uint32_t>(std::popcount(pass[s]));
    }
    return written;
  }

  /// The nearest covered sample of `lanes`.
  HWY_INLINE std::uint32_t nearest_of(const Vector16 (&z)[kSamples], const Covered& covered, std::uint32_t lanes) const {
    alignas(64) std::uint32_t lane_depth[16];
    std::uint32_t nearest = kDepthMax;
    for (int s = 0; s < kSamples; ++s) {
      for (std::size_t p = 0; p < kParts; ++p) hn::Store(z[s].part[p], kTag, reinterpret_cast<std::int32_t*>(lane_depth) + p * kLanes);
      for (std::uint32_t left = lanes & covered.bits[s]; left != 0; left &= left - 1) nearest = std::min(nearest, lane_depth[std::countr_zero(left)]);
    }
    return nearest;
  }

  HWY_INLINE bool reaches_block(int stamp, const Vector16 (&z)[kSamples], const Covered& covered, std::uint32_t lanes) const {
    return passes_block<kSamples>(tile, options.bill, stamp, nearest_of(z, covered, lanes));
  }

  /// With a block for each quad: the lanes of the quads that are not dropped.
  HWY_INLINE std::uint32_t quads_that_reach(int stamp, const Vector16 (&z)[kSamples], const Covered& covered, std::uint32_t lanes, std::uint32_t passing) const {
    std::uint32_t kept = 0;
    for (std::uint32_t quad = 0xf; quad <= 0xf000; quad <<= 4) {
      if ((lanes & quad) == 0) continue;
      if ((passing & quad) == 0) {
        std::uint32_t farthest = 0;
        for (int s = 0; s < kSamples; ++s)
          for (std::uint32_t left = quad; left != 0; left &= left - 1)
            farthest = std::max(farthest, tile.depth[(stamp * kSamples + s) * 16 + std::countr_zero(left)]);
        if (nearest_of(z, covered, lanes & quad) >= farthest) continue;
      }
      kept |= lanes & quad;
    }
    return kept;
  }
};

/// The same for a record of one covered pixel (x, y) of the tile, with one sample. steps begin at the pixel's stamp.
template <BillRule::Kind kBill>
HWY_INLINE void draw_single_pixel(TileMemory& tile, const SetupTriangle& record, const DepthSteps& steps, int x, int y, const KernelOptions& options,
                                  BillBuffer& bill) {
  using Kind = BillRule::Kind;
  const int stamp = stamp_at(x, y), lane = lane_of(x, y);
  const std::uint32_t z = pixel_depth(steps, steps.origin, lane), element = static_cast<std::uint32_t>(stamp * 16 + lane);
  const bool nearer = z < tile.depth[element];
  const bool billed = kBill == Kind::Everything || (kBill == Kind::PerPixel && nearer) ||
                      (kBill == Kind::Hierarchical && (nearer || passes_block<1>(tile, options.bill, stamp, z)));
  if (billed) bill.stamps[bill.count++] = {record.draw(), static_cast<std::uint16_t>(1u << lane), static_cast<std::uint8_t>(stamp)};
  if (!nearer) return;
  tile.depth[element] = z;
  tile.visibility[element] = record.id;
  ++tile.block_writes[stamp >> 4];
  ++tile.tile_writes;
}

}  // namespace aluminate::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
