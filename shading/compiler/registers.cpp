#include "shading/compiler/register_assigner.hpp"

#include <algorithm>

namespace aluminate::compiler {

using vm::Opcode;

std::map<NodeId, Place> Assigner::run(int& register_count) {
  make_units();
  coalesce_copies();
  make_groups();
  direct_outputs();
  gather_operands();
  return places(register_count);
}

bool Assigner::has_place(NodeId id) const {
  const Node& n = ir_.nodes[id];
  return n.kind == NodeKind::Variable || (is_instruction(n) && n.sink == Sink::Value);
}

void Assigner::make_units() {
  unit_of_.assign(ir_.nodes.size(), -1);
  lanes_.assign(ir_.nodes.size(), {0, 1, 2, 3});
  const auto add = [&](NodeId id) {
    if (unit_of_[id] >= 0) return;
    unit_of_[id] = static_cast<int>(units_.size());
    units_.push_back({node(id).width, {id}, -1, {}});
  };
  for (NodeId id : ir_.order) {
    const Node& n = node(id);
    if (is_instruction(n) && n.sink == Sink::Value) add(id);
    if (n.sink == Sink::Variable) add(n.target);
    for_each_source(node(id), [&](Lanes& v) {
      for (Ref r : v)
        if (node(r.node).kind == NodeKind::Variable) add(r.node);
    });
  }
}

// True when the copy's lanes put every lane of `from` at one lane of `to`, without modifiers.
bool Assigner::plain_copy(const Lanes& value, NodeId from, const std::vector<std::uint8_t>& to_lanes,
                          std::array<int, 4>& map) const {
  map.fill(-1);
  for (int i = 0; i < value.size; ++i) {
    if (value[i].node != from) continue;
    if (value[i].negate || value[i].absolute) return false;
    if (map[value[i].lane] >= 0) return false;
    map[value[i].lane] = to_lanes[static_cast<std::size_t>(i)];
  }
  for (int l = 0; l < ir_.nodes[from].width; ++l)
    if (map[static_cast<std::size_t>(l)] < 0) return false;
  return true;
}

void Assigner::try_unite(NodeId target, NodeId from, const std::array<int, 4>& map, const Liveness& live) {
  const int t = unit_of_[target], f = unit_of_[from];
  if (t < 0 || f < 0 || t == f) return;
  if (units_[static_cast<std::size_t>(f)].width > units_[static_cast<std::size_t>(t)].width) return;
  if (units_[static_cast<std::size_t>(f)].width != node(from).width) return;
  for (NodeId m : units_[static_cast<std::size_t>(f)].members)
    if (is_texture(node(m).op) && is_instruction(node(m))) return;
  for (NodeId a : units_[static_cast<std::size_t>(t)].members)
    for (NodeId b : units_[static_cast<std::size_t>(f)].members)
      if (live.interfere(a, b)) return;
  // unit lane of `from` -> unit lane of `target`
  std::array<std::uint8_t, 4> unit_map{};
  for (int l = 0; l < node(from).width; ++l)
    unit_map[lanes_[from][static_cast<std::size_t>(l)]] =
        lanes_[target][static_cast<std::size_t>(map[static_cast<std::size_t>(l)])];
  Unit& source = units_[static_cast<std::size_t>(f)];
  for (NodeId m : source.members) {
    unit_of_[m] = t;
    for (int l = 0; l < node(m).width; ++l)
      lanes_[m][static_cast<std::size_t>(l)] = unit_map[lanes_[m][static_cast<std::size_t>(l)]];
    units_[static_cast<std::size_t>(t)].members.push_back(m);
  }
  source.members.clear();
}

void Assigner::coalesce_copies() {
  bool any = false;
  for (NodeId id : ir_.order) any = any || node(id).sink == Sink::Variable;
  if (!any) return;
  const Liveness live(ir_);
  for (NodeId id : ir_.order) {
    const Node& n = node(id);
    const bool snapshot = n.sink == Sink::Value && n.op == Opcode::Mov && !n.saturate && is_instruction(n) &&
                          node(n.src[0][0].node).kind == NodeKind::Variable;
    if (n.sink != Sink::Variable && !snapshot) continue;
    std::set<NodeId> sources;
    for (Ref r : n.src[0])
      if (has_place(r.node)) sources.insert(r.node);
    if (snapshot) {  // the snapshot may share the variable's place
      if (sources.size() != 1) continue;
      const NodeId variable = *sources.begin();
      std::array<int, 4> map{};
      bool plain = true;
      for (int i = 0; i < n.width; ++i) {
        plain = plain && !n.src[0][i].negate && !n.src[0][i].absolute;
        for (int k = 0; k < i; ++k) plain = plain && n.src[0][k].lane != n.src[0][i].lane;
        map[static_cast<std::size_t>(i)] = n.src[0][i].lane;
      }
      if (plain) try_unite(variable, id, map, live);
      continue;
    }
    std::vector<std::uint8_t> to(n.lane_to.begin(), n.lane_to.begin() + n.width);
    for (NodeId from : sources) {
      std::array<int, 4> map{};
      if (!plain_copy(n.src[0], from, to, map)) continue;
      if (is_instruction(node(from)) && node(from).loop != n.loop && node(from).loop != node(n.target).loop)
        continue;
      try_unite(n.target, from, map, live);
    }
  }
}

void Assigner::direct_outputs() {
  std::map<NodeId, int> users;
  for (NodeId id : ir_.order) {
    std::set<NodeId> read;
    for_each_source(node(id), [&](Lanes& v) {
      for (Ref r : v) read.insert(r.node);
    });
    for (NodeId r : read) ++users[r];
  }
  for (const Node& n : ir_.nodes)
    if (!is_instruction(n) && n.address.base == Address::Base::Value) users[n.address.value.node] += 2;
  for (NodeId id : ir_.order) {
    const Node& n = node(id);
    if (n.sink != Sink::Output) continue;
    std::set<NodeId> sources;
    for (Ref r : n.src[0]) sources.insert(r.node);
    for (NodeId from : sources) {
      const Node& p = node(from);
      if (!is_instruction(p) || p.sink != Sink::Value || is_fetch(p.op) || p.loop != n.loop ||
          users[from] != 1)
        continue;
      Unit& unit = units_[static_cast<std::size_t>(unit_of_[from])];
      if (unit.members.size() != 1) continue;
      const std::vector<std::uint8_t> to(n.lane_to.begin(), n.lane_to.begin() + n.width);
      std::array<int, 4> map{};
      if (!plain_copy(n.src[0], from, to, map)) continue;
      Group& g = groups_[static_cast<std::size_t>(unit.group)];
      g.output = static_cast<int>(n.target);
      for (int l = 0; l < unit.width; ++l)
        unit.component[static_cast<std::size_t>(l)] =
            static_cast<std::uint8_t>(map[static_cast<std::size_t>(l)]);
    }
  }
}

std::map<NodeId, Place> Assigner::places(int& register_count) {
  std::map<NodeId, Place> result;
  register_count = 0;
  const auto assign = [&](NodeId id) {
    if (result.contains(id) || unit_of_[id] < 0) return;
    const Unit& unit = units_[static_cast<std::size_t>(unit_of_[id])];
    Group& g = groups_[static_cast<std::size_t>(unit.group)];
    Place p;
    p.output = g.output >= 0;
    if (g.output < 0 && g.reg < 0) g.reg = register_count++;
    p.reg = g.output >= 0 ? g.output : g.reg;
    for (int l = 0; l < node(id).width; ++l)
      p.component[static_cast<std::size_t>(l)] = unit.component[lanes_[id][static_cast<std::size_t>(l)]];
    result[id] = p;
  };
  for (NodeId id : ir_.order) {
    for_each_source(node(id), [&](Lanes& v) {
      for (Ref r : v) {
        assign(r.node);
        if (!is_instruction(node(r.node)) && node(r.node).address.base == Address::Base::Value)
          assign(node(r.node).address.value.node);
      }
    });
    if (node(id).sink == Sink::Value) assign(id);
    if (node(id).sink == Sink::Variable) assign(node(id).target);
  }
  return result;
}

std::map<NodeId, Place> assign_registers(Ir& ir, int& register_count) {
  return Assigner(ir).run(register_count);
}

}  // namespace aluminate::compiler
