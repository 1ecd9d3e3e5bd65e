// The compiler's own form of a shader: a list of nodes in source order, control flow still structured (If ..
// EndIf, Loop .. EndLoop in the list itself). A value is a tuple of component references, so taking vectors
// apart, putting them together, negating and taking absolute values cost nothing until registers are
// assigned. Nodes are only ever appended; passes replace operands and leave dead nodes out of the list.
#pragma once

#include "shading/vm/program.hpp"

#include <array>
#include <compare>
#include <cstdint>
#include <vector>

namespace aluminate::compiler {

using NodeId = std::uint32_t;

/// One component of one node. Absolute is applied before negate, as in the instruction set.
struct Ref {
  NodeId node = 0;
  std::uint8_t lane = 0;
  bool negate = false;
  bool absolute = false;
  auto operator<=>(const Ref&) const = default;
};

constexpr Ref operator-(Ref r) {
  r.negate = !r.negate;
  return r;
}
constexpr Ref absolute(Ref r) { return {r.node, r.lane, false, true}; }

/// Up to four components: an operand or a vector value.
struct Lanes {
  std::array<Ref, 4> at{};
  std::uint8_t size = 0;

  Lanes() = default;
  Lanes(Ref r) : size(1) { at[0] = r; }  // a scalar is a vector of one
  void push(Ref r) { at[size++] = r; }
  Ref operator[](int i) const { return at[static_cast<std::size_t>(i)]; }
  Ref& operator[](int i) { return at[static_cast<std::size_t>(i)]; }
  const Ref* begin() const { return at.data(); }
  const Ref* end() const { return at.data() + size; }
  Ref* begin() { return at.data(); }
  Ref* end() { return at.data() + size; }
  bool operator==(const Lanes& o) const {
    if (size != o.size) return false;
    for (int i = 0; i < size; ++i)
      if (!((*this)[i] == o[i])) return false;
    return true;
  }
};

Lanes splat(Ref r, int width);
Lanes negated(Lanes v);

/// Any shape: vectors, matrices column by column, arrays and structs member by member, all flattened.
using Tuple = std::vector<Ref>;

enum class NodeKind : std::uint8_t {
  Constant,     // value; lane 0
  Input,        // register index
  Uniform,      // register index, address
  Table,        // register index into Ir::table, address
  Counter,      // iteration number of loop `index`
  Variable,     // register that copies write: joins of control flow and loop-carried values
  Instruction,  // op
};

/// Where an instruction puts its result.
enum class Sink : std::uint8_t { Value, Variable, Output, None };

/// register = Node::index + scale * value, at most Node::index + limit - 1.
struct Address {
  enum class Base : std::uint8_t { None, Counter, Value } base = Base::None;
  Ref value{};             // Value: floored
  std::uint32_t loop = 0;  // Counter
  std::uint16_t scale = 1;
  std::uint16_t limit = 0;
  bool operator==(const Address&) const = default;
};

struct Node {
  NodeKind kind = NodeKind::Instruction;
  vm::Opcode op = vm::Opcode::Mov;
  Sink sink = Sink::Value;
  bool saturate = false;
  std::uint8_t width = 1;  // components of the result
  std::array<Lanes, 3> src{};
  double value = 0;                       // Constant
  std::uint32_t index = 0;                // register; loop id of Counter and Loop; sampler of a fetch
  Address address{};                      // Uniform, Table
  NodeId target = 0;                      // Sink::Variable: the variable; Sink::Output: the output register
  std::array<std::uint8_t, 4> lane_to{};  // Sink::Variable, Output: component written by each lane
  std::int32_t trip_count = -1;           // Loop
  std::uint32_t loop = 0;                 // innermost loop around it, 0 = none
  vm::SourceLine line{};
};

struct Ir {
  std::vector<Node> nodes;
  std::vector<NodeId> order;                 // instructions, in source order
  std::vector<std::array<double, 4>> table;  // constant arrays that are indexed at run time
};

inline bool is_instruction(const Node& n) { return n.kind == NodeKind::Instruction; }
inline bool is_flow(const Node& n) { return is_instruction(n) && vm::info(n.op).pipe == vm::Pipe::Flow; }
bool is_kill(vm::Opcode op);
bool is_fetch(vm::Opcode op);    // texture and quad difference operations: their operands take no modifiers
bool is_texture(vm::Opcode op);  // four components, each where the texture unit puts it
/// One result whatever the operand width: dot products and everything the scalar pipe does.
bool is_reduction(vm::Opcode op);
bool is_scalar_pipe(vm::Opcode op);
/// Operand components that lane `lane` of the result does not need can be dropped: true for per-component
/// operations.
inline bool is_componentwise(vm::Opcode op) { return !is_reduction(op) && !is_texture(op); }
/// True when the node's instruction must stay whatever reads its result.
bool has_effect(const Node& n);

/// Calls f(Lanes&) for every operand, and f(Lanes&) with the address value when there is one.
template <class Function>
void for_each_source(Node& n, Function f) {
  if (n.kind == NodeKind::Instruction) {
    for (int i = 0; i < vm::info(n.op).sources; ++i) f(n.src[static_cast<std::size_t>(i)]);
  } else if (n.address.base == Address::Base::Value) {
    Lanes a(n.address.value);
    f(a);
    n.address.value = a[0];
  }
}

}  // namespace aluminate::compiler
