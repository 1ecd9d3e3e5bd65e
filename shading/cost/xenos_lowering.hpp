// From a block of the shared instruction set to what the period Xenos compiler scheduled: copies forwarded,
// multiplies by two turned into adds, squares folded into dp2add, results written straight to the export
// registers, independent scalars packed into spare lanes. Values stay what they were up to the rounding of
// regrouped sums (tested by executing the scheduled words). Rules and their evidence: docs/cost_model.md.
#pragma once

#include "shading/cost/xenos_graph.hpp"
#include "shading/vm/program.hpp"

#include <array>
#include <vector>

namespace aluminate::cost {

/// Temp components that carry a value from one block to another: bit c of [temp] = component c.
std::vector<std::uint8_t> components_across_blocks(const vm::Program& program,
                                                   const std::vector<vm::Block>& blocks);

/// How hard rule 9 packs independent operations into spare lanes. The scheduler tries each and keeps the
/// shortest.
enum class Packing : std::uint8_t { Off, OffCriticalPath, Everything };

Graph lower_block(const vm::Program& program, const vm::Block& block, const std::vector<std::uint8_t>& homes,
                  Packing packing);

}  // namespace aluminate::cost
