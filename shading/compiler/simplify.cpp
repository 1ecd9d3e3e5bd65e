#include "shading/compiler/simplify.hpp"

#include <algorithm>
#include <map>
#include <optional>

namespace aluminate::compiler {

using vm::Opcode;

namespace {

class Simplifier {
 public:
  explicit Simplifier(Ir& ir) : ir_(ir) {}

  void run() {
    remove_dead();
    // (c0 x + c1) c2 becomes c0c2 x + c1c2 before any mad is formed, so that every way of writing it costs
    // the same.
    while (pass(&Simplifier::collect_constants)) remove_dead();
    pass(&Simplifier::fuse_sum);
    remove_dead();
    pass(&Simplifier::release_zeros);
    remove_dead();
    while (pass(&Simplifier::fuse_saturate)) remove_dead();
    remove_dead();
  }

 private:
  using Rule = bool (Simplifier::*)(NodeId);

  bool pass(Rule rule) {
    count_uses();
    replaced_.clear();
    inserted_.clear();
    bool changed = false;
    std::vector<NodeId> order;
    for (NodeId id : ir_.order) {
      resolve(id);
      position_[id] = order.size();
      inserted_.clear();
      changed |= (this->*rule)(id);
      order.insert(order.end(), inserted_.begin(), inserted_.end());
      order.push_back(id);
    }
    ir_.order = std::move(order);
    for (NodeId id = 0; id < ir_.nodes.size(); ++id)
      if (!is_instruction(ir_.nodes[id])) resolve(id);
    return changed;
  }

  // Operands that name a replaced component get its replacement.
  void resolve(NodeId id) {
    if (replaced_.empty()) return;
    for_each_source(ir_.nodes[id], [&](Lanes& lanes) {
      for (Ref& r : lanes)
        for (auto it = replaced_.find({r.node, r.lane}); it != replaced_.end();
             it = replaced_.find({r.node, r.lane})) {
          Ref to = it->second;
          if (r.absolute) to = absolute(to);
          to.negate ^= r.negate;
          r = to;
        }
    });
  }

  void count_uses() {
    uses_.assign(ir_.nodes.size(), 0);
    position_.assign(ir_.nodes.size(), 0);
    const auto count = [&](NodeId user) {
      for_each_source(ir_.nodes[user], [&](Lanes& lanes) {
        for (int i = 0; i < lanes.size; ++i) {
          bool first = true;
          for (int k = 0; k < i; ++k) first = first && lanes[k].node != lanes[i].node;
          if (first) ++uses_[lanes[i].node];
        }
      });
    };
    std::vector<bool> leaf_seen(ir_.nodes.size());
    for (NodeId id : ir_.order) {
      count(id);
      for_each_source(ir_.nodes[id], [&](Lanes& lanes) {
        for (Ref r : lanes)
          if (!is_instruction(ir_.nodes[r.node]) && !leaf_seen[r.node]) {
            leaf_seen[r.node] = true;
            count(r.node);
          }
      });
    }
  }

  Node& node(NodeId id) { return ir_.nodes[id]; }

  // The instruction all components come from, when this operand is its only use and it can take part in a
  // fusion.
  std::optional<NodeId> sole_producer(const Lanes& v) const {
    const NodeId id = v[0].node;
    const Node& n = ir_.nodes[id];
    if (!is_instruction(n) || n.sink != Sink::Value || n.saturate || id >= uses_.size() || uses_[id] != 1)
      return std::nullopt;
    for (Ref r : v)
      if (r.node != id || r.absolute) return std::nullopt;
    return id;
  }

  std::optional<double> number(Ref r) const {
    const Node& n = ir_.nodes[r.node];
    if (n.kind != NodeKind::Constant) return std::nullopt;
    const double v = r.absolute && n.value < 0 ? -n.value : n.value;
    return r.negate ? -v : v;
  }

  bool all_numbers(const Lanes& v) const {
    return std::all_of(v.begin(), v.end(), [&](Ref r) { return number(r).has_value(); });
  }

