#include "shading/compiler/register_assigner.hpp"

#include <algorithm>

namespace aluminate::compiler {

void Assigner::make_groups() {
  for (std::size_t u = 0; u < units_.size(); ++u) {
    Unit& unit = units_[u];
    if (unit.members.empty()) continue;
    new_group(static_cast<int>(u));
  }
}

void Assigner::new_group(int u) {
  Unit& unit = units_[static_cast<std::size_t>(u)];
  Group g;
  g.units.push_back(u);
  unit.group = static_cast<int>(groups_.size());
  for (int l = 0; l < unit.width; ++l) {
    unit.component[static_cast<std::size_t>(l)] = static_cast<std::uint8_t>(l);
    g.taken |= 1u << l;
  }
  const Node& n = node(unit.members[0]);
  if (is_instruction(n) && is_texture(n.op)) {
    g.fixed = true;
    g.taken = texture_lanes(unit.members[0]);
  }
  groups_.push_back(std::move(g));
}

unsigned Assigner::texture_lanes(NodeId id) {
  if (texture_lanes_.empty())
    for (NodeId user : ir_.order)
      for_each_source(node(user), [&](Lanes& v) {
        for (Ref r : v) texture_lanes_[r.node] |= 1u << r.lane;
      });
  const unsigned used = texture_lanes_[id];
  return used != 0 ? used : 1u;
}

Group& Assigner::group_of(NodeId id) {
  return groups_[static_cast<std::size_t>(units_[static_cast<std::size_t>(unit_of_[id])].group)];
}

// Merges two groups when their components fit side by side.
bool Assigner::merge_groups(int a, int b) {
  if (a == b) return true;
  Group *into = &groups_[static_cast<std::size_t>(a)], *from = &groups_[static_cast<std::size_t>(b)];
  if (into->output >= 0 || from->output >= 0) return false;
  if (from->fixed && into->fixed && (from->taken & into->taken) != 0) return false;
  if (from->fixed && !into->fixed) {
    std::swap(into, from);
    std::swap(a, b);
  }
  std::array<int, 4> to{-1, -1, -1, -1};
  unsigned free = ~into->taken & 0xfu;
  for (int c = 0; c < 4; ++c) {  // keep positions that are free, then fill up
    if ((from->taken >> c & 1) == 0) continue;
    if ((free >> c & 1) != 0) {
      to[static_cast<std::size_t>(c)] = c;
      free &= ~(1u << c);
    } else if (from->fixed) {
      return false;
    }
  }
  for (int c = 0; c < 4; ++c) {
    if ((from->taken >> c & 1) == 0 || to[static_cast<std::size_t>(c)] >= 0) continue;
    if (free == 0) return false;
    int lowest = 0;
    while ((free >> lowest & 1) == 0) ++lowest;
    to[static_cast<std::size_t>(c)] = lowest;
    free &= ~(1u << lowest);
  }
  for (int u : from->units) {
    Unit& unit = units_[static_cast<std::size_t>(u)];
    unit.group = a;
    for (int l = 0; l < unit.width; ++l) {
      auto& c = unit.component[static_cast<std::size_t>(l)];
      if (to[c] >= 0) c = static_cast<std::uint8_t>(to[c]);
    }
    into->units.push_back(u);
  }
  into->taken = ~free & 0xfu;
  into->fixed = into->fixed || from->fixed;
  from->units.clear();
  from->taken = 0;
  return true;
}

}  // namespace aluminate::compiler
