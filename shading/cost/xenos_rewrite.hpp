// The period compiler's idioms on a block's graph: what it folds, where it writes exports, what it packs, and
// the copies that remain because an operand must come from one register. Used by lower_block only.
#pragma once

#include "shading/cost/xenos_graph.hpp"
#include "shading/cost/xenos_lowering.hpp"

namespace aluminate::cost {

/// A component that leaves the block: to an output (exports) or to a temp other blocks read (homes).
struct Leaving {
  std::uint16_t index = 0;
  std::uint8_t component = 0;
  Ref ref{};
  bool negate = false, absolute = false;
  std::uint32_t origin = 0;
};

struct BlockResults {
  Graph graph;
  std::vector<Leaving> exports, homes;
};

Graph rewrite_block(BlockResults results, Packing packing);

inline Ref node_ref(int node, int lane) {
  Ref ref;
  ref.kind = Ref::Kind::Node;
  ref.index = static_cast<std::uint32_t>(node);
  ref.component = static_cast<std::uint8_t>(lane);
  return ref;
}

/// Keeps the first of lanes that compute the same thing; returns the new lane of each of the `count` old ones
/// and sets width and operand counts.
std::array<int, 4> drop_equal_lanes(Node& node, int count);

/// Whether an instruction reads lane 0..3 of a source, by its write mask or the operation's fixed width.
bool reads_lane(const vm::Program& program, const vm::Instruction& instruction, int source, int lane);

/// Where a component lives once registers exist. Two refs with the same place can be one operand. Value
/// results have the place of their group; literals all share one place, since an assembler may lay out
/// constants as it likes.
struct Place {
  int kind = 0;  // 0 value group, 1 input, 2 home, 3 constant, 4 literal, 5 loop counter
  std::uint32_t index = 0;
  vm::Relative relative{};
  vm::RegisterFile file = vm::RegisterFile::Uniform;
  int address_node = -1;
  bool operator==(const Place&) const = default;
};
Place place_of(const Graph& graph, const Ref& ref);

/// True when both refs are, or after merging their groups can be, in one register; merges in `groups`.
bool share_register(const Graph& graph, RegisterGroups& groups, const Ref& a, const Ref& b);

/// Distinct constant registers an operation reads; literals count as one for each started four values.
int constant_registers(const Graph& graph, const Node* a, const Node* b = nullptr);

/// The same for many questions about one graph that no longer changes: constants are numbered once.
class ConstantUse {
 public:
  explicit ConstantUse(const Graph& graph);
  /// constant_registers(graph, a, b) by node; -1 = none.
  int registers(int a, int b) const;

 private:
  struct Reads {  // ascending numbers
    std::vector<int> places, literals;
  };
  std::vector<Reads> reads_;
};

}  // namespace aluminate::cost