  Ref constant(double value) {
    if (auto it = constants_.find(value); it != constants_.end()) return {it->second};
    Node n;
    n.kind = NodeKind::Constant;
    n.value = value + 0.0;
    ir_.nodes.push_back(n);
    const NodeId id = static_cast<NodeId>(ir_.nodes.size() - 1);
    constants_[value] = id;
    return {id};
  }

  // Operand `which` of the producer, lane by lane as `v` reads the producer; the sign of v moves onto it.
  Lanes through(const Lanes& v, NodeId producer, int which, bool carry_sign) const {
    Lanes result;
    for (Ref r : v) {
      Ref x = ir_.nodes[producer].src[static_cast<std::size_t>(which)][r.lane];
      if (carry_sign && r.negate) x = -x;
      result.push(x);
    }
    return result;
  }

  bool collect_constants(NodeId id) {
    if (!is_instruction(node(id)) || node(id).sink != Sink::Value) return false;
    if (node(id).op != Opcode::Mul && node(id).op != Opcode::Add) return false;
    const int known = all_numbers(node(id).src[1]) ? 1 : all_numbers(node(id).src[0]) ? 0 : -1;
    if (known < 0) return false;
    const Lanes c = node(id).src[static_cast<std::size_t>(known)],
                x = node(id).src[static_cast<std::size_t>(1 - known)];
    const auto from = sole_producer(x);
    if (!from) return false;
    const Opcode inner = node(*from).op;
    if (inner != Opcode::Mul && inner != Opcode::Add) return false;
    const int inner_known = all_numbers(node(*from).src[1]) ? 1 : all_numbers(node(*from).src[0]) ? 0 : -1;
    if (inner_known < 0) return false;
    if (node(id).op == Opcode::Add && inner == Opcode::Mul) return false;  // a mad
    if (reads_variable_of_other_loop(*from, id)) return false;
    const Lanes inner_c = through(x, *from, inner_known, true),
                rest = through(x, *from, 1 - inner_known, inner == Opcode::Add);

    Lanes combined;
    for (int i = 0; i < c.size; ++i) {
      const double a = *number(c[i]), b = *number(inner_c[i]);
      combined.push(constant(node(id).op == Opcode::Add ? a + b : a * b));
    }
    if (node(id).op == inner) {  // (x c1) c2, (x + c1) + c2
      node(id).src[0] = rest;
      node(id).src[1] = combined;
    } else {  // (x + c1) c2 = x c2 + c1 c2
      Node product;
      product.op = Opcode::Mul;
      product.width = node(id).width;
      product.src[0] = rest;
      product.src[1] = c;
      product.line = node(*from).line;
      product.loop = node(id).loop;
      ir_.nodes.push_back(product);
      const NodeId made = static_cast<NodeId>(ir_.nodes.size() - 1);
      inserted_.push_back(made);
      uses_.resize(ir_.nodes.size(), 1);
      position_.resize(ir_.nodes.size(), 0);
      Node& sum = node(id);
      sum.op = Opcode::Add;
      for (int i = 0; i < sum.width; ++i) sum.src[0][i] = {made, static_cast<std::uint8_t>(i)};
      sum.src[1] = combined;
    }
    return true;
  }

  // A product may move to its sum unless it reads a loop-carried variable that is written in between.
  bool reads_variable_of_other_loop(NodeId producer, NodeId user) const {
    if (ir_.nodes[producer].loop == ir_.nodes[user].loop) return false;
    for (const Lanes& v : ir_.nodes[producer].src)
      for (Ref r : v)
        if (ir_.nodes[r.node].kind == NodeKind::Variable || ir_.nodes[r.node].kind == NodeKind::Counter)
          return true;
    return false;
  }

  // Components that are 0 left their product when it was built; in the sum they are 0 times whatever the
  // others multiply, as long as the 0 can stand among literals.
  std::optional<NodeId> sole_product_or_zero(const Lanes& v) const {
    Lanes products;
    for (Ref r : v)
      if (number(r) != 0.0) products.push(r);
    if (products.size == 0) return std::nullopt;
    const auto from = sole_producer(products);
    if (!from || products.size == v.size) return from;
    const Node& p = ir_.nodes[*from];
    if (p.op != Opcode::Mul || literal_factor(p) < 0) return std::nullopt;
    return from;
  }

