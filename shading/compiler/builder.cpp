#include "shading/compiler/builder.hpp"

#include "platform/host/error.hpp"
#include "shading/compiler/fold.hpp"
#include "shading/compiler/limits.hpp"

#include <algorithm>
#include <bit>

namespace aluminate::compiler {

using vm::Opcode;

namespace {

bool is_commutative(Opcode op) {
  switch (op) {
    case Opcode::Add:
    case Opcode::Mul:
    case Opcode::Min:
    case Opcode::Max:
    case Opcode::Dp3:
    case Opcode::Dp4:
    case Opcode::Seq:
    case Opcode::Sne:
      return true;
    default:
      return false;
  }
}

void push_lanes(std::vector<std::uint64_t>& key, const Lanes& v) {
  key.push_back(v.size);
  for (Ref r : v)
    key.push_back((std::uint64_t{r.node} << 8) | (std::uint64_t{r.lane} << 2) | (r.negate ? 2u : 0u) |
                  (r.absolute ? 1u : 0u));
}

bool lanes_less(const Lanes& a, const Lanes& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace

Builder::Builder(Ir& ir) : ir_(ir) { scopes_.emplace_back(); }

void Builder::check_size() const {
  if (ir_.nodes.size() >= kMaxNodes)
    throw UserError(fmt::format("the shader needs more than {} instructions", kMaxNodes),
                    "unroll less: mark large loops [loop], or compile with rolled loops");
}

NodeId Builder::append(Node node) {
  check_size();
  node.line = line_;
  node.loop = loops_.back();
  ir_.nodes.push_back(std::move(node));
  return static_cast<NodeId>(ir_.nodes.size() - 1);
}

Ref Builder::constant(double value) {
  value += 0.0;  // -0 becomes +0
  const auto bits = std::bit_cast<std::uint64_t>(value);
  if (auto found = constants_.find(bits); found != constants_.end()) return {found->second};
  Node n;
  n.kind = NodeKind::Constant;
  n.value = value;
  const NodeId id = append(n);
  constants_.emplace(bits, id);
  return {id};
}

std::optional<double> Builder::value_of(Ref r) const {
  const Node& n = ir_.nodes[r.node];
  if (n.kind != NodeKind::Constant) return std::nullopt;
  double v = n.value;
  if (r.absolute && v < 0) v = -v;
  return r.negate ? -v : v;
}

bool Builder::all_constant(const Lanes& v, double value) const {
  return std::all_of(v.begin(), v.end(), [&](Ref r) { return is_constant(r, value); });
}

Ref Builder::leaf(NodeKind kind, std::uint32_t index, int lane, const Address& address) {
  Node n;
  n.kind = kind;
  n.index = index;
  n.width = 4;
  n.address = address;
  Key key = key_of(n);
  auto found = leaves_.find(key);
  if (found == leaves_.end()) found = leaves_.emplace(std::move(key), append(n)).first;
  return {found->second, static_cast<std::uint8_t>(lane)};
}

Builder::Key Builder::key_of(const Node& n) const {
  Key key{static_cast<std::uint64_t>(n.kind) << 32 | static_cast<std::uint64_t>(n.op) << 8 |
              (n.saturate ? 1u : 0u),
          n.index};
  if (n.kind == NodeKind::Instruction) {
    std::array<Lanes, 3> src = n.src;
    if (is_commutative(n.op) && lanes_less(src[1], src[0])) std::swap(src[0], src[1]);
    for (int i = 0; i < vm::info(n.op).sources; ++i) push_lanes(key, src[static_cast<std::size_t>(i)]);
  } else {
    key.push_back(static_cast<std::uint64_t>(n.address.base));
    push_lanes(key, Lanes(n.address.value));
    key.push_back(n.address.loop);
    key.push_back(std::uint64_t{n.address.scale} << 16 | n.address.limit);
  }
  return key;
}

Lanes Builder::numbered(Node node) {
  Key key = key_of(node);
  NodeId id = 0;
  bool found = false;
  for (auto scope = scopes_.rbegin(); scope != scopes_.rend() && !found; ++scope)
    if (auto it = scope->find(key); it != scope->end()) {
      id = it->second;
      found = true;
    }
  if (!found) {
    id = append(std::move(node));
    ir_.order.push_back(id);
    scopes_.back().emplace(std::move(key), id);
  }
  Lanes result;
  for (std::uint8_t lane = 0; lane < ir_.nodes[id].width; ++lane) result.push({id, lane});
  return result;
}

std::optional<Builder::Passed> Builder::passed_lane(Opcode opcode, Ref a, Ref b, Ref c) const {
  switch (opcode) {
    case Opcode::Add:
      if (is_constant(b, 0)) return Passed{a, 1};
      if (is_constant(a, 0)) return Passed{b, 0};
      break;
    case Opcode::Mul:
      if (is_constant(b, 1)) return Passed{a, 1};
      if (is_constant(a, 1)) return Passed{b, 0};
      if (is_constant(b, -1)) return Passed{-a, 1};
      if (is_constant(a, -1)) return Passed{-b, 0};
      break;
    case Opcode::Mad:
      if (is_constant(b, 0)) return Passed{c, 1};
      if (is_constant(a, 0)) return Passed{c, 0};
      break;
    case Opcode::Min:
    case Opcode::Max:
      if (a == b) return Passed{a, -1};
      break;
    case Opcode::CndGe:
    case Opcode::CndGt:
    case Opcode::CndEq:
      if (b == c) return Passed{b, -1};
      break;
    default:
      break;
  }
  return std::nullopt;
}

bool Builder::takes_literals(Opcode opcode, const Lanes& operand, std::span<const int> lanes) const {
  const auto literal = [&](Ref r) { return value_of(r).has_value(); };
  if (std::all_of(lanes.begin(), lanes.end(), [&](int i) { return literal(operand[i]); })) return true;
  // A product by literals may yet become a multiply-add with the sum, which can multiply by one 0 more.
  const Node& first = node(operand[lanes[0]]);
  if (opcode != Opcode::Add || !is_instruction(first) || first.op != Opcode::Mul ||
      first.sink != Sink::Value || first.saturate)
    return false;
  const bool one = std::all_of(lanes.begin(), lanes.end(), [&](int i) {
    return operand[i].node == operand[lanes[0]].node && !operand[i].absolute;
  });
  return one && (std::all_of(first.src[0].begin(), first.src[0].end(), literal) ||
                 std::all_of(first.src[1].begin(), first.src[1].end(), literal));
}

Ref Builder::scalar(Opcode opcode, Ref a) {
  if (auto v = value_of(a))
    if (auto folded = fold(opcode, *v, 0, 0)) return constant(*folded);
  const Node& from = node(a);
  const bool plain = is_instruction(from) && from.sink == Sink::Value && !from.saturate;
  if (opcode == Opcode::Rcp) {
    if (plain && from.op == Opcode::Sqrt) {  // 1/sqrt(x): one instruction instead of two and a half
      Ref r = scalar(Opcode::Rsq, from.src[0][0]);
      return a.negate ? -r : r;
    }
    if (plain && from.op == Opcode::Rsq && !a.negate) return scalar(Opcode::Sqrt, from.src[0][0]);
    if (plain && from.op == Opcode::Exp && !a.negate) return scalar(Opcode::Exp, -from.src[0][0]);
    if (a.negate) return -scalar(opcode, -a);
  }
  Node n;
  n.op = opcode;
  n.src[0] = a;
  return numbered(n)[0];
}

Lanes Builder::op(Opcode opcode, Lanes a, Lanes b, Lanes c, bool saturated) {
  if (is_scalar_pipe(opcode)) {
    Lanes result;
    for (Ref r : a) result.push(scalar(opcode, r));
    return saturated ? saturate(result) : result;
  }
  Node n;
  n.op = opcode;
  n.saturate = saturated;
  const int sources = vm::info(opcode).sources;
  if (is_reduction(opcode)) {
    n.src = {a, b, c};
    n.width = 1;
    return numbered(n);
  }
  const int width = std::max({a.size, b.size, c.size});
  if (a.size == 1) a = splat(a[0], width);
  if (sources > 1 && b.size == 1) b = splat(b[0], width);
  if (sources > 2 && c.size == 1) c = splat(c[0], width);

  if (opcode == Opcode::Mov && !saturated) return a;

  // Lanes whose result is known leave the instruction.
  Lanes result;
  std::array<int, 4> computed{};
  std::array<std::optional<Passed>, 4> passed{};
  int live = 0, passing = 0;
  for (int i = 0; i < width; ++i) {
    const auto x = value_of(a[i]), y = sources > 1 ? value_of(b[i]) : 0.0,
               z = sources > 2 ? value_of(c[i]) : 0.0;
    std::optional<double> known;
    if (x && y && z) known = fold(opcode, *x, *y, *z);
    if (opcode == Opcode::Mul && ((x && *x == 0) || (y && *y == 0))) known = 0.0;
    if (known && saturated) known = std::clamp(*known, 0.0, 1.0);
    if (known) {
      result.push(constant(*known));
    } else if (x && sources == 3 &&
               (opcode == Opcode::CndGe || opcode == Opcode::CndGt || opcode == Opcode::CndEq)) {
      const bool first = opcode == Opcode::CndGe ? *x >= 0 : opcode == Opcode::CndGt ? *x > 0 : *x == 0;
      result.push(first ? b[i] : c[i]);
    } else {
      if (!saturated) passed[static_cast<std::size_t>(i)] = passed_lane(opcode, a[i], b[i], c[i]);
      passing += passed[static_cast<std::size_t>(i)].has_value();
      computed[static_cast<std::size_t>(live++)] = i;
      result.push({});
    }
  }
  // So do lanes that only hand an operand on, when nothing else is left; or when their 0 or 1 would have to
  // be brought into one register with values. Beside literals it costs nothing, and the vector stays whole.
  if (passing > 0) {
    std::array<int, 4> rest{};
    int others = 0;
    for (int k = 0; k < live; ++k) {
      const int i = computed[static_cast<std::size_t>(k)];
      if (!passed[static_cast<std::size_t>(i)]) rest[static_cast<std::size_t>(others++)] = i;
    }
    const std::span<const int> real(rest.data(), static_cast<std::size_t>(others));
    int kept = 0;
    for (int k = 0; k < live; ++k) {
      const int i = computed[static_cast<std::size_t>(k)];
      const std::optional<Passed>& lane = passed[static_cast<std::size_t>(i)];
      const bool stays =
          !lane ||
          (others > 0 && (lane->neutral < 0 || takes_literals(opcode, lane->neutral == 0 ? a : b, real)));
      if (stays) {
        computed[static_cast<std::size_t>(kept++)] = i;
      } else {
        result[i] = lane->value;
      }
    }
    live = kept;
  }
  if (live == 0) return result;
  bool negate = false;
  if (opcode == Opcode::Mul) {  // -a * b = -(a * b): one node for both
    for (Lanes* v : {&a, &b}) {
      const bool all =
          std::all_of(computed.begin(), computed.begin() + live, [&](int i) { return (*v)[i].negate; });
      if (all) {
        for (int k = 0; k < live; ++k) (*v)[computed[static_cast<std::size_t>(k)]].negate = false;
        negate = !negate;
      }
    }
    if (negate && saturated) {
      for (int k = 0; k < live; ++k) a[computed[static_cast<std::size_t>(k)]].negate ^= true;
      negate = false;
    }
  }
  for (int k = 0; k < live; ++k) {
    const int i = computed[static_cast<std::size_t>(k)];
    n.src[0].push(a[i]);
    if (sources > 1) n.src[1].push(b[i]);
    if (sources > 2) n.src[2].push(c[i]);
  }
  n.width = static_cast<std::uint8_t>(live);
  const Lanes made = numbered(n);
  for (int k = 0; k < live; ++k) result[computed[static_cast<std::size_t>(k)]] = negate ? -made[k] : made[k];
  return result;
}

Lanes Builder::divide(Lanes a, Lanes b) {
  const int width = std::max(a.size, b.size);
  if (b.size == 1) b = splat(b[0], width);
  return mul(a, op(Opcode::Rcp, b));
}

Ref Builder::dot(const Lanes& a, const Lanes& b) {
  switch (a.size) {
    case 1:
      return mul(a, b)[0];
    case 2:
      return op1(Opcode::Dp2Add, a, b, constant(0));
    case 3:
      return op1(Opcode::Dp3, a, b);
    default:
      return op1(Opcode::Dp4, a, b);
  }
}

Lanes Builder::combine(const std::vector<Lanes>& columns, const Lanes& by) {
  Lanes sum = mul(columns[0], by[0]);
  for (int i = 1; i < by.size; ++i) sum = add(mul(columns[static_cast<std::size_t>(i)], by[i]), sum);
  return sum;
}

Lanes Builder::logical_not(Lanes a) {
  // A vector comparison is inverted as a whole so that it stays one instruction.
  const Node& first = node(a[0]);
  bool whole = is_instruction(first) && first.sink == Sink::Value && !first.saturate;
  for (Ref r : a) whole = whole && r.node == a[0].node && !r.negate && !r.absolute;
  if (whole) {
    const Node n = first;
    Lanes x, y;
    if (vm::info(n.op).sources == 2 && is_componentwise(n.op))
      for (Ref r : a) {
        x.push(n.src[0][r.lane]);
        y.push(n.src[1][r.lane]);
      }
    switch (n.op) {
      case Opcode::Sge:
        return op(Opcode::Sgt, y, x);
      case Opcode::Sgt:
        return op(Opcode::Sge, y, x);
      case Opcode::Seq:
        return op(Opcode::Sne, x, y);
      case Opcode::Sne:
        return op(Opcode::Seq, x, y);
      default:
        break;
    }
  }
  return sub(constant(1), a);
}

Lanes Builder::choose(Lanes condition, Lanes yes, Lanes no) {
  const int width = std::max(yes.size, no.size);
  if (condition.size == 1) condition = splat(condition[0], width);
  if (all_constant(yes, 1) && all_constant(no, 0)) return condition;
  if (all_constant(yes, 0) && all_constant(no, 1)) return logical_not(condition);
  const Node n = node(condition[0]);
  bool compare = is_instruction(n) && n.sink == Sink::Value && !n.saturate &&
                 (n.op == Opcode::Sge || n.op == Opcode::Sgt || n.op == Opcode::Seq || n.op == Opcode::Sne);
  for (Ref r : condition) compare = compare && r.node == condition[0].node && !r.negate && !r.absolute;
  if (!compare) return op(Opcode::CndEq, condition, no, yes);
  Lanes x, y;
  bool scalar_condition = true;
  for (Ref r : condition) scalar_condition = scalar_condition && r == condition[0];
  for (Ref r : condition) {
    x.push(n.src[0][r.lane]);
    y.push(n.src[1][r.lane]);
    if (scalar_condition) break;
  }
  // 0 > y and 0 >= y read -y directly; otherwise the sign of x - y decides.
  const Lanes difference = sub(x, y);
  switch (n.op) {
    case Opcode::Sge:
      return op(Opcode::CndGe, difference, yes, no);
    case Opcode::Sgt:
      return op(Opcode::CndGt, difference, yes, no);
    case Opcode::Seq:
      return op(Opcode::CndEq, difference, yes, no);
    default:
      return op(Opcode::CndEq, difference, no, yes);
  }
}

void Builder::kill_if(Ref condition) {
  const Node n = node(condition);
  Node kill;
  kill.op = Opcode::KillNe;
  kill.sink = Sink::None;
  kill.width = 0;
  kill.src[0] = condition;
  kill.src[1] = constant(0);
  const bool plain =
      is_instruction(n) && n.sink == Sink::Value && !n.saturate && !condition.negate && !condition.absolute;
  if (plain && n.op == Opcode::Max && n.width >= 1) {  // a or b: one kill each
    const Ref a = n.src[0][condition.lane], b = n.src[1][condition.lane];
    const auto truth = [&](Ref r) {
      const Node& m = node(r);
      return is_instruction(m) && (m.op == Opcode::Sge || m.op == Opcode::Sgt || m.op == Opcode::Seq ||
                                   m.op == Opcode::Sne || m.op == Opcode::Max);
    };
    if (truth(a) && truth(b)) {
      kill_if(a);
      kill_if(b);
      return;
    }
  }
  if (plain && (n.op == Opcode::Sge || n.op == Opcode::Sgt || n.op == Opcode::Seq || n.op == Opcode::Sne)) {
    kill.op = n.op == Opcode::Sge   ? Opcode::KillGe
              : n.op == Opcode::Sgt ? Opcode::KillGt
              : n.op == Opcode::Seq ? Opcode::KillEq
                                    : Opcode::KillNe;
    kill.src[0] = n.src[0][condition.lane];
    kill.src[1] = n.src[1][condition.lane];
  }
  ir_.order.push_back(append(kill));
}

Ref Builder::fetch(Opcode opcode, std::uint32_t sampler, const Lanes& a, const Lanes& b, const Lanes& c,
                   int lane) {
  Node n;
  n.op = opcode;
  n.index = sampler;
  n.width = 4;
  n.src = {a, b, c};
  return numbered(n)[lane];
}

NodeId Builder::flow(Opcode opcode, std::optional<Ref> condition) {
  Node n;
  n.op = opcode;
  n.sink = Sink::None;
  n.width = 0;
  if (condition) n.src[0] = *condition;
  const NodeId id = append(n);
  ir_.order.push_back(id);
  return id;
}

NodeId Builder::variable(int width) {
  Node n;
  n.kind = NodeKind::Variable;
  n.width = static_cast<std::uint8_t>(width);
  return append(n);
}

void Builder::write(Sink sink, NodeId target, const Lanes& value,
                    const std::array<std::uint8_t, 4>& lane_to) {
  Node n;
  n.op = Opcode::Mov;
  n.sink = sink;
  n.target = target;
  n.lane_to = lane_to;
  n.width = value.size;
  n.src[0] = value;
  ir_.order.push_back(append(n));
}

Lanes Builder::snapshot(const Lanes& v) {
  Node n;
  n.op = Opcode::Mov;
  n.width = v.size;
  n.src[0] = v;
  const NodeId id = append(n);
  ir_.order.push_back(id);
  Lanes result;
  for (std::uint8_t i = 0; i < v.size; ++i) result.push({id, i});
  return result;
}

}  // namespace aluminate::compiler
