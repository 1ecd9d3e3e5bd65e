#include "rasterizer/tile_kernel.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rasterizer/tile_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "rasterizer/opaque_stamps-inl.hpp"
#include "rasterizer/small_triangles-inl.hpp"
#include "rasterizer/triangle_walk-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace aluminate::raster::HWY_NAMESPACE {
/// Draws one record of any size.
template <int kSamples, BillRule::Kind kBill>
HWY_INLINE void draw_record(TileMemory& tile, const SetupTriangle& t, const KernelOptions& options, BillBuffer& bill, HizCounters& counters) {
  if (options.tile_hiz) {
    refresh_tile<kSamples>(tile, t.z_min);
    if (t.z_min >= tile.tile_max) {
      ++counters.tile;
      return;
    }
  }
  Walk<kSamples> walk{t, {}, {}, {}, {}, 0, 0, 0, 0};
  if (!bound(tile, t, walk)) return;
  if (walk.x0 == walk.x1 && walk.y0 == walk.y1 && !covers_pixel<kSamples>(t, tile.origin.x + walk.x0, tile.origin.y + walk.y0)) return;
  walk.steps = depth_steps(t, tile.origin);
  OpaqueStamps<kSamples, kBill> emit(tile, t, walk.steps, options, bill);
  walk_stamps(tile, walk, options.block_hiz, options.bill.block_px > kStampPx, counters.block, emit);
}

template <int kSamples, BillRule::Kind kBill>
void draw_records(TileMemory& tile, const SetupTriangle* records, std::size_t count, const KernelOptions& options,
                  BillBuffer& bill, HizCounters& counters) {
  const auto make_room = [&bill] {
    if constexpr (kBill != BillRule::Kind::Off)
      if (bill.count > BillBuffer::kCapacity - kStampsPerTile) bill.flush();
  };
  // A bill with large blocks wants stamps in ascending order, which small triangles do not keep to.
  if (kSamples > 1 || (kBill == BillRule::Kind::Hierarchical && options.bill.block_px > kStampPx)) {
    for (const SetupTriangle* t = records; t != records + count; ++t) {
      if (t->culled()) continue;
      make_room();
      draw_record<kSamples, kBill>(tile, *t, options, bill, counters);
    }
    return;
  }
  if constexpr (kSamples == 1) {
    SmallGroup group;
    for (std::size_t first = 0; first < count; first += kSmallGroup) {
      prepare_group(tile, records + first, std::min(kSmallGroup, count - first), options.tile_hiz, group);
      counters.tile += static_cast<std::uint64_t>(std::popcount(group.hidden));
      for (std::uint32_t left = group.live; left != 0; left &= left - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(left));
        make_room();
        if ((group.large >> i & 1) != 0) draw_record<1, kBill>(tile, *group.record[i], options, bill, counters);
        else if (group.single >> i & 1) draw_single<kBill>(tile, group, i, options, bill);
        else draw_stamps<kBill>(tile, group, i, options, bill, counters.block);
      }
    }
  }
}

/// Collects the stamps of one in-order record.
template <int kSamples>
struct CollectStamps {
  const TileMemory& tile;
  StampFragments& fragments;
  StampDepth<kSamples> depth;

  HWY_INLINE CollectStamps(const TileMemory& t, const Walk<kSamples>& w, StampFragments& f) : tile(t), fragments(f), depth(w.steps) {}
  HWY_INLINE void all(int stamp, std::uint64_t plane) { add(stamp, everything<kSamples>(), plane); }
  HWY_INLINE void some(int stamp, const Coverage<kSamples>& covered, std::uint64_t plane) { add(stamp, covered, plane); }
  HWY_INLINE void block(int number, std::uint64_t plane, const std::uint64_t* offsets) {
    for (int i = 0; i < 16; ++i) add(number << 4 | i, everything<kSamples>(), plane + offsets[i]);
  }
  HWY_INLINE void add(int stamp, const Coverage<kSamples>& covered, std::uint64_t plane) {
    if ((covered.any & tile.inside[stamp]) == 0) return;
    const int n = fragments.count++;
    fragments.stamp[n] = static_cast<std::uint8_t>(stamp);
    for (int s = 0; s < kSamples; ++s) {
      fragments.covered[n * kSamples + s] = static_cast<std::uint16_t>(covered.bits[s] & tile.inside[stamp]);
      const std::uint32_t anchor = depth.anchor(plane, s);
      for (std::size_t p = 0; p < kParts; ++p)
        hn::Store(depth.at(anchor, p), kTag, reinterpret_cast<std::int32_t*>(fragments.depth[n * kSamples + s]) + p * kLanes);
    }
  }
};

