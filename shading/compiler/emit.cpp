#include "shading/compiler/emit.hpp"

#include "platform/host/error.hpp"
#include "shading/compiler/registers.hpp"

#include <algorithm>
#include <optional>

namespace aluminate::compiler {

using vm::Opcode;
using vm::RegisterFile;

namespace {

constexpr int kMaxRegisters = 0xffff;

class Emitter {
 public:
  explicit Emitter(Lowered lowered) : ir_(std::move(lowered.ir)), p_(std::move(lowered.symbols)) {}

  vm::Program run() {
    places_ = assign_registers(ir_, p_.temp_count);
    p_.literals = ir_.table;
    open_slots_.assign(ir_.table.size(), 4);
    for (NodeId id : ir_.order) instruction(ir_.nodes[id]);
    trim_inputs();
    trim_outputs();
    if (p_.temp_count > kMaxRegisters || p_.literals.size() > kMaxRegisters)
      throw UserError(
          fmt::format("the shader needs {} registers and {} literals", p_.temp_count, p_.literals.size()),
          fmt::format("the limit is {} of each", kMaxRegisters));
    return std::move(p_);
  }

 private:
  std::optional<double> number(Ref r) const {
    const Node& n = ir_.nodes[r.node];
    if (n.kind != NodeKind::Constant) return std::nullopt;
    const double v = r.absolute && n.value < 0 ? -n.value : n.value;
    return (r.negate ? -v : v) + 0.0;
  }

  // A literal register that holds all the values; `component` receives where each lies.
  int literal(const std::vector<double>& values, std::array<std::uint8_t, 4>& component) {
    const auto find_in = [&](std::size_t reg, bool extend) {
      auto row = p_.literals[reg];
      int used = open_slots_[reg];
      for (std::size_t k = 0; k < values.size(); ++k) {
        int at = 0;
        while (at < used && row[static_cast<std::size_t>(at)] != values[k]) ++at;
        if (at == used) {
          if (!extend || used == 4) return false;
          row[static_cast<std::size_t>(used++)] = values[k];
        }
        component[k] = static_cast<std::uint8_t>(at);
      }
      p_.literals[reg] = row;
      open_slots_[reg] = used;
      return true;
    };
    const std::size_t first = ir_.table.size();
    for (bool extend : {false, true})
      for (std::size_t reg = first; reg < p_.literals.size(); ++reg)
        if (find_in(reg, extend)) return static_cast<int>(reg);
    p_.literals.push_back({0, 0, 0, 0});
    open_slots_.push_back(0);
    ALU_CHECK(find_in(p_.literals.size() - 1, true), "five literals in one operand");
    return static_cast<int>(p_.literals.size() - 1);
  }

