// The console's bill of one tile: what every billed quad costs, added up per pixel and per pass. In: billed
// stamps from the rasterizer, in submission order. Out: planes of the frame and exact totals; sums over
// pixels equal the totals.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "rasterizer/bill.hpp"
#include "rasterizer/tile.hpp"
#include "shading/passes/draw_list.hpp"
#include "shading/passes/frame.hpp"

namespace aluminate::passes {

/// Lane-weighted cost of one invocation.
struct LaneCost {
  std::uint32_t alu_words = 0, alu_slots = 0, fetches = 0, fetch_cyc = 0;
};

/// What one lane of a program that branches on data paid: blocks times their executions. lane_blocks:
/// [blocks][64].
LaneCost executed_cost(const PixelProgram& program, std::span<const std::uint32_t> lane_blocks, int lane);

/// One worker's tile. begin(), feed as BillSink and through add_executed(), then store().
class TileBill : public raster::BillSink {
 public:
  /// Stamps name list.draws first, then list.screen_draws.
  explicit TileBill(const DrawList& list);

  void begin();
  /// Straight-line programs: static cost for every covered and helper lane. Others: only the invocation
  /// counts; what they cost depends on data and arrives through add_executed().
  void billed(std::span<const raster::BilledStamp> stamps) override;
  /// One executed lane of a program that branches on data. x, y: tile-relative pixel.
  void add_executed(std::uint32_t draw, int x, int y, const LaneCost& cost);
  /// Writes the tile's pixels of the frame's planes. Lanes right of or below the picture go to the nearest
  /// pixel of their quad.
  void store(const raster::TileView& tile, int image_width, CostPlanes& planes) const;

  /// Since construction.
  struct Totals {
    std::uint64_t pixels = 0, quads = 0, helper_lanes = 0;
    std::uint64_t alu_words = 0, alu_slots = 0, fetches = 0, fetch_cyc = 0;
    std::uint64_t blended_pixels = 0;
    Totals& operator+=(const Totals& other);
  };
  const Totals& totals(Pass pass) const { return totals_[static_cast<std::size_t>(pass)]; }

 private:
  struct DrawCost {
    LaneCost lane;
    Pass pass = Pass::Forward;
    bool is_static = true, blended = false;
  };
  std::vector<DrawCost> draws_;
  using Plane = std::array<std::uint32_t, raster::kTilePixels>;  // stamp order
  Plane alu_words_{}, alu_slots_{}, fetches_{}, fetch_cyc_{}, overdraw_{}, helpers_{};
  std::array<Totals, kPassCount> totals_{};
};

}  // namespace aluminate::passes
