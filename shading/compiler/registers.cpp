#include "shading/compiler/registers.hpp"

#include "platform/host/error.hpp"
#include "shading/compiler/liveness.hpp"

#include <algorithm>
#include <optional>
#include <set>

namespace aluminate::compiler {

using vm::Opcode;

namespace {

// Values that share a place because one is copied into the other. Lane i of a member is lane lanes[i] of the unit.
struct Unit {
  int width = 0;
  std::vector<NodeId> members;
  int group = -1;
  std::array<std::uint8_t, 4> component{};  // position of each lane in the group's register
};

// Units that live in one register, in different components.
struct Group {
  std::vector<int> units;
  unsigned taken = 0;      // components
  bool fixed = false;      // positions cannot be permuted: a texture result
  int output = -1;         // an output register instead
  int reg = -1;
};

class Assigner {
 public:
  explicit Assigner(Ir& ir) : ir_(ir) {}

  std::map<NodeId, Place> run(int& register_count) {
    make_units();
    coalesce_copies();
    make_groups();
    direct_outputs();
    gather_operands();
    return places(register_count);
  }

 private:
  Node& node(NodeId id) { return ir_.nodes[id]; }
  bool has_place(NodeId id) const {
    const Node& n = ir_.nodes[id];
    return n.kind == NodeKind::Variable || (is_instruction(n) && n.sink == Sink::Value);
  }

  // ---- units: copies that need no instruction

  void make_units() {
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
  bool plain_copy(const Lanes& value, NodeId from, const std::vector<std::uint8_t>& to_lanes, std::array<int, 4>& map) const {
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

  void try_unite(NodeId target, NodeId from, const std::array<int, 4>& map, const Liveness& live) {
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
      unit_map[lanes_[from][static_cast<std::size_t>(l)]] = lanes_[target][static_cast<std::size_t>(map[static_cast<std::size_t>(l)])];
    Unit& source = units_[static_cast<std::size_t>(f)];
    for (NodeId m : source.members) {
      unit_of_[m] = t;
      for (int l = 0; l < node(m).width; ++l)
        lanes_[m][static_cast<std::size_t>(l)] = unit_map[lanes_[m][static_cast<std::size_t>(l)]];
      units_[static_cast<std::size_t>(t)].members.push_back(m);
    }
    source.members.clear();
  }

  void coalesce_copies() {
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
        if (is_instruction(node(from)) && node(from).loop != n.loop && node(from).loop != node(n.target).loop) continue;
        try_unite(n.target, from, map, live);
      }
    }
  }

  // ---- groups: units side by side in one register

  void make_groups() {
    for (std::size_t u = 0; u < units_.size(); ++u) {
      Unit& unit = units_[u];
      if (unit.members.empty()) continue;
      new_group(static_cast<int>(u));
    }
  }

  void new_group(int u) {
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

  unsigned texture_lanes(NodeId id) {
    if (texture_lanes_.empty())
      for (NodeId user : ir_.order)
        for_each_source(node(user), [&](Lanes& v) {
          for (Ref r : v) texture_lanes_[r.node] |= 1u << r.lane;
        });
    const unsigned used = texture_lanes_[id];
    return used != 0 ? used : 1u;
  }

  Group& group_of(NodeId id) { return groups_[static_cast<std::size_t>(units_[static_cast<std::size_t>(unit_of_[id])].group)]; }
  std::uint8_t component_of(Ref r) const {
    return units_[static_cast<std::size_t>(unit_of_[r.node])].component[lanes_[r.node][r.lane]];
  }

  // Merges two groups when their components fit side by side.
  bool merge_groups(int a, int b) {
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

  // ---- outputs written by the instruction that computes them

  void direct_outputs() {
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
        if (!is_instruction(p) || p.sink != Sink::Value || is_fetch(p.op) || p.loop != n.loop || users[from] != 1) continue;
        Unit& unit = units_[static_cast<std::size_t>(unit_of_[from])];
        if (unit.members.size() != 1) continue;
        const std::vector<std::uint8_t> to(n.lane_to.begin(), n.lane_to.begin() + n.width);
        std::array<int, 4> map{};
        if (!plain_copy(n.src[0], from, to, map)) continue;
        Group& g = groups_[static_cast<std::size_t>(unit.group)];
        g.output = static_cast<int>(n.target);
        for (int l = 0; l < unit.width; ++l) unit.component[static_cast<std::size_t>(l)] = static_cast<std::uint8_t>(map[static_cast<std::size_t>(l)]);
      }
    }
  }

  // ---- operands from several registers

  // What the hardware reads as one register: a group, or one input, uniform, constant or counter.
  struct Origin {
    int kind = 0;  // 0 group, 1 literal, 2 other leaf
    std::uint64_t id = 0;
    bool negate = false, absolute = false;
    auto operator<=>(const Origin&) const = default;
  };

  Origin origin_of(Ref r) {
    const Node& n = node(r.node);
    if (n.kind == NodeKind::Constant) return {1, 0, false, false};
    if (has_place(r.node)) return {0, static_cast<std::uint64_t>(units_[static_cast<std::size_t>(unit_of_[r.node])].group), r.negate, r.absolute};
    return {2, r.node, r.negate, r.absolute};
  }

  bool one_origin(const Lanes& v) {
    for (Ref r : v)
      if (!(origin_of(r) == origin_of(v[0]))) return false;
    return true;
  }