  int literal_factor(const Node& product) const {
    return all_numbers(product.src[1]) ? 1 : all_numbers(product.src[0]) ? 0 : -1;
  }

  // Factor `which` of a product, lane by lane as `v` reads it; lanes of v that are 0 read 0 times the first
  // other lane.
  Lanes factor(const Lanes& v, NodeId product, int which, bool carry_sign) {
    Ref present = v[0];
    for (Ref r : v)
      if (r.node == product) {
        present = r;
        break;
      }
    Lanes result;
    for (Ref r : v) {
      const bool zero = r.node != product;
      Ref x = ir_.nodes[product].src[static_cast<std::size_t>(which)][zero ? present.lane : r.lane];
      if (zero && which == literal_factor(ir_.nodes[product])) {
        result.push(constant(0));
        continue;
      }
      if (carry_sign && (zero ? present : r).negate) x = -x;
      result.push(x);
    }
    return result;
  }

  bool fuse_sum(NodeId id) {
    if (!is_instruction(node(id)) || node(id).sink != Sink::Value || node(id).op != Opcode::Add) return false;
    int best = -1;
    NodeId producer = 0;
    for (int k = 0; k < 2; ++k) {
      const auto from = sole_product_or_zero(node(id).src[static_cast<std::size_t>(k)]);
      if (!from || reads_variable_of_other_loop(*from, id)) continue;
      const Node& p = node(*from);
      const bool product = p.op == Opcode::Mul;
      const bool dot2 = p.op == Opcode::Dp2Add && node(id).width == 1 && number(p.src[2][0]) == 0.0;
      if (!product && !dot2) continue;
      if (best >= 0 && position_[*from] < position_[producer]) continue;
      best = k;
      producer = *from;
    }
    if (best < 0) return false;
    Node& sum = node(id);
    const Lanes v = sum.src[static_cast<std::size_t>(best)],
                other = sum.src[static_cast<std::size_t>(1 - best)];
    const NodeId from = producer;
    if (node(from).op == Opcode::Mul) {
      const Lanes a = factor(v, from, 0, true), b = factor(v, from, 1, false);
      Node& mad = node(id);  // a constant may have been added
      mad.op = Opcode::Mad;
      mad.src = {a, b, other};
    } else {
      Lanes a = node(from).src[0];
      if (v[0].negate) a = negated(a);
      sum.op = Opcode::Dp2Add;
      sum.src = {a, node(from).src[1], other};
    }
    return true;
  }

  // x + 0 among other sums: what did not become a multiply-add would need its 0 in a register of values.
  bool release_zeros(NodeId id) {
    const Node& n = node(id);
    if (!is_instruction(n) || n.sink != Sink::Value || n.op != Opcode::Add || n.saturate) return false;
    bool changed = false;
    for (std::size_t s = 0; s < 2; ++s) {
      if (all_numbers(n.src[s])) continue;
      for (std::uint8_t i = 0; i < n.width; ++i) {
        if (number(n.src[s][i]) != 0.0) continue;
        const Ref kept = n.src[1 - s][i];
        if (ir_.nodes[kept.node].kind == NodeKind::Variable || ir_.nodes[kept.node].kind == NodeKind::Counter)
          continue;  // it may change before the sum is read
        replaced_[{id, i}] = kept;
        changed = true;
      }
    }
    return changed;
  }

  bool fuse_saturate(NodeId id) {
    const Node n = node(id);
    if (!is_instruction(n) || n.sink != Sink::Value || n.op != Opcode::Mov || !n.saturate) return false;
    const Lanes v = n.src[0];
    const NodeId from = v[0].node;
    Node& p = node(from);
    if (!is_instruction(p) || p.sink != Sink::Value || is_fetch(p.op)) return false;
    for (Ref r : v)
      if (r.node != from || r.absolute || r.negate != v[0].negate) return false;
    if (p.saturate) {  // already in [0, 1]
      if (v[0].negate) return false;
    } else {
      if (uses_[from] != 1) return false;
      if (v[0].negate && !push_negation(p)) return false;
      p.saturate = true;
    }
    for (std::uint8_t i = 0; i < v.size; ++i) replaced_[{id, i}] = {from, v[i].lane, false, false};
    return true;
  }

