// One basic block as the Xenos scheduler sees it: operations on single components, copies already forwarded,
// each result named by the node that makes it. Registers do not exist yet; what must share one register is a
// group. Built by xenos_lowering, ordered by schedule, placed by xenos_registers.
#pragma once

#include "shading/vm/program.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace aluminate::cost {

/// One component read.
struct Ref {
  enum class Kind : std::uint8_t {
    Node,      // lane `component` of nodes[index]
    Input,     // v[index]
    Home,      // temp register `index` on entry to the block
    Constant,  // uniform or literal array register, maybe relative
    Literal,   // the number `value`: the assembler may place it in any constant register
    Counter,   // aL of loop nest `index`
  };
  Kind kind = Kind::Literal;
  std::uint8_t component = 0;
  vm::RegisterFile file = vm::RegisterFile::Uniform;  // Constant: Uniform or Literal (arrays only)
  std::uint32_t index = 0;
  double value = 0.0;
  vm::Relative relative{};  // Constant; a Temp base is replaced by the node below
  int address_node = -1;    // Constant: node that loads the address register
  bool operator==(const Ref&) const = default;

  bool is_constant() const {
    return kind == Kind::Constant || kind == Kind::Literal || kind == Kind::Counter;
  }
};

/// Up to four components read from one register through a swizzle; negate and absolute hold for all of them.
struct Operand {
  std::array<Ref, 4> refs{};
  int count = 0;
  bool negate = false, absolute = false;
  bool operator==(const Operand&) const = default;
};

/// Operations the program does not name.
enum class Special : std::uint8_t {
  None,
  Cube,          // face selection: x, y on the face, 2*major axis, face
  SetPredicate,  // condition of If, Break, Continue; issues alone [IR2]
  LoadAddress,   // address register for relative constants
  FetchSetup,    // extra fetch word: set LOD, set gradient
};

enum class DestKind : std::uint8_t {
  Value,
  Export,
  Home,
  Effect
};  // Effect: kill, predicate, address: no register

struct Node {
  vm::Opcode op = vm::Opcode::Mov;
  Special special = Special::None;
  bool saturate = false;
  bool removed = false;
  int width = 1;  // result lanes; dot products and scalar operations have 1
  int sources = 1;
  std::array<Operand, 3> src{};
  DestKind dest = DestKind::Value;
  std::uint16_t dest_index = 0;  // Export: o#; Home: temp
  std::array<std::int8_t, 4> dest_lane = {-1, -1, -1,
                                          -1};  // Export, Home: lane written to component c, -1 = none
  std::array<std::uint8_t, 4> texel_component = {0, 1, 2, 3};  // fetch: texel component of each lane
  std::array<double, 4> export_values{};                       // the values of export_constants
  std::uint8_t export_constants = 0;  // Export: components that are 0 or 1 for free through the write masks
  int after = -1;                     // effect that must issue earlier: a FetchSetup
  std::uint8_t sampler = 0;
  std::uint32_t origin = 0;  // index in Program::code; the first one for merged operations
  vm::SourceLine line{};

  bool is_fetch() const {
    return special == Special::FetchSetup ||
           (special == Special::None && vm::info(op).pipe == vm::Pipe::Fetch);
  }
  /// One result from several components: its operands have a fixed number of refs.
  bool is_reduction() const {
    return op == vm::Opcode::Dp2Add || op == vm::Opcode::Dp3 || op == vm::Opcode::Dp4 ||
           special == Special::Cube;
  }
};

/// Nodes whose results live in one vec4 register. Widths add up to at most four.
class RegisterGroups {
 public:
  int find(int node) const {
    while (parent_[static_cast<std::size_t>(node)] != node) node = parent_[static_cast<std::size_t>(node)];
    return node;
  }
  void add(int width) {
    parent_.push_back(static_cast<int>(parent_.size()));
    width_.push_back(width);
  }
  int width(int node) const { return width_[static_cast<std::size_t>(find(node))]; }
  void set_width(int node, int width) { width_[static_cast<std::size_t>(find(node))] = width; }
  bool can_merge(int a, int b) const { return find(a) == find(b) || width(a) + width(b) <= 4; }
  void merge(int a, int b) {
    a = find(a);
    b = find(b);
    if (a == b) return;
    if (b < a) std::swap(a, b);
    parent_[static_cast<std::size_t>(b)] = a;
    width_[static_cast<std::size_t>(a)] += width_[static_cast<std::size_t>(b)];
  }

 private:
  std::vector<int> parent_, width_;
};

struct Graph {
  std::vector<Node> nodes;
  RegisterGroups groups;  // parallel to nodes
  std::vector<std::pair<int, int>>
      write_after_read;  // (reader, writer): reader issues in the same word or earlier
  bool has_export = false;

  int add(Node node) {
    groups.add(node.width);
    nodes.push_back(std::move(node));
    return static_cast<int>(nodes.size()) - 1;
  }
};

/// Nodes an operation needs first: operands, address loads and fetch set-up.
template <class Visit>
void for_each_dependency(const Node& node, Visit&& visit) {
  for (int s = 0; s < node.sources; ++s) {
    const Operand& operand = node.src[static_cast<std::size_t>(s)];
    for (int i = 0; i < operand.count; ++i) {
      const Ref& ref = operand.refs[static_cast<std::size_t>(i)];
      if (ref.kind == Ref::Kind::Node) visit(static_cast<int>(ref.index));
      if (ref.address_node >= 0) visit(ref.address_node);
    }
  }
  if (node.after >= 0) visit(node.after);
}

}  // namespace aluminate::cost
