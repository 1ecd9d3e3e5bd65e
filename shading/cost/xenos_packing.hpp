// Rule 9: independent operations that would each take a vector lane share one 4-wide operation when their
// operands can be placed in the same registers. Also the graph walks that packing and ordering need.
#pragma once

#include "shading/cost/xenos_graph.hpp"
#include "shading/cost/xenos_lowering.hpp"

#include <vector>

namespace aluminate::cost {

void pack_lanes(Graph& graph, Packing packing);

/// Longest chain of ALU words that ends in (depth) and starts with (height) each node, both counting the node
/// itself; fetches and effects of fetch words count nothing. Removed nodes get 0.
struct ChainLengths {
  std::vector<int> depth, height;
  int longest = 0;
};
/// member: parallel to the nodes; others count nothing. null: all count.
ChainLengths chain_lengths(const Graph& graph, const std::vector<bool>* member = nullptr);

/// A node that writes a Home and lies on a cycle of dependencies and write-after-read orders; -1 when there
/// is no cycle.
int home_writer_on_cycle(const Graph& graph);

/// True when a one-component operation fits the scalar half by itself: one register, or a constant and a
/// register (rule 2). With a false answer an addition or product can still take two slots (rule 3).
bool fits_scalar_half(const Graph& graph, const Node& node);

}  // namespace aluminate::cost