  static bool push_negation(Node& p) {
    switch (p.op) {
      case Opcode::Mov:
      case Opcode::Mul:
      case Opcode::Dp3:
      case Opcode::Dp4:
        p.src[0] = negated(p.src[0]);
        return true;
      case Opcode::Add:
        p.src[0] = negated(p.src[0]);
        p.src[1] = negated(p.src[1]);
        return true;
      case Opcode::Mad:
      case Opcode::Dp2Add:
        p.src[0] = negated(p.src[0]);
        p.src[2] = negated(p.src[2]);
        return true;
      default:
        return false;
    }
  }

  // Marks components from the effects backwards, then drops instructions and components nobody reads.
  void remove_dead() {
    std::vector<std::uint8_t> live(ir_.nodes.size(), 0);
    std::vector<std::vector<NodeId>> writes(ir_.nodes.size());
    for (NodeId id : ir_.order)
      if (node(id).sink == Sink::Variable) writes[node(id).target].push_back(id);
    std::vector<Ref> open;
    const auto mark = [&](Ref r) {
      const auto bit = static_cast<std::uint8_t>(1u << r.lane);
      if ((live[r.node] & bit) != 0) return;
      live[r.node] |= bit;
      open.push_back(r);
    };
    for (NodeId id : ir_.order) {
      const Node& n = node(id);
      if (n.sink != Sink::Output && n.sink != Sink::None) continue;
      for (int k = 0; k < vm::info(n.op).sources; ++k)
        for (Ref r : n.src[static_cast<std::size_t>(k)]) mark(r);
    }
    while (!open.empty()) {
      const Ref r = open.back();
      open.pop_back();
      const Node& n = node(r.node);
      if (n.kind == NodeKind::Variable) {
        for (NodeId w : writes[r.node])
          for (std::uint8_t i = 0; i < node(w).width; ++i)
            if (node(w).lane_to[i] == r.lane) {
              live[w] |= static_cast<std::uint8_t>(1u << i);
              mark(node(w).src[0][i]);
            }
      } else if (is_instruction(n)) {
        for (int k = 0; k < vm::info(n.op).sources; ++k) {
          const Lanes& v = n.src[static_cast<std::size_t>(k)];
          if (is_componentwise(n.op))
            mark(v[r.lane]);
          else
            for (Ref s : v) mark(s);
        }
      } else if (n.address.base == Address::Base::Value) {
        mark(n.address.value);
      }
    }
    std::map<std::pair<NodeId, std::uint8_t>, std::uint8_t> moved;
    std::vector<NodeId> order;
    for (NodeId id : ir_.order) {
      Node& n = node(id);
      const bool always = n.sink == Sink::Output || n.sink == Sink::None;
      if (!always && live[id] == 0) continue;
      order.push_back(id);
      if (always || is_texture(n.op) || is_reduction(n.op)) continue;
      std::uint8_t width = 0;
      for (std::uint8_t i = 0; i < n.width; ++i) {
        if ((live[id] >> i & 1) == 0) continue;
        if (i != width) {
          for (int k = 0; k < vm::info(n.op).sources; ++k)
            n.src[static_cast<std::size_t>(k)][width] = n.src[static_cast<std::size_t>(k)][i];
          n.lane_to[width] = n.lane_to[i];
          moved[{id, i}] = width;
        }
        ++width;
      }
      n.width = width;
      for (int k = 0; k < vm::info(n.op).sources; ++k) n.src[static_cast<std::size_t>(k)].size = width;
    }
    ir_.order = std::move(order);
    if (moved.empty()) return;
    for (Node& n : ir_.nodes)
      for_each_source(n, [&](Lanes& lanes) {
        for (Ref& r : lanes)
          if (auto it = moved.find({r.node, r.lane}); it != moved.end()) r.lane = it->second;
      });
  }

  Ir& ir_;
  std::vector<int> uses_;
  std::vector<std::size_t> position_;
  std::map<std::pair<NodeId, std::uint8_t>, Ref> replaced_;
  std::vector<NodeId> inserted_;
  std::map<double, NodeId> constants_;
};

}  // namespace

void simplify(Ir& ir) { Simplifier(ir).run(); }

}  // namespace aluminate::compiler
