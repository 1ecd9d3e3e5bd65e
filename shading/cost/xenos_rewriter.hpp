// The rewriting of one block, step by step; private to xenos_rewrite.cpp, xenos_folding.cpp,
// xenos_leaving.cpp and xenos_operands.cpp, one file for each group of steps. Comes in: operations as the
// program names them. Goes out: operations the machine has, each operand in one register.
#pragma once

#include "shading/cost/xenos_rewrite.hpp"

#include <array>
#include <vector>

namespace aluminate::cost {

class Rewriter {
 public:
  explicit Rewriter(BlockResults results)
      : graph_(std::move(results.graph)),
        exports_(std::move(results.exports)),
        homes_(std::move(results.homes)) {}

  Graph run(Packing packing) &&;

 private:
  // Uses and dead lanes: xenos_rewrite.cpp
  template <class Visit>
  void for_each_ref(Visit&& visit) {
    for (Node& node : graph_.nodes) {
      if (node.removed) continue;
      for (std::size_t s = 0; s < static_cast<std::size_t>(node.sources); ++s) {
        for (int i = 0; i < node.src[s].count; ++i) visit(node.src[s].refs[static_cast<std::size_t>(i)]);
      }
    }
    for (Leaving& leaving : exports_) visit(leaving.ref);
    for (Leaving& leaving : homes_) visit(leaving.ref);
  }
  /// Reads of node results by operations of the block, all lanes together.
  std::vector<int> internal_uses() const;
  std::vector<int> all_uses() const;
  /// Removes operations and lanes nobody reads. Fetches lose lanes too: the fetch word masks its destination.
  void prune();
  static void mark(std::vector<std::uint8_t>& used, const Ref& ref);
  void drop_unused_lanes();
  /// Narrows a node to the lanes in `keep` and renames the reads of the others away.
  void keep_lanes(int n, std::uint8_t keep);
  static void select_fetch_lanes(Node& node, std::uint8_t keep);

  // Idioms: xenos_folding.cpp
  /// rcp(rsq(x)) and x * rsq(x) are one sqrt (rule 6).
  void fold_roots();
  /// 2 * x is x + x: no literal, and one register for the scalar half (rule 6).
  void fold_doubling();
  /// mad(a, b, mad(c, d, e)) on single components is one dp2add where both pairs can share registers (rule
  /// 6).
  void fold_dot_products();
  bool fold_pair(Node& outer, const Node& inner, bool subtract);
  Operand pair_of(const Ref& x, const Ref& y, bool negate);
  bool share(RegisterGroups& groups, const Ref& a, const Ref& b) const;

  // Results that leave the block: xenos_leaving.cpp
  /// A vector operation whose components go different ways is split: export words cannot write a register
  /// too, and the period compiler names final components apart from temporary ones.
  void split_by_destiny();
  /// A copy of node n that computes only `part`; reads of those lanes move to it. Lane numbers of n stay.
  void split_off(int n, std::uint8_t part);
  Node copy_node(const Leaving& first) const;
  static void add_lane(Node& copy, const Leaving& leaving);
  /// The last operation writes the export itself; a copy remains for fetched, constant and input components,
  /// and for the whole output when one of its computed components is read again (rule 4). 0 and 1 come free
  /// from the write masks.
  void place_exports();
  void place_output(const std::vector<Leaving>& components);
  void place_homes();
  /// Reads of a block's incoming registers stay before their overwriting. Returns false after breaking a
  /// cycle with a copy, which makes operands to be gathered again.
  bool order_home_writes();
  static bool reads_home(const Node& reader, const Node& writer);

  // Operands: xenos_operands.cpp
  /// Every operand comes from one register: results are placed together where four components suffice, copies
  /// are made where they do not, where a fetch would read a constant, and where a third constant register
  /// would be read.
  void gather_operands();
  void gather(int n, std::size_t s);
  bool same_place(const Ref& a, const Ref& b) const;
  std::vector<Ref> distinct_places(const Operand& operand) const;
  /// Copies the operand's components that live at `place`; a fetch's copy applies the modifiers too.
  int copy_of(const Operand& operand, const Ref& place, bool with_modifiers, int reader);
  /// Other operations that read the same components use the same copies; modifiers stay their own.
  void replace_operand(const Operand& before, const Operand& after, int first);
  bool is_copy_of(const Node& node, const Operand&, const Operand& after) const;
  void copy_constant(int n);

  Graph graph_;
  std::vector<Leaving> exports_, homes_;
  std::array<double, 4> free_values_{};  // what an output's free components hold
};

}  // namespace aluminate::cost
