#include "shading/passes/bill.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

namespace aluminate::passes {
namespace {

// Eight lanes' masks for eight bits: 0 or all ones.
constexpr auto kLaneMasks = [] {
  std::array<std::array<std::uint32_t, 8>, 256> table{};
  for (unsigned bits = 0; bits < 256; ++bits)
    for (unsigned lane = 0; lane < 8; ++lane) table[bits][lane] = (bits >> lane & 1) ? 0xffffffffu : 0u;
  return table;
}();

void add_masked(std::uint32_t* plane, std::uint16_t lanes, std::uint32_t value) {
  for (int half = 0; half < 2; ++half) {
    const auto& mask = kLaneMasks[lanes >> 8 * half & 0xff];
    for (std::size_t lane = 0; lane < 8; ++lane)
      plane[static_cast<std::size_t>(half) * 8 + lane] += value & mask[lane];
  }
}

}  // namespace

LaneCost executed_cost(const PixelProgram& program, std::span<const std::uint32_t> lane_blocks, int lane) {
  LaneCost cost;
  for (std::size_t block = 0; block < program.cost.blocks.size(); ++block) {
    const std::uint32_t runs = lane_blocks[block * vm::kLanes + static_cast<std::size_t>(lane)];
    const cost::BlockCost& price = program.cost.blocks[block];
    cost.alu_words += runs * static_cast<std::uint32_t>(std::ceil(price.alu_words));
    cost.alu_slots += runs * static_cast<std::uint32_t>(price.alu_slots);
    cost.fetches += runs * static_cast<std::uint32_t>(price.fetches);
    cost.fetch_cyc += runs * static_cast<std::uint32_t>(std::ceil(price.fetch_cyc));
  }
  return cost;
}

TileBill::Totals& TileBill::Totals::operator+=(const Totals& other) {
  pixels += other.pixels;
  quads += other.quads;
  helper_lanes += other.helper_lanes;
  alu_words += other.alu_words;
  alu_slots += other.alu_slots;
  fetches += other.fetches;
  fetch_cyc += other.fetch_cyc;
  blended_pixels += other.blended_pixels;
  return *this;
}

TileBill::TileBill(const DrawList& list) {
  const auto add = [&](int program_index, Pass pass, bool blended) {
    const PixelProgram& program = list.pixel_programs[static_cast<std::size_t>(program_index)];
    const PathInfo& path = program.path;
    draws_.push_back({{path.alu_words, path.alu_slots, path.fetches, path.fetch_cyc},
                      pass,
                      program.straight_line,
                      blended});
  };
  for (const DrawState& draw : list.draws)
    add(draw.pixel_program, draw.pass, draw.surface == Surface::Blended);
  for (const ScreenDraw& draw : list.screen_draws) add(draw.pixel_program, draw.pass, draw.blended);
}

void TileBill::begin() {
  for (Plane* plane : {&alu_words_, &alu_slots_, &fetches_, &fetch_cyc_, &overdraw_, &helpers_})
    plane->fill(0);
}

void TileBill::billed(std::span<const raster::BilledStamp> stamps) {
  for (const raster::BilledStamp& stamp : stamps) {
    const DrawCost& draw = draws_[stamp.draw];
    Totals& totals = totals_[static_cast<std::size_t>(draw.pass)];
    const std::uint16_t shaded = raster::shaded_lanes(stamp.covered);
    const std::size_t at = static_cast<std::size_t>(stamp.stamp) * 16;
    add_masked(&overdraw_[at], stamp.covered, 1);
    add_masked(&helpers_[at], static_cast<std::uint16_t>(shaded & ~stamp.covered), 1);
    const auto covered = static_cast<std::uint64_t>(std::popcount(stamp.covered)),
               lanes = static_cast<std::uint64_t>(std::popcount(shaded));
    totals.pixels += covered;
    totals.quads += lanes / 4;
    totals.helper_lanes += lanes - covered;
    if (draw.blended) totals.blended_pixels += covered;
    if (!draw.is_static) continue;
    add_masked(&alu_words_[at], shaded, draw.lane.alu_words);
    add_masked(&alu_slots_[at], shaded, draw.lane.alu_slots);
    add_masked(&fetches_[at], shaded, draw.lane.fetches);
    add_masked(&fetch_cyc_[at], shaded, draw.lane.fetch_cyc);
    totals.alu_words += lanes * draw.lane.alu_words;
    totals.alu_slots += lanes * draw.lane.alu_slots;
    totals.fetches += lanes * draw.lane.fetches;
    totals.fetch_cyc += lanes * draw.lane.fetch_cyc;
  }
}

void TileBill::add_executed(std::uint32_t draw, int x, int y, const LaneCost& cost) {
  const auto at = static_cast<std::size_t>(raster::TileView::element(x, y));
  alu_words_[at] += cost.alu_words;
  alu_slots_[at] += cost.alu_slots;
  fetches_[at] += cost.fetches;
  fetch_cyc_[at] += cost.fetch_cyc;
  Totals& totals = totals_[static_cast<std::size_t>(draws_[draw].pass)];
  totals.alu_words += cost.alu_words;
  totals.alu_slots += cost.alu_slots;
  totals.fetches += cost.fetches;
  totals.fetch_cyc += cost.fetch_cyc;
}

void TileBill::store(const raster::TileView& tile, int image_width, CostPlanes& planes) const {
  const std::array<std::pair<const Plane*, std::uint32_t*>, 6> all{{{&alu_words_, planes.alu_words.data()},
                                                                   {&alu_slots_, planes.alu_slots.data()},
                                                                   {&fetches_, planes.fetches.data()},
                                                                   {&fetch_cyc_, planes.fetch_cyc.data()},
                                                                   {&overdraw_, planes.overdraw.data()},
                                                                   {&helpers_, planes.helpers.data()}}};
  const auto width = static_cast<std::size_t>(image_width);
  const auto copy_stamp = [&](int x, int y) {  // rows of four pixels: the upper or lower halves of two quads
    const auto from = static_cast<std::size_t>(raster::TileView::element(x, y));
    const std::size_t to = static_cast<std::size_t>(tile.origin.y + y) * width + static_cast<std::size_t>(tile.origin.x + x);
    for (const auto& [plane, image] : all)
      for (std::size_t row = 0; row < 4; ++row) {
        const std::uint32_t* quads = &(*plane)[from + 8 * (row / 2) + 2 * (row % 2)];
        std::memcpy(image + to + row * width, quads, 8);
        std::memcpy(image + to + row * width + 2, quads + 4, 8);
      }
  };
  // At the picture's edge. One more row and column than the picture where its size is odd: helper lanes out there belong
  // to their quad's pixel.
  const auto add_quad = [&](int x, int y) {
    const auto from = static_cast<std::size_t>(raster::TileView::element(x, y));  // lanes (0,0) (1,0) (0,1) (1,1)
    const std::size_t to = static_cast<std::size_t>(tile.origin.y + y) * width + static_cast<std::size_t>(tile.origin.x + x);
    const std::size_t right = x + 1 < tile.width ? 1 : 0, below = y + 1 < tile.height ? width : 0;
    for (const auto& [plane, image] : all) {
      const std::uint32_t* lane = &(*plane)[from];
      for (const std::size_t pixel : {to, to + right, to + below, to + right + below}) image[pixel] = 0;
      image[to] += lane[0];
      image[to + right] += lane[1];
      image[to + below] += lane[2];
      image[to + right + below] += lane[3];
    }
  };
  for (int y = 0; y < tile.height; y += 4)
    for (int x = 0; x < tile.width; x += 4) {
      if (x + 4 <= tile.width && y + 4 <= tile.height) {
        copy_stamp(x, y);
        continue;
      }
      for (int quad_y = y; quad_y < std::min(y + 4, tile.height); quad_y += 2)
        for (int quad_x = x; quad_x < std::min(x + 4, tile.width); quad_x += 2) add_quad(quad_x, quad_y);
    }
}

}  // namespace aluminate::passes
