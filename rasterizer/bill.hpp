// The console's bill: which quads of which triangle the console would have shaded, in submission order, whatever this
// program skips. Events arrive per 4x4 stamp; the passes layer adds its static costs per pixel. Hidden fragments are
// billed without being executed. The bill never depends on skips, threads, tile order or the vector unit.
#pragma once

#include <cstdint>
#include <span>

#include "rasterizer/limits.hpp"

namespace aluminate::raster {

/// How the console rejects fragments before shading.
struct BillRule {
  enum class Kind : std::uint8_t {
    Off,           // no bill is made
    Everything,    // no rejection: every quad with a covered pixel is shaded
    Hierarchical,  // Xenos: a 4x4 stamp of a triangle is dropped when none of its covered samples is nearer than the farthest
                   // depth stored in the block; otherwise all its covered quads are shaded [inferred: from the 16-sample
                   // grain in [B3D] article 5, 4x4 px at one sample and 2x2 px at four; the console stores a rounded
                   // maximum, we bill with the exact one]
    PerPixel,      // RSX: full early depth test, a quad is shaded when at least one of its covered samples passes
  };
  Kind kind = Kind::Hierarchical;
  int block_px = 4;  // Hierarchical: 4, 8 or 16, at 4 samples also 2 (then quads are dropped one by one); block whose exact
                     // maximum depth (samples of the viewport only) is compared
};

/// One stamp of one triangle. covered is a set of the stamp's 16 pixels, 4 quads of 4 lanes: bit 4 quad + lane, quads and
/// lanes both in the order (0,0) (1,0) (0,1) (1,1). A quad is billed iff its nibble is not 0: its set bits are covered
/// invocations, the others helper invocations. A pixel is covered, and shaded once, when any of its samples is; under
/// PerPixel only samples that pass the depth test count.
struct BilledStamp {
  std::uint32_t draw = 0;
  std::uint16_t covered = 0;  // never 0
  std::uint8_t stamp = 0;     // see stamp_x, stamp_y
};

/// Pixel offset of a stamp inside its tile. Stamps are numbered block by block (16x16), both levels in the same order of 2x2
/// of 2x2: bit pairs of the number from the top are y1x1 y0x0 of the block, then y1x1 y0x0 of the stamp in it.
constexpr int stamp_x(int stamp) {
  return (stamp >> 6 & 1) * 32 + (stamp >> 4 & 1) * 16 + (stamp >> 2 & 1) * 8 + (stamp & 1) * 4;
}
constexpr int stamp_y(int stamp) {
  return (stamp >> 7 & 1) * 32 + (stamp >> 5 & 1) * 16 + (stamp >> 3 & 1) * 8 + (stamp >> 1 & 1) * 4;
}
/// Pixel offset of lane 0..15 of a stamp, same order.
constexpr int lane_x(int lane) { return (lane >> 2 & 1) * 2 + (lane & 1); }
constexpr int lane_y(int lane) { return (lane >> 3 & 1) * 2 + (lane >> 1 & 1); }
/// Stamp that holds pixel (x, y) of a tile, and the pixel's lane in it.
constexpr int stamp_of(int x, int y) {
  return (y >> 5 & 1) << 7 | (x >> 5 & 1) << 6 | (y >> 4 & 1) << 5 | (x >> 4 & 1) << 4 | (y >> 3 & 1) << 3 | (x >> 3 & 1) << 2 |
         (y >> 2 & 1) << 1 | (x >> 2 & 1);
}
constexpr int lane_of(int x, int y) { return (y >> 1 & 1) << 3 | (x >> 1 & 1) << 2 | (y & 1) << 1 | (x & 1); }

/// Receives the bill of a tile in submission order, several stamps at a time.
class BillSink {
 public:
  virtual ~BillSink() = default;
  virtual void billed(std::span<const BilledStamp> stamps) = 0;
};

/// Written out: the baseline instruction set has no population count, and this runs per billed stamp.
constexpr int covered_invocations(std::uint16_t covered) {
  unsigned v = covered;
  v = (v & 0x5555u) + (v >> 1 & 0x5555u);
  v = (v & 0x3333u) + (v >> 2 & 0x3333u);
  v = (v & 0x0f0fu) + (v >> 4 & 0x0f0fu);
  return static_cast<int>((v + (v >> 8)) & 0x1fu);
}
/// 4 lanes of every quad with a bit set: covered plus helper invocations.
constexpr std::uint16_t shaded_lanes(std::uint16_t covered) {
  const unsigned any = (covered | covered >> 1 | covered >> 2 | covered >> 3) & 0x1111u;
  return static_cast<std::uint16_t>(any * 0xf);
}

/// visit(draw, x, y, covered): each billed quad; x, y = tile-relative pixel of its lane 0 (even), covered = 4 lanes, not 0.
template <class Visit>
void for_each_billed_quad(std::span<const BilledStamp> stamps, Visit&& visit) {
  for (const BilledStamp& event : stamps)
    for (int quad = 0; quad < 4; ++quad)
      if (const unsigned lanes = event.covered >> 4 * quad & 0xf)
        visit(event.draw, stamp_x(event.stamp) + (quad & 1) * 2, stamp_y(event.stamp) + (quad >> 1) * 2, lanes);
}

}  // namespace aluminate::raster
