// Appends nodes to an Ir: folds constants, drops identities and gives equal expressions one node (value
// numbering inside the structured scopes, so nothing is ever used where it was not computed). Folding uses
// IEEE arithmetic only, no libm: literals are part of the picture and must be the same everywhere.
#pragma once

#include "shading/compiler/ir.hpp"

#include <map>
#include <optional>
#include <span>

namespace aluminate::compiler {

class Builder {
 public:
  explicit Builder(Ir& ir);

  void set_line(vm::SourceLine line) { line_ = line; }
  vm::SourceLine line() const { return line_; }

  Ref constant(double value);
  std::optional<double> value_of(Ref r) const;
  bool is_constant(Ref r, double value) const { return value_of(r) == value; }
  bool all_constant(const Lanes& v, double value) const;
  Ref leaf(NodeKind kind, std::uint32_t index, int lane, const Address& address = {});

  /// One instruction per call (per component on the scalar pipe). Operands of width 1 are replicated.
  Lanes op(vm::Opcode opcode, Lanes a, Lanes b = {}, Lanes c = {}, bool saturate = false);
  Ref op1(vm::Opcode opcode, Lanes a, Lanes b = {}, Lanes c = {}) { return op(opcode, a, b, c)[0]; }

  Lanes add(Lanes a, Lanes b) { return op(vm::Opcode::Add, a, b); }
  Lanes sub(Lanes a, Lanes b) { return op(vm::Opcode::Add, a, negated(b)); }
  Lanes mul(Lanes a, Lanes b) { return op(vm::Opcode::Mul, a, b); }
  Lanes saturate(Lanes a) { return op(vm::Opcode::Mov, a, {}, {}, true); }
  Lanes divide(Lanes a, Lanes b);
  Lanes floor(Lanes a) { return op(vm::Opcode::Flr, a); }
  Ref dot(const Lanes& a, const Lanes& b);
  /// sum over columns[i] * by[i]: mul, mad, mad, ...
  Lanes combine(const std::vector<Lanes>& columns, const Lanes& by);

  // Truth values are 1.0 and 0.0. Comparisons stay visible to choose() and kill, which fold them.
  Lanes logical_not(Lanes a);
  /// condition ? yes : no, one instruction (plus a subtraction when two unknowns are compared).
  Lanes choose(Lanes condition, Lanes yes, Lanes no);
  void kill_if(Ref condition);

  Ref fetch(vm::Opcode opcode, std::uint32_t sampler, const Lanes& a, const Lanes& b, const Lanes& c,
            int lane);

  // Structure. Scopes bound value numbering.
  NodeId flow(vm::Opcode opcode, std::optional<Ref> condition = {});
  void push_scope() { scopes_.emplace_back(); }
  void pop_scope() { scopes_.pop_back(); }
  void enter_loop(std::uint32_t id) { loops_.push_back(id); }
  void leave_loop() { loops_.pop_back(); }
  NodeId variable(int width);
  /// variable[lane_to[i]] = value[i]; also for output registers.
  void write(Sink sink, NodeId target, const Lanes& value, const std::array<std::uint8_t, 4>& lane_to);
  /// A copy that later writes to the variable do not change.
  Lanes snapshot(const Lanes& v);

  Ir& ir() { return ir_; }
  const Node& node(Ref r) const { return ir_.nodes[r.node]; }

 private:
  using Key = std::vector<std::uint64_t>;

  NodeId append(Node node);
  Lanes numbered(Node node);
  /// A lane whose result is one of its operands: x + 0, x * 1.
  struct Passed {
    Ref value{};
    int neutral = -1;  // operand that holds the 0 or 1; -1: none does
  };
  std::optional<Passed> passed_lane(vm::Opcode opcode, Ref a, Ref b, Ref c) const;
  /// A 0 or 1 costs nothing in this operand, of which `lanes` (at least one) are other numbers or values.
  bool takes_literals(vm::Opcode opcode, const Lanes& operand, std::span<const int> lanes) const;
  Ref scalar(vm::Opcode opcode, Ref a);
  Key key_of(const Node& node) const;
  void check_size() const;

  Ir& ir_;
  vm::SourceLine line_{};
  std::vector<std::uint32_t> loops_{0};
  std::map<std::uint64_t, NodeId> constants_;
  std::map<Key, NodeId> leaves_;
  std::vector<std::map<Key, NodeId>> scopes_;
};

}  // namespace aluminate::compiler
