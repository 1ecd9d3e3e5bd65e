// Which fragments of the frame's draws cover one pixel, and how many of them a rule of depth rejection lets
// through: what `pixel` needs to name the draws whose fragments were never shaded. Nothing is shaded here.
#pragma once

#include <cstdint>
#include <vector>

#include "rasterizer/bill.hpp"
#include "shading/passes/prepared.hpp"

namespace aluminate::passes {

/// Draws of prepared.list.draws with a fragment at the tile-relative pixel (x, y), one entry a fragment, in
/// submission order: all of them under BillRule::Kind::Everything, those that pass the depth test as opaque
/// draws leave it under Kind::PerPixel. In-order draws are taken to keep every fragment, so PerPixel says
/// nothing about what lies behind them.
std::vector<std::uint32_t> fragments_at(const PreparedFrame& prepared, int tile, int x, int y,
                                        raster::BillRule::Kind rule);

}  // namespace aluminate::passes