  // The operand whose lane k is read for component at[k] of the instruction.
  vm::Source source(const Lanes& v, const std::array<int, 4>& at) {
    vm::Source s;
    std::array<std::uint8_t, 4> component{};
    const Ref first = v[0];
    const Node& n = ir_.nodes[first.node];
    if (n.kind == NodeKind::Constant) {
      std::vector<double> values;
      std::array<std::uint8_t, 4> where{};
      std::array<std::size_t, 4> which{};
      for (int i = 0; i < v.size; ++i) {
        const double value = *number(v[i]);
        const auto it = std::find(values.begin(), values.end(), value);
        which[static_cast<std::size_t>(i)] = static_cast<std::size_t>(it - values.begin());
        if (it == values.end()) values.push_back(value);
      }
      s.file = RegisterFile::Literal;
      s.index = static_cast<std::uint16_t>(literal(values, where));
      for (int i = 0; i < v.size; ++i)
        component[static_cast<std::size_t>(i)] = where[which[static_cast<std::size_t>(i)]];
    } else {
      s.negate = first.negate;
      s.absolute = first.absolute;
      if (auto place = places_.find(first.node); place != places_.end()) {
        s.file = RegisterFile::Temp;
        s.index = static_cast<std::uint16_t>(place->second.reg);
        for (int i = 0; i < v.size; ++i)
          component[static_cast<std::size_t>(i)] = places_.at(v[i].node).component[v[i].lane];
      } else {
        for (int i = 0; i < v.size; ++i) component[static_cast<std::size_t>(i)] = v[i].lane;
        s.index = static_cast<std::uint16_t>(n.index);
        switch (n.kind) {
          case NodeKind::Input:
            s.file = RegisterFile::Input;
            break;
          case NodeKind::Uniform:
            s.file = RegisterFile::Uniform;
            break;
          case NodeKind::Table:
            s.file = RegisterFile::Literal;
            break;
          case NodeKind::Counter:
            s.file = RegisterFile::LoopCounter;
            s.index = nest_of(n.index);
            break;
          default:
            ALU_CHECK(false, "node {} has no place", first.node);
        }
        if (n.address.base == Address::Base::Counter) {
          s.relative = {vm::RelativeBase::LoopCounter, nest_of(n.address.loop), 0, n.address.scale,
                        n.address.limit};
        } else if (n.address.base == Address::Base::Value) {
          const Ref a = n.address.value;
          const Place& place_of = places_.at(a.node);
          s.relative = {vm::RelativeBase::Temp, static_cast<std::uint16_t>(place_of.reg),
                        place_of.component[a.lane], n.address.scale, n.address.limit};
        }
      }
    }
    s.swizzle.fill(component[0]);
    for (int i = 0; i < v.size; ++i)
      if (at[static_cast<std::size_t>(i)] >= 0)
        s.swizzle[static_cast<std::size_t>(at[static_cast<std::size_t>(i)])] =
            component[static_cast<std::size_t>(i)];
    return s;
  }

  std::uint16_t nest_of(std::uint32_t loop) const {
    const auto it = std::find(nest_.begin(), nest_.end(), loop);
    ALU_CHECK(it != nest_.end(), "loop counter {} read outside its loop", loop);
    return static_cast<std::uint16_t>(it - nest_.begin());
  }

  void instruction(const Node& n) {
    vm::Instruction i;
    i.op = n.op;
    i.saturate = n.saturate;
    i.line = n.line;
    std::array<int, 4> at{-1, -1, -1, -1};  // component of the instruction that each operand lane belongs to
    if (n.sink == Sink::None) {
      at[0] = 0;
      i.trip_count = n.op == Opcode::Loop ? n.trip_count : -1;
    } else {
      std::array<std::uint8_t, 4> to = n.lane_to;
      Place place;
      if (n.sink == Sink::Output) {
        place.output = true;
        place.reg = static_cast<int>(n.target);
      } else if (n.sink == Sink::Variable) {
        place = places_.at(n.target);
        for (int l = 0; l < n.width; ++l)
          to[static_cast<std::size_t>(l)] = place.component[n.lane_to[static_cast<std::size_t>(l)]];
      } else {
        place = places_.at(static_cast<NodeId>(&n - ir_.nodes.data()));
        to = place.component;
      }
      i.dst.file = place.output ? RegisterFile::Output : RegisterFile::Temp;
      i.dst.index = static_cast<std::uint16_t>(place.reg);
      for (int l = 0; l < n.width; ++l)
        i.dst.mask |= static_cast<std::uint8_t>(1u << to[static_cast<std::size_t>(l)]);
      if (is_texture(n.op)) {
        i.sampler = static_cast<std::uint8_t>(n.index);
        i.dst.mask = texture_mask(static_cast<NodeId>(&n - ir_.nodes.data()));
        at = {0, 1, 2, 3};
      } else if (is_scalar_pipe(n.op)) {
        at[0] = 0;
      } else if (is_reduction(n.op)) {
        at = {0, 1, 2, 3};
      } else {
        for (int l = 0; l < n.width; ++l) at[static_cast<std::size_t>(l)] = to[static_cast<std::size_t>(l)];
      }
    }
    if (n.op == Opcode::Loop) nest_.push_back(n.index);
    if (n.op == Opcode::EndLoop) nest_.pop_back();
    for (int k = 0; k < vm::info(n.op).sources; ++k) {
      const Lanes& v = n.src[static_cast<std::size_t>(k)];
      // The addend of dp2add and gradients have fewer components than the other operands.
      i.src[static_cast<std::size_t>(k)] = source(v, at);
    }
    if (n.op == Opcode::EndIf) {  // copies that needed no instruction may have been all there was
      if (!p_.code.empty() && p_.code.back().op == Opcode::Else) p_.code.pop_back();
      if (!p_.code.empty() && p_.code.back().op == Opcode::If) {
        p_.code.pop_back();
        return;
      }
    }
    p_.code.push_back(i);
  }

