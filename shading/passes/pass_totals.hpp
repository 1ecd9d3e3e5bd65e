// Totals of each pass of a frame for the console's bill. In: what the tiles billed, vertices and triangles,
// the light plan. Out: PassTotals of the passes that ran, in order.
#pragma once

#include <array>
#include <vector>

#include "shading/passes/bill.hpp"
#include "shading/passes/prepared.hpp"

namespace aluminate::passes {

std::vector<PassTotals> pass_totals(const PreparedFrame& prepared,
                                    const std::array<TileBill::Totals, kPassCount>& bill, int width,
                                    int height);

}  // namespace aluminate::passes
