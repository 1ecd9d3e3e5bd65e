#include "shading/cost/slot_choice.hpp"

#include "shading/cost/xenos_packing.hpp"
#include "shading/cost/xenos_rewrite.hpp"

namespace aluminate::cost {
namespace {

using vm::Opcode;

/// An export word names one export register for both halves; an effect writes nothing.
bool destinations_agree(const Node& v, const Node& s) {
  const bool v_export = v.dest == DestKind::Export, s_export = s.dest == DestKind::Export;
  if (v_export == s_export && (!v_export || v.dest_index == s.dest_index)) return true;
  return !((v_export && s.dest != DestKind::Effect) || (s_export && v.dest != DestKind::Effect));
}

}  // namespace

SlotChoice slots_of(const Graph& graph, const Node& node, PairingRule pairing) {
  SlotChoice choice;
  if (node.is_fetch()) return choice;
  const vm::Pipe pipe = node.special == Special::None ? vm::info(node.op).pipe : vm::Pipe::Vector;
  choice.vector = pipe != vm::Pipe::Scalar;
  choice.scalar = fits_scalar_half(graph, node);
  if (pairing == PairingRule::Loose && pipe == vm::Pipe::Either && node.width == 1) choice.scalar = true;
  choice.two_slots = !choice.scalar && node.width == 1 && node.special == Special::None &&
                     (node.op == Opcode::Mul || node.op == Opcode::Add) &&
                     !node.src[0].refs[0].is_constant() && !node.src[1].refs[0].is_constant();
  choice.alone = node.special == Special::SetPredicate ||
                 (pairing == PairingRule::Strict && choice.vector && node.sources == 3);
  return choice;
}

int carried_operand(const Graph& graph, const Node& node) {
  const auto made_late = [&](const Operand& operand) {
    return operand.refs[0].kind == Ref::Kind::Node && !graph.nodes[operand.refs[0].index].is_fetch();
  };
  const bool late0 = made_late(node.src[0]), late1 = made_late(node.src[1]);
  if (late0 != late1) return late0 ? 1 : 0;
  return node.src[0].refs[0].index <= node.src[1].refs[0].index ? 0 : 1;
}

PairRules::PairRules(const Graph& graph, PairingRule pairing) : graph_(graph) {
  const std::size_t size = graph.nodes.size();
  slots_.reserve(size);
  for (const Node& node : graph.nodes)
    slots_.push_back(node.removed ? SlotChoice{} : slots_of(graph, node, pairing));
  const ConstantUse constants(graph);
  legal_.assign(size * size, 0);
  for (std::size_t v = 0; v < size; ++v) {
    if (!slots_[v].vector || slots_[v].alone) continue;
    for (std::size_t s = 0; s < size; ++s) {
      if (s == v || (!slots_[s].scalar && !slots_[s].two_slots)) continue;
      legal_[v * size + s] = destinations_agree(graph.nodes[v], graph.nodes[s]) &&
                             constants.registers(static_cast<int>(v), static_cast<int>(s)) <= 2;
    }
  }
}

}  // namespace aluminate::cost