void Clear(TileMemory& tile, std::size_t elements) {
  const Vector depth = hn::Set(kTag, static_cast<std::int32_t>(kDepthMax)), none = hn::Set(kTag, static_cast<std::int32_t>(kNoTriangle));
  for (std::size_t i = 0; i < elements; i += kLanes) {
    hn::Store(depth, kTag, reinterpret_cast<std::int32_t*>(tile.depth) + i);
    hn::Store(none, kTag, reinterpret_cast<std::int32_t*>(tile.visibility) + i);
  }
}

template <int kSamples>
void draw_opaque(TileMemory& tile, const SetupTriangle* records, std::size_t count, const KernelOptions& options,
                 BillBuffer& bill, HizCounters& counters) {
  using Kind = BillRule::Kind;
  switch (options.bill.kind) {
    case Kind::Off: return draw_records<kSamples, Kind::Off>(tile, records, count, options, bill, counters);
    case Kind::Everything: return draw_records<kSamples, Kind::Everything>(tile, records, count, options, bill, counters);
    case Kind::Hierarchical: return draw_records<kSamples, Kind::Hierarchical>(tile, records, count, options, bill, counters);
    case Kind::PerPixel: return draw_records<kSamples, Kind::PerPixel>(tile, records, count, options, bill, counters);
  }
}

bool Hides(TileMemory& tile, std::uint32_t z_min, int samples) {
  if (samples == 1) refresh_tile<1>(tile, z_min);
  else refresh_tile<4>(tile, z_min);
  return z_min >= tile.tile_max;
}

void DrawOpaque(TileMemory& tile, const SetupTriangle* records, std::size_t count, const KernelOptions& options,
                BillBuffer& bill, HizCounters& counters) {
  (options.samples == 1 ? draw_opaque<1> : draw_opaque<4>)(tile, records, count, options, bill, counters);
}

template <int kSamples>
void find(TileMemory& tile, const SetupTriangle& record, const KernelOptions& options, StampFragments& fragments,
          HizCounters& counters) {
  fragments.count = 0;
  if (record.culled()) return;
  if (options.tile_hiz) {
    refresh_tile<kSamples>(tile, record.z_min);
    if (record.z_min >= tile.tile_max) {
      ++counters.tile;
      return;
    }
  }
  Walk<kSamples> walk{record, {}, {}, {}, {}, 0, 0, 0, 0};
  if (!bound(tile, record, walk)) return;
  walk.steps = depth_steps(record, tile.origin);
  CollectStamps<kSamples> emit(tile, walk, fragments);
  walk_stamps(tile, walk, options.block_hiz, options.bill.block_px > kStampPx, counters.block, emit);
}

void FindFragments(TileMemory& tile, const SetupTriangle& record, const KernelOptions& options, StampFragments& fragments,
                   HizCounters& counters) {
  (options.samples == 1 ? find<1> : find<4>)(tile, record, options, fragments, counters);
}

}  // namespace aluminate::raster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace aluminate::raster {

HWY_EXPORT(Clear);
HWY_EXPORT(DrawOpaque);
HWY_EXPORT(Hides);
HWY_EXPORT(FindFragments);

void clear_tile(TileMemory& tile, int samples) {
  HWY_DYNAMIC_DISPATCH(Clear)(tile, static_cast<std::size_t>(samples) * kTilePixels);
}

bool tile_hides(TileMemory& tile, std::uint32_t z_min, int samples) { return HWY_DYNAMIC_DISPATCH(Hides)(tile, z_min, samples); }

void draw_opaque_records(TileMemory& tile, const SetupTriangle* records, std::size_t count, const KernelOptions& options,
                         BillBuffer& bill, HizCounters& counters) {
  HWY_DYNAMIC_DISPATCH(DrawOpaque)(tile, records, count, options, bill, counters);
}

void find_fragments(TileMemory& tile, const SetupTriangle& record, const KernelOptions& options, StampFragments& fragments,
                    HizCounters& counters) {
  HWY_DYNAMIC_DISPATCH(FindFragments)(tile, record, options, fragments, counters);
}

}  // namespace aluminate::raster
#endif