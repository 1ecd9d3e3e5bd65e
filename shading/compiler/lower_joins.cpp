// Joins: blocks that several edges lead to. Their phis become variables, and every edge copies into them.
#include "shading/compiler/lowerer.hpp"

#include <spirv/unified1/spirv.hpp11>

#include <algorithm>

namespace aluminate::compiler {
namespace {

spv::Op op_of(const SpirvInstruction& i) { return static_cast<spv::Op>(i.op); }

}  // namespace
// ---------------------------------------------------------------------------------------------------------

void Lowerer::open_join(SpvId label) {
  Join join;
  for (const SpirvInstruction& i : m_.block(label).code) {
    if (op_of(i) != spv::Op::OpPhi) break;
    const std::uint32_t scalars = m_.scalar_count(i.type);
    hold(i, scalars);
    std::vector<NodeId> nodes;
    for (std::uint32_t first = 0; first < scalars; first += 4)
      nodes.push_back(b_.variable(static_cast<int>(std::min(4u, scalars - first))));
    join.phis.push_back(i.result);
    join.variables.push_back(std::move(nodes));
  }
  joins_[label] = std::move(join);
}

std::vector<std::pair<NodeId, Lanes>> Lowerer::edge_copies(SpvId from, SpvId to) {
  std::vector<std::pair<NodeId, Lanes>> copies;
  auto join = joins_.find(to);
  if (join == joins_.end()) return copies;
  for (std::size_t k = 0; k < join->second.phis.size(); ++k) {
    const SpirvInstruction& phi = *m_.definition(join->second.phis[k]);
    for (std::size_t o = 0; o + 1 < phi.operands.size(); o += 2) {
      if (phi.operands[o + 1] != from) continue;
      if (op_of(*m_.definition(phi.operands[o])) == spv::Op::OpUndef) break;
      const Tuple v = value(phi.operands[o]);
      for (std::size_t first = 0; first < v.size(); first += 4) {
        Lanes part;
        for (std::size_t c = first; c < std::min(first + 4, v.size()); ++c) part.push(v[c]);
        const NodeId target = join->second.variables[k][first / 4];
        bool same = true;  // a value that already lies in its variable
        for (int c = 0; c < part.size; ++c)
          same = same && part[c] == Ref{target, static_cast<std::uint8_t>(c), false, false};
        if (!same) copies.emplace_back(target, part);
      }
      break;
    }
  }
  return copies;
}

bool Lowerer::edge_is_empty(SpvId from, SpvId to) { return edge_copies(from, to).empty(); }

// All sources are read before any variable is written.
void Lowerer::parallel_copy(const std::vector<std::pair<NodeId, Lanes>>& copies) {
  std::vector<std::pair<NodeId, Lanes>> pending = copies;
  std::set<NodeId> targets;
  for (const auto& [target, v] : pending) targets.insert(target);
  while (!pending.empty()) {
    // A copy may go first when no other pending copy still reads its target.
    auto ready = std::find_if(pending.begin(), pending.end(), [&](const auto& c) {
      return std::none_of(pending.begin(), pending.end(), [&](const auto& other) {
        return &other != &c && std::any_of(other.second.begin(), other.second.end(),
                                           [&](Ref r) { return r.node == c.first; });
      });
    });
    if (ready == pending.end()) {  // a cycle: save one value
      const NodeId saved = pending.front().first;
      Lanes whole;
      for (std::uint8_t k = 0; k < out_.ir.nodes[saved].width; ++k) whole.push({saved, k});
      const Lanes copy = b_.snapshot(whole);
      for (auto& [target, v] : pending)
        for (Ref& r : v)
          if (r.node == saved) r = {copy[r.lane].node, copy[r.lane].lane, r.negate, r.absolute};
      continue;
    }
    b_.write(Sink::Variable, ready->first, ready->second, {0, 1, 2, 3});
    pending.erase(ready);
  }
}

void Lowerer::edge(SpvId from, SpvId to) { parallel_copy(edge_copies(from, to)); }

// Gives the phis of a block their values: variables when several edges were joined, else what comes over this
// edge.
void Lowerer::enter_block(SpvId pred, SpvId label) {
  std::vector<std::pair<SpvId, Tuple>> incoming;
  auto join = joins_.find(label);
  if (join != joins_.end()) {
    for (std::size_t k = 0; k < join->second.phis.size(); ++k) {
      Tuple v;
      for (NodeId node : join->second.variables[k])
        for (std::uint8_t c = 0; c < out_.ir.nodes[node].width; ++c) v.push_back({node, c});
      incoming.emplace_back(join->second.phis[k], std::move(v));
    }
    if (!open_loops_.contains(label)) joins_.erase(join);  // a header's is written again on the back edge
  } else {
    for (const SpirvInstruction& i : m_.block(label).code) {
      if (op_of(i) != spv::Op::OpPhi) break;
      for (std::size_t o = 0; o + 1 < i.operands.size(); o += 2)
        if (i.operands[o + 1] == pred) incoming.emplace_back(i.result, value(i.operands[o]));
    }
  }
  for (auto& [id, v] : incoming) values_[id] = std::move(v);
}

}  // namespace aluminate::compiler