  std::uint8_t texture_mask(NodeId id) {
    if (texture_lanes_.empty())
      for (NodeId user : ir_.order)
        for_each_source(ir_.nodes[user], [&](Lanes& v) {
          for (Ref r : v) {
            texture_lanes_[r.node] |= static_cast<std::uint8_t>(1u << r.lane);
            Node& leaf = ir_.nodes[r.node];
            if (!is_instruction(leaf) && leaf.address.base == Address::Base::Value)
              texture_lanes_[leaf.address.value.node] |=
                  static_cast<std::uint8_t>(1u << leaf.address.value.lane);
          }
        });
    return texture_lanes_[id];
  }

  // Inputs nobody reads cost an interpolator for nothing; the rest keep their order.
  void trim_inputs() {
    std::vector<std::uint8_t> read(p_.inputs.size(), 0);
    for (const vm::Instruction& i : p_.code)
      for (int k = 0; k < vm::info(i.op).sources; ++k) {
        const vm::Source& s = i.src[static_cast<std::size_t>(k)];
        if (s.file == RegisterFile::Input)
          for (std::uint8_t c : s.swizzle) read[s.index] |= static_cast<std::uint8_t>(1u << c);
      }
    std::vector<std::uint16_t> renumbered(p_.inputs.size(), 0);
    std::vector<vm::InputSymbol> kept;
    for (std::size_t v = 0; v < p_.inputs.size(); ++v) {
      if (read[v] == 0) continue;
      renumbered[v] = static_cast<std::uint16_t>(kept.size());
      kept.push_back({p_.inputs[v].semantic, read[v]});
    }
    for (vm::Instruction& i : p_.code)
      for (int k = 0; k < vm::info(i.op).sources; ++k) {
        vm::Source& s = i.src[static_cast<std::size_t>(k)];
        if (s.file == RegisterFile::Input) s.index = renumbered[s.index];
      }
    p_.inputs = std::move(kept);
  }

  void trim_outputs() {
    std::vector<std::uint8_t> written(p_.outputs.size(), 0);
    for (const vm::Instruction& i : p_.code)
      if (i.dst.file == RegisterFile::Output && i.dst.mask != 0) written[i.dst.index] |= i.dst.mask;
    std::vector<std::uint16_t> renumbered(p_.outputs.size(), 0);
    std::vector<vm::OutputSymbol> kept;
    for (std::size_t o = 0; o < p_.outputs.size(); ++o) {
      if (written[o] == 0) continue;
      renumbered[o] = static_cast<std::uint16_t>(kept.size());
      kept.push_back({p_.outputs[o].semantic, written[o]});
    }
    for (vm::Instruction& i : p_.code)
      if (i.dst.file == RegisterFile::Output) i.dst.index = renumbered[i.dst.index];
    p_.outputs = std::move(kept);
  }

  Ir ir_;
  vm::Program p_;
  std::map<NodeId, Place> places_;
  std::vector<int> open_slots_;
  std::vector<std::uint32_t> nest_;
  std::map<NodeId, std::uint8_t> texture_lanes_;
};

}  // namespace

vm::Program emit(Lowered lowered) { return Emitter(std::move(lowered)).run(); }

}  // namespace aluminate::compiler
