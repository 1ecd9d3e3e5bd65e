#include "shading/compiler/register_assigner.hpp"

#include "platform/host/error.hpp"

#include <algorithm>

namespace aluminate::compiler {

using vm::Opcode;

Assigner::Origin Assigner::origin_of(Ref r) {
  const Node& n = node(r.node);
  if (n.kind == NodeKind::Constant) return {1, 0, false, false};
  if (has_place(r.node))
    return {0, static_cast<std::uint64_t>(units_[static_cast<std::size_t>(unit_of_[r.node])].group), r.negate,
            r.absolute};
  return {2, r.node, r.negate, r.absolute};
}

bool Assigner::one_origin(const Lanes& v) {
  for (Ref r : v)
    if (!(origin_of(r) == origin_of(v[0]))) return false;
  return true;
}

NodeId Assigner::insert_mov(const Lanes& v, const Node& before) {
  Node m;
  m.op = Opcode::Mov;
  m.width = v.size;
  m.src[0] = v;
  m.line = before.line;
  m.loop = before.loop;
  ir_.nodes.push_back(m);
  const NodeId id = static_cast<NodeId>(ir_.nodes.size() - 1);
  unit_of_.push_back(static_cast<int>(units_.size()));
  lanes_.push_back({0, 1, 2, 3});
  units_.push_back({v.size, {id}, -1, {}});
  new_group(unit_of_[id]);
  order_.push_back(id);
  return id;
}

// Lanes that cannot be read together are moved; afterwards the operand has one origin.
Lanes Assigner::gathered(const Lanes& v, const Node& user) {
  if (one_origin(v)) return v;
  const Key key(v.begin(), v.end());
  for (auto scope = known_.rbegin(); scope != known_.rend(); ++scope)
    if (auto it = scope->find(key); it != scope->end()) return it->second;

  // The modifiers most register lanes have stay on the operand; everything else is moved.
  std::map<std::pair<bool, bool>, int> votes;
  for (Ref r : v)
    if (origin_of(r).kind == 0) ++votes[{r.negate, r.absolute}];
  std::pair<bool, bool> modifiers{false, false};
  int most = 0;
  for (const auto& [m, count] : votes)
    if (count > most) {
      most = count;
      modifiers = m;
    }
  // Try to bring the groups of all fitting lanes together, in the order they appear.
  int home = -1;
  std::array<bool, 4> stays{};
  for (int i = 0; i < v.size; ++i) {
    const Origin o = origin_of(v[i]);
    if (o.kind != 0 || o.negate != modifiers.first || o.absolute != modifiers.second) continue;
    const int g = static_cast<int>(o.id);
    if (groups_[static_cast<std::size_t>(g)].output >= 0) continue;
    if (home < 0) home = g;
    if (!merge_groups(home, g)) continue;
    home = units_[static_cast<std::size_t>(unit_of_[v[i].node])].group;
    stays[static_cast<std::size_t>(i)] = true;
  }
  // Distinct components that must be moved need room beside those that stay.
  std::set<Ref> moving;
  for (int i = 0; i < v.size; ++i)
    if (!stays[static_cast<std::size_t>(i)]) moving.insert(v[i]);
  const auto room = [&] {
    int free = 0;
    if (home >= 0)
      for (int c = 0; c < 4; ++c)
        free += (groups_[static_cast<std::size_t>(home)].taken >> c & 1) == 0 ? 1 : 0;
    return free;
  };
  if (static_cast<int>(moving.size()) > room()) {  // a register of their own for all of them
    home = -1;
    stays.fill(false);
    moving.clear();
    for (Ref r : v) moving.insert(r);
    modifiers = {false, false};
  }
  // One mov per origin. The operand's modifiers apply to moved lanes too, so literals are stored
  // accordingly and other values are moved once for plain operands only.
  std::map<Origin, std::vector<Ref>> by_origin;
  for (int i = 0; i < v.size; ++i)
    if (!stays[static_cast<std::size_t>(i)]) {
      auto& list = by_origin[origin_of(v[i])];
      if (std::find(list.begin(), list.end(), v[i]) == list.end()) list.push_back(v[i]);
    }
  std::map<Ref, Ref> moved;
  for (const auto& [origin, list] : by_origin) {
    Lanes value;
    for (Ref r : list) value.push(modifiers.first ? -r : r);
    const NodeId m = insert_mov(value, user);
    for (std::size_t k = 0; k < list.size(); ++k)
      moved[list[k]] = {m, static_cast<std::uint8_t>(k), modifiers.first, false};
    const int g = units_[static_cast<std::size_t>(unit_of_[m])].group;
    if (home < 0)
      home = g;
    else
      ALU_CHECK(merge_groups(home, g), "no room for moved components");
    home = units_[static_cast<std::size_t>(unit_of_[m])].group;
  }
  Lanes result;
  for (int i = 0; i < v.size; ++i) result.push(stays[static_cast<std::size_t>(i)] ? v[i] : moved.at(v[i]));
  if (modifiers.second) {  // absolute values cannot hold signs of moved lanes: take everything through movs
                           // instead
    bool mixed = false;
    for (int i = 0; i < v.size; ++i) mixed = mixed || !stays[static_cast<std::size_t>(i)];
    if (mixed) {
      Lanes plain;
      for (Ref r : v) {
        const NodeId m = insert_mov(Lanes(r), user);
        plain.push({m, 0, false, false});
      }
      return remember(key, gathered(plain, user));
    }
  }
  return remember(key, result);
}

Lanes Assigner::remember(const std::vector<Ref>& key, const Lanes& v) {
  known_.back()[key] = v;
  return v;
}

// Fetches read whole temporaries or inputs, without modifiers.
Lanes Assigner::fetchable(const Lanes& v, const Node& user) {
  bool fine = one_origin(v);
  for (Ref r : v) {
    const Node& n = node(r.node);
    fine = fine && !r.negate && !r.absolute &&
           ((has_place(r.node) && group_of(r.node).output < 0) || n.kind == NodeKind::Input);
  }
  if (fine) return v;
  const Key key(v.begin(), v.end());
  for (auto scope = fetch_known_.rbegin(); scope != fetch_known_.rend(); ++scope)
    if (auto it = scope->find(key); it != scope->end()) return it->second;
  bool modified = false;
  for (Ref r : v) modified = modified || r.negate || r.absolute;
  Lanes result;
  if (one_origin(v)) {
    result = lanes_of(insert_mov(v, user), v.size);
  } else if (!modified) {
    result = gathered(v, user);
  } else {
    Lanes clean = v;  // modified lanes are moved on their own, then everything is gathered
    for (Ref& r : clean)
      if (r.negate || r.absolute) r = {insert_mov(Lanes(r), user), 0, false, false};
    result = one_origin(clean) ? clean : gathered(clean, user);
  }
  fetch_known_.back()[key] = result;
  return result;
}

Lanes Assigner::lanes_of(NodeId id, int width) {
  Lanes v;
  for (int i = 0; i < width; ++i) v.push({id, static_cast<std::uint8_t>(i)});
  return v;
}

// An address register is a component of a temporary.
Ref Assigner::addressable(Ref r, const Node& user) {
  if (has_place(r.node) && !r.negate && !r.absolute && group_of(r.node).output < 0) return r;
  const Key key{r};
  for (auto scope = address_known_.rbegin(); scope != address_known_.rend(); ++scope)
    if (auto it = scope->find(key); it != scope->end()) return it->second[0];
  const Ref moved{insert_mov(Lanes(r), user), 0, false, false};
  address_known_.back()[key] = Lanes(moved);
  return moved;
}

void Assigner::gather_operands() {
  std::vector<NodeId> old;
  old.swap(ir_.order);
  const auto push = [&] {
    known_.emplace_back();
    fetch_known_.emplace_back();
    address_known_.emplace_back();
  };
  const auto pop = [&] {
    known_.pop_back();
    fetch_known_.pop_back();
    address_known_.pop_back();
  };
  push();
  for (NodeId id : old) {
    const Node before = node(id);
    if (before.op == Opcode::EndIf || before.op == Opcode::EndLoop || before.op == Opcode::Else) pop();
    Node changed = before;
    for (int k = 0; k < vm::info(before.op).sources; ++k) {
      Lanes v = before.src[static_cast<std::size_t>(k)];
      for (Ref& r : v) {
        const Node leaf = node(r.node);
        if (is_instruction(leaf) || leaf.address.base != Address::Base::Value) continue;
        const Ref address = addressable(leaf.address.value, before);
        if (address == leaf.address.value) continue;
        const auto cached = readdressed_.find({r.node, address});
        if (cached != readdressed_.end()) {
          r.node = cached->second;
          continue;
        }
        Node copy = leaf;
        copy.address.value = address;
        ir_.nodes.push_back(copy);
        unit_of_.push_back(-1);
        lanes_.push_back({0, 1, 2, 3});
        const NodeId made = static_cast<NodeId>(ir_.nodes.size() - 1);
        readdressed_[{r.node, address}] = made;
        r.node = made;
      }
      const bool copy = before.sink == Sink::Variable || before.sink == Sink::Output;
      if (is_fetch(before.op))
        v = fetchable(v, before);
      else if (!copy)
        v = gathered(v, before);
      changed.src[static_cast<std::size_t>(k)] = v;
    }
    node(id) = changed;
    if (before.sink == Sink::Variable || before.sink == Sink::Output)
      split_copy(id);
    else
      order_.push_back(id);
    if (before.op == Opcode::If || before.op == Opcode::Else || before.op == Opcode::Loop) push();
  }
  ir_.order = std::move(order_);
}

// A copy into a variable or output: nothing for lanes that are there already, one mov per origin for the
// rest.
void Assigner::split_copy(NodeId id) {
  const Node n = node(id);
  std::map<Origin, std::vector<int>> parts;
  const int own = n.sink == Sink::Variable ? units_[static_cast<std::size_t>(unit_of_[n.target])].group : -1;
  for (int i = 0; i < n.width; ++i) {
    const Ref r = n.src[0][i];
    const std::uint8_t to = n.lane_to[static_cast<std::size_t>(i)];
    if (has_place(r.node) && !r.negate && !r.absolute) {
      const int u = unit_of_[r.node];
      if (n.sink == Sink::Variable && u == unit_of_[n.target] &&
          lanes_[r.node][r.lane] == lanes_[n.target][to])
        continue;
      const Group& g = groups_[static_cast<std::size_t>(units_[static_cast<std::size_t>(u)].group)];
      if (n.sink == Sink::Output && g.output == static_cast<int>(n.target)) continue;
    }
    parts[origin_of(r)].push_back(i);
  }
  std::vector<std::pair<Origin, std::vector<int>>> sequence(parts.begin(), parts.end());
  // Reads of the variable's own register come first: the other parts are about to overwrite it.
  std::stable_sort(sequence.begin(), sequence.end(), [&](const auto& a, const auto& b) {
    const auto reads_own = [&](const auto& p) {
      return p.first.kind == 0 && static_cast<int>(p.first.id) == own;
    };
    return reads_own(a) && !reads_own(b);
  });
  bool first = true;
  for (const auto& [origin, lanes] : sequence) {
    Node part = n;
    part.width = 0;
    part.src[0] = {};
    for (int i : lanes) {
      part.src[0].push(n.src[0][i]);
      part.lane_to[part.width++] = n.lane_to[static_cast<std::size_t>(i)];
    }
    NodeId at = id;
    if (first) {
      node(id) = part;
    } else {
      ir_.nodes.push_back(part);
      unit_of_.push_back(-1);
      lanes_.push_back({0, 1, 2, 3});
      at = static_cast<NodeId>(ir_.nodes.size() - 1);
    }
    first = false;
    order_.push_back(at);
  }
}

}  // namespace aluminate::compiler
