// Arithmetic the machine has shorter forms for: sqrt, doubling by addition, dp2add.
#include "shading/cost/xenos_rewriter.hpp"

namespace aluminate::cost {
namespace {

using vm::Opcode;

bool all_literal(const Operand& operand, double number) {
  for (int i = 0; i < operand.count; ++i) {
    const Ref& ref = operand.refs[static_cast<std::size_t>(i)];
    if (ref.kind != Ref::Kind::Literal || ref.value != number) return false;
  }
  return operand.count > 0;
}

bool is_lane(const Operand& operand, Opcode op, const Graph& graph) {
  return operand.count == 1 && operand.refs[0].kind == Ref::Kind::Node && !operand.absolute &&
         graph.nodes[operand.refs[0].index].op == op &&
         graph.nodes[operand.refs[0].index].special == Special::None;
}

}  // namespace

void Rewriter::fold_roots() {
  std::vector<int> uses = all_uses();
  for (Node& node : graph_.nodes) {
    if (node.removed || node.special != Special::None || node.width != 1) continue;
    const bool reciprocal =
        node.op == Opcode::Rcp && is_lane(node.src[0], Opcode::Rsq, graph_) && !node.src[0].negate;
    if (reciprocal && uses[node.src[0].refs[0].index] == 1) {
      const Operand inner = graph_.nodes[node.src[0].refs[0].index].src[0];
      node.op = Opcode::Sqrt;
      node.src[0] = inner;
      continue;
    }
    if (node.op != Opcode::Mul) continue;
    for (std::size_t s = 0; s < 2; ++s) {
      if (!is_lane(node.src[s], Opcode::Rsq, graph_) || node.src[s].negate ||
          uses[node.src[s].refs[0].index] != 1)
        continue;
      const Node& root = graph_.nodes[node.src[s].refs[0].index];
      if (root.saturate || !(root.src[0] == node.src[1 - s])) continue;
      node.op = Opcode::Sqrt;
      node.src[0] = root.src[0];
      node.sources = 1;
      break;
    }
  }
}

void Rewriter::fold_doubling() {
  for (Node& node : graph_.nodes) {
    if (node.removed || node.op != Opcode::Mul || node.special != Special::None) continue;
    for (std::size_t s = 0; s < 2; ++s) {
      const Operand& other = node.src[1 - s];
      if (!all_literal(node.src[s], node.src[s].negate ? -2.0 : 2.0) || node.src[s].absolute ||
          other.refs[0].is_constant())
        continue;
      const Operand doubled = other;
      node.op = Opcode::Add;
      node.src[0] = node.src[1] = doubled;
      break;
    }
  }
}

void Rewriter::fold_dot_products() {
  std::vector<int> uses = all_uses();
  for (Node& outer : graph_.nodes) {
    if (outer.removed || outer.op != Opcode::Mad || outer.special != Special::None || outer.width != 1)
      continue;
    const Operand addend = outer.src[2];
    if (addend.refs[0].kind != Ref::Kind::Node || addend.absolute) continue;
    Node& inner = graph_.nodes[addend.refs[0].index];
    const bool product = inner.op == Opcode::Mad || inner.op == Opcode::Mul;
    if (!product || inner.special != Special::None || inner.width != 1 || inner.saturate ||
        inner.dest != DestKind::Value || uses[addend.refs[0].index] != 1) {
      continue;
    }
    if (fold_pair(outer, inner, addend.negate)) inner.removed = true;
  }
}

bool Rewriter::fold_pair(Node& outer, const Node& inner, bool subtract) {
  for (std::size_t s = 0; s < 2; ++s) {
    if (outer.src[s].absolute || inner.src[s].absolute) return false;
  }
  const bool outer_sign = outer.src[0].negate != outer.src[1].negate;
  const bool inner_sign = (inner.src[0].negate != inner.src[1].negate) != subtract;
  if (outer_sign != inner_sign) return false;
  for (int order = 0; order < 2; ++order) {
    const Operand& first = inner.src[static_cast<std::size_t>(order)];
    const Operand& second = inner.src[static_cast<std::size_t>(1 - order)];
    RegisterGroups groups = graph_.groups;
    if (!share(groups, first.refs[0], outer.src[0].refs[0]) ||
        !share(groups, second.refs[0], outer.src[1].refs[0]))
      continue;
    graph_.groups = groups;
    Node dot = outer;
    dot.op = Opcode::Dp2Add;
    dot.src[0] = pair_of(first.refs[0], outer.src[0].refs[0], outer_sign);
    dot.src[1] = pair_of(second.refs[0], outer.src[1].refs[0], false);
    if (inner.op == Opcode::Mad) {
      dot.src[2] = inner.src[2];
      if (subtract && dot.src[2].refs[0].kind == Ref::Kind::Literal) {
        dot.src[2].refs[0].value = 0.0 - dot.src[2].refs[0].value;
      } else {
        dot.src[2].negate ^= subtract;
      }
    } else {
      dot.src[2] = Operand{};
      dot.src[2].count = 1;
    }
    outer = dot;
    return true;
  }
  return false;
}

Operand Rewriter::pair_of(const Ref& x, const Ref& y, bool negate) {
  Operand operand;
  operand.count = 2;
  operand.refs[0] = x;
  operand.refs[1] = y;
  operand.negate = negate;
  return operand;
}

bool Rewriter::share(RegisterGroups& groups, const Ref& a, const Ref& b) const {
  return share_register(graph_, groups, a, b);
}

}  // namespace aluminate::cost
