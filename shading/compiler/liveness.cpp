#include "shading/compiler/liveness.hpp"

namespace aluminate::compiler {

using vm::Opcode;

Liveness::Liveness(const Ir& ir) {
  // Only variables, what is copied into them and copies of them matter.
  const auto track = [&](NodeId id) {
    const Node& n = ir.nodes[id];
    if (n.kind == NodeKind::Variable || (is_instruction(n) && n.sink == Sink::Value))
      bit_.try_emplace(id, static_cast<std::uint32_t>(bit_.size()));
  };
  const auto is_copy = [&](const Node& n) {
    return is_instruction(n) && n.op == Opcode::Mov && n.sink != Sink::Output;
  };
  for (NodeId id : ir.order) {
    const Node& n = ir.nodes[id];
    if (n.sink == Sink::Variable) {
      track(n.target);
      for (Ref r : n.src[0]) track(r.node);
    } else if (is_copy(n) && ir.nodes[n.src[0][0].node].kind == NodeKind::Variable) {
      track(id);
      track(n.src[0][0].node);
    }
  }
  const std::size_t size = ir.order.size(), bits = bit_.size();

  // Uses and definitions per position, successors as one lane sees them.
  std::vector<std::vector<std::uint32_t>> uses(size);
  std::vector<std::pair<std::int64_t, bool>> kills(size, {-1, false});
  std::vector<std::vector<std::size_t>> next(size);
  std::vector<std::size_t> ifs, loops;
  std::map<std::size_t, std::size_t> else_of, end_of;
  for (std::size_t p = 0; p < size; ++p) {
    const Node& n = ir.nodes[ir.order[p]];
    switch (n.op) {
      case Opcode::If:
        ifs.push_back(p);
        break;
      case Opcode::Else:
        else_of[ifs.back()] = p;
        break;
      case Opcode::EndIf:
        end_of[ifs.back()] = p;
        ifs.pop_back();
        break;
      case Opcode::Loop:
        loops.push_back(p);
        break;
      case Opcode::EndLoop:
        end_of[loops.back()] = p;
        loops.pop_back();
        break;
      default:
        break;
    }
  }
  for (std::size_t p = 0; p < size; ++p) {
    const NodeId id = ir.order[p];
    const Node& n = ir.nodes[id];
    const auto use = [&](Ref r) {
      if (auto it = bit_.find(r.node); it != bit_.end()) uses[p].push_back(it->second);
      const Node& leaf = ir.nodes[r.node];
      if (!is_instruction(leaf) && leaf.address.base == Address::Base::Value)
        if (auto it = bit_.find(leaf.address.value.node); it != bit_.end()) uses[p].push_back(it->second);
    };
    if (is_instruction(n))
      for (int k = 0; k < vm::info(n.op).sources; ++k)
        for (Ref r : n.src[static_cast<std::size_t>(k)]) use(r);
    NodeId defined = 0;
    bool whole = false;
    if (n.sink == Sink::Variable) {
      defined = n.target;
      whole = n.width == ir.nodes[n.target].width;
    } else if (n.sink == Sink::Value && bit_.contains(id)) {
      defined = id;
      whole = true;
    }
    if (whole || defined != 0) {
      kills[p] = {bit_.at(defined), whole};
      NodeId source = 0;
      if (is_copy(n)) {
        source = n.src[0][0].node;
        for (Ref r : n.src[0])
          if (r.node != source || r.negate || r.absolute) source = 0;
      }
      definitions_[defined].push_back({p, source});
    }
    const std::size_t end = p + 1;
    const auto enclosing_end = [&] {  // of the innermost loop around p
      std::size_t best = size;
      for (const auto& [begin, finish] : end_of)
        if (ir.nodes[ir.order[begin]].op == Opcode::Loop && begin < p && p < finish)
          best = std::min(best, finish);
      return best;
    };
    if (end < size) next[p].push_back(end);
    switch (n.op) {
      case Opcode::If: {
        const auto other = else_of.find(p);
        next[p].push_back(other != else_of.end() ? other->second + 1 : end_of[p]);
        break;
      }
      case Opcode::Else:
        next[p].clear();
        for (const auto& [begin, at] : else_of)
          if (at == p) next[p].push_back(end_of[begin]);
        break;
      case Opcode::EndLoop:
        for (const auto& [begin, at] : end_of)
          if (at == p) next[p].push_back(begin + 1);
        break;
      case Opcode::Break:
        if (enclosing_end() + 1 < size) next[p].push_back(enclosing_end() + 1);
        break;
      case Opcode::Continue:
        if (enclosing_end() < size) next[p].push_back(enclosing_end());
        break;
      default:
        break;
    }
  }

  live_out_.assign(size, std::vector<bool>(bits));
  std::vector<std::vector<bool>> live_in(size, std::vector<bool>(bits));
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t p = size; p-- > 0;) {
      std::vector<bool> out(bits);
      for (std::size_t s : next[p])
        for (std::size_t b = 0; b < bits; ++b)
          if (live_in[s][b]) out[b] = true;
      std::vector<bool> in = out;
      if (kills[p].first >= 0 && kills[p].second) in[static_cast<std::size_t>(kills[p].first)] = false;
      for (std::uint32_t u : uses[p]) in[u] = true;
      if (in != live_in[p]) {
        live_in[p] = std::move(in);
        changed = true;
      }
      live_out_[p] = std::move(out);
    }
  }
}

bool Liveness::live_after(NodeId id, std::size_t position) const {
  const auto it = bit_.find(id);
  return it == bit_.end() || live_out_[position][it->second];
}

bool Liveness::interfere(NodeId a, NodeId b) const {
  for (const auto& [x, y] : {std::pair(a, b), std::pair(b, a)}) {
    const auto it = definitions_.find(x);
    if (it == definitions_.end()) continue;
    for (const Definition& d : it->second)
      if (d.copy_of != y && live_after(y, d.position)) return true;
  }
  return false;
}

}  // namespace aluminate::compiler