  NodeId insert_mov(const Lanes& v, const Node& before) {
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
  Lanes gathered(const Lanes& v, const Node& user) {
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
        for (int c = 0; c < 4; ++c) free += (groups_[static_cast<std::size_t>(home)].taken >> c & 1) == 0 ? 1 : 0;
      return free;
    };
    if (static_cast<int>(moving.size()) > room()) {  // a register of their own for all of them
      home = -1;
      stays.fill(false);
      moving.clear();
      for (Ref r : v) moving.insert(r);
      modifiers = {false, false};
    }
    // One mov per origin. The operand's modifiers apply to moved lanes too, so literals are stored accordingly and
    // other values are moved once for plain operands only.
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
      if (home < 0) home = g;
      else ALU_CHECK(merge_groups(home, g), "no room for moved components");
      home = units_[static_cast<std::size_t>(unit_of_[m])].group;
    }
    Lanes result;
    for (int i = 0; i < v.size; ++i) result.push(stays[static_cast<std::size_t>(i)] ? v[i] : moved.at(v[i]));
    if (modifiers.second) {  // absolute values cannot hold signs of moved lanes: take everything through movs instead
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

  Lanes remember(const std::vector<Ref>& key, const Lanes& v) {
    known_.back()[key] = v;
    return v;
  }

  // Fetches read whole temporaries or inputs, without modifiers.
  Lanes fetchable(const Lanes& v, const Node& user) {
    bool fine = one_origin(v);
    for (Ref r : v) {
      const Node& n = node(r.node);
      fine = fine && !r.negate && !r.absolute && ((has_place(r.node) && group_of(r.node).output < 0) || n.kind == NodeKind::Input);
    }
    if (fine) return v;
    Lanes plain;
    for (Ref r : v) plain.push(r);
    const Key key(v.begin(), v.end());
    for (auto scope = fetch_known_.rbegin(); scope != fetch_known_.rend(); ++scope)
      if (auto it = scope->find(key); it != scope->end()) return it->second;
    bool modified = false, leaf = false;
    for (Ref r : v) {
      modified = modified || r.negate || r.absolute;
      leaf = leaf || !has_place(r.node);
    }
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

  static Lanes lanes_of(NodeId id, int width) {
    Lanes v;
    for (int i = 0; i < width; ++i) v.push({id, static_cast<std::uint8_t>(i)});
    return v;
  }

  // An address register is a component of a temporary.
  Ref addressable(Ref r, const Node& user) {
    if (has_place(r.node) && !r.negate && !r.absolute && group_of(r.node).output < 0) return r;
    const Key key{r};
    for (auto scope = address_known_.rbegin(); scope != address_known_.rend(); ++scope)
      if (auto it = scope->find(key); it != scope->end()) return it->second[0];
    const Ref moved{insert_mov(Lanes(r), user), 0, false, false};
    address_known_.back()[key] = Lanes(moved);
    return moved;
  }

  void gather_operands() {
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
        if (is_fetch(before.op)) v = fetchable(v, before);
        else if (!copy) v = gathered(v, before);
        changed.src[static_cast<std::size_t>(k)] = v;
      }
      node(id) = changed;
      if (before.sink == Sink::Variable || before.sink == Sink::Output) split_copy(id);
      else order_.push_back(id);
      if (before.op == Opcode::If || before.op == Opcode::Else || before.op == Opcode::Loop) push();
    }
    ir_.order = std::move(order_);
  }

  // A copy into a variable or output: nothing for lanes that are there already, one mov per origin for the rest.
  void split_copy(NodeId id) {
    const Node n = node(id);
    std::map<Origin, std::vector<int>> parts;
    const int own = n.sink == Sink::Variable ? units_[static_cast<std::size_t>(unit_of_[n.target])].group : -1;
    for (int i = 0; i < n.width; ++i) {
      const Ref r = n.src[0][i];
      const std::uint8_t to = n.lane_to[static_cast<std::size_t>(i)];
      if (has_place(r.node) && !r.negate && !r.absolute) {
        const int u = unit_of_[r.node];
        if (n.sink == Sink::Variable && u == unit_of_[n.target] && lanes_[r.node][r.lane] == lanes_[n.target][to]) continue;
        const Group& g = groups_[static_cast<std::size_t>(units_[static_cast<std::size_t>(u)].group)];
        if (n.sink == Sink::Output && g.output == static_cast<int>(n.target)) continue;
      }
      parts[origin_of(r)].push_back(i);
    }
    std::vector<std::pair<Origin, std::vector<int>>> sequence(parts.begin(), parts.end());
    // Reads of the variable's own register come first: the other parts are about to overwrite it.
    std::stable_sort(sequence.begin(), sequence.end(), [&](const auto& a, const auto& b) {
      const auto reads_own = [&](const auto& p) { return p.first.kind == 0 && static_cast<int>(p.first.id) == own; };
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

  std::map<NodeId, Place> places(int& register_count) {
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
          if (!is_instruction(node(r.node)) && node(r.node).address.base == Address::Base::Value) assign(node(r.node).address.value.node);
        }
      });
      if (node(id).sink == Sink::Value) assign(id);
      if (node(id).sink == Sink::Variable) assign(node(id).target);
    }
    return result;
  }

  using Key = std::vector<Ref>;
  Ir& ir_;
  std::vector<int> unit_of_;
  std::vector<std::array<std::uint8_t, 4>> lanes_;
  std::vector<Unit> units_;
  std::vector<Group> groups_;
  std::map<NodeId, unsigned> texture_lanes_;
  std::vector<NodeId> order_;
  std::vector<std::map<Key, Lanes>> known_, fetch_known_, address_known_;
  std::map<std::pair<NodeId, Ref>, NodeId> readdressed_;
};

}  // namespace

std::map<NodeId, Place> assign_registers(Ir& ir, int& register_count) { return Assigner(ir).run(register_count); }

}  // namespace aluminate::compiler
