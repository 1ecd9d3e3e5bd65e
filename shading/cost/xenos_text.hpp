// Scheduled Xenos words as listing rows: physical registers, the movs/_prev pairs, exports. Text only.
#pragma once

#include "shading/cost/static_cost.hpp"
#include "shading/cost/xenos_registers.hpp"

#include <vector>

namespace aluminate::cost {

std::vector<ListingRow> xenos_rows(const vm::Program& program, int block_index, const ScheduledBlock& block,
                                   const RegisterMap& map);

/// Rows of a first-fit model: unit names, and the operations as the program writes them.
std::vector<ListingRow> program_rows(const vm::Program& program, int block_index, const Graph& graph,
                                     int node, int word, const std::string& unit);

}  // namespace aluminate::cost
