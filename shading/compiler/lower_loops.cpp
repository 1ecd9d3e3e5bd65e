// Loops: trip counts, machine loops with copies on the back edge, and unrolling by walking the body again.
#include "shading/compiler/lowerer.hpp"
#include "shading/compiler/spirv_passes.hpp"

#include <spirv/unified1/spirv.hpp11>

#include <algorithm>

namespace aluminate::compiler {

using vm::Opcode;

namespace {

spv::Op op_of(const SpirvInstruction& i) { return static_cast<spv::Op>(i.op); }

// Both sides as numbers; nothing when the operation is no comparison.
std::optional<bool> compare(spv::Op op, double a, double b) {
  switch (op) {
    case spv::Op::OpSLessThan:
    case spv::Op::OpULessThan:
    case spv::Op::OpFOrdLessThan:
    case spv::Op::OpFUnordLessThan:
      return a < b;
    case spv::Op::OpSLessThanEqual:
    case spv::Op::OpULessThanEqual:
    case spv::Op::OpFOrdLessThanEqual:
    case spv::Op::OpFUnordLessThanEqual:
      return a <= b;
    case spv::Op::OpSGreaterThan:
    case spv::Op::OpUGreaterThan:
    case spv::Op::OpFOrdGreaterThan:
    case spv::Op::OpFUnordGreaterThan:
      return a > b;
    case spv::Op::OpSGreaterThanEqual:
    case spv::Op::OpUGreaterThanEqual:
    case spv::Op::OpFOrdGreaterThanEqual:
    case spv::Op::OpFUnordGreaterThanEqual:
      return a >= b;
    case spv::Op::OpIEqual:
    case spv::Op::OpFOrdEqual:
      return a == b;
    case spv::Op::OpINotEqual:
    case spv::Op::OpFUnordNotEqual:
    case spv::Op::OpFOrdNotEqual:
      return a != b;
    default:
      return std::nullopt;
  }
}

}  // namespace

// ---- a loop that runs once
// -----------------------------------------------------------------------------------------

Lowerer::OnceLoop::OnceLoop(Lowerer& owner, SpvId label, const std::unordered_set<SpvId>& inside) : l(owner) {
  l.open_flags(inside, label, flags);
  l.open_machine_loop(1, {});
  l.exits_.push_back({label, false, l.machine_depth_, 0});
}

void Lowerer::OnceLoop::close() {
  l.exits_.pop_back();
  l.close_machine_loop();
  l.pass_on_flags(flags);
}

std::uint32_t Lowerer::open_machine_loop(int trips, const Counted& counted) {
  const std::uint32_t id = next_loop_id_++;
  counters_.push_back(counted);
  const NodeId node = b_.flow(Opcode::Loop);
  out_.ir.nodes[node].trip_count = trips;
  out_.ir.nodes[node].index = id;
  b_.push_scope();
  b_.enter_loop(id);
  ++machine_depth_;
  return id;
}

void Lowerer::close_machine_loop() {
  --machine_depth_;
  b_.leave_loop();
  b_.pop_scope();
  b_.flow(Opcode::EndLoop);
}

// A jump that crosses more than one machine loop raises a flag and breaks; each loop left on the way passes
// it on.
void Lowerer::open_flags(const std::unordered_set<SpvId>& inside, SpvId own, std::vector<SpvId>& opened) {
  for (const Exit& e : exits_) {
    if (e.label == own || e.depth < 0) continue;
    bool jumps = false;
    for (SpvId label : inside)
      for (SpvId next : successors(m_.block(label))) jumps = jumps || next == e.label;
    if (!jumps) continue;
    if (!flags_.contains(e.label)) flags_[e.label] = b_.variable(1);
    b_.write(Sink::Variable, flags_[e.label], num(0), {0});
    opened.push_back(e.label);
  }
}

void Lowerer::pass_on_flags(const std::vector<SpvId>& opened) {
  for (SpvId label : opened) {
    const Exit* exit = find_exit(label);
    ALU_CHECK(exit != nullptr, "flag without an exit");
    const Ref raised{flags_.at(label), 0};
    const bool direct = exit->depth == machine_depth_;
    b_.flow(direct && exit->is_continue ? Opcode::Continue : Opcode::Break, raised);
    if (direct) flags_.erase(label);
  }
}

// ---- trip counts
// ---------------------------------------------------------------------------------------------------

bool Lowerer::used_outside(const std::set<SpvId>& ids, const std::unordered_set<SpvId>& inside) const {
  spend(m_.blocks().size());
  for (const SpirvBlock& block : m_.blocks()) {
    if (inside.contains(block.label)) continue;
    for (const SpirvInstruction& i : block.code)
      for (std::uint32_t word : i.operands)
        if (ids.contains(word)) return true;
  }
  return false;
}

std::optional<Lowerer::Counted> Lowerer::count_trips(SpvId pred, SpvId header, SpvId merge,
                                                     const std::unordered_set<SpvId>& inside) {
  SpvId back = 0;
  for (SpvId label : inside)
    for (SpvId next : successors(m_.block(label)))
      if (next == header) back = label;
  if (back == 0) return std::nullopt;

  // The test: at the head, before anything else can happen, or at the back edge.
  Counted c;
  const auto leaves = [&](SpvId label) {
    const SpirvInstruction& t = m_.block(label).terminator();
    return op_of(t) == spv::Op::OpBranchConditional && (t.operands[1] == merge || t.operands[2] == merge);
  };
  bool at_head = true;
  for (SpvId label = header; inside.contains(label);) {
    if (leaves(label)) {
      c.exit_block = label;
      break;
    }
    const SpirvBlock& block = m_.block(label);
    if (op_of(block.terminator()) != spv::Op::OpBranch || block.terminator().operands[0] == header) break;
    label = block.terminator().operands[0];
  }
  if (c.exit_block == 0 || c.exit_block == back) {
    if (!leaves(back)) return std::nullopt;
    c.exit_block = back;
    at_head = false;
  }
  c.at_head = at_head;
  const SpirvInstruction& test = m_.block(c.exit_block).terminator();
  const bool stays_when = test.operands[2] == merge;
  c.stay = stays_when ? test.operands[1] : test.operands[2];
  if (c.stay == merge) return std::nullopt;

  const SpirvInstruction* condition = m_.definition(test.operands[0]);
  bool negate = false;
  while (condition != nullptr && op_of(*condition) == spv::Op::OpLogicalNot) {
    condition = m_.definition(condition->operands[0]);
    negate = !negate;
  }
  if (condition == nullptr || condition->operands.size() != 2) return std::nullopt;

  const auto known = [&](SpvId id) -> std::optional<double> {
    const SpirvInstruction* d = m_.definition(id);
    const bool constant =
        d != nullptr && (op_of(*d) == spv::Op::OpConstant || op_of(*d) == spv::Op::OpConstantNull);
    if (!constant && !values_.contains(id)) return std::nullopt;
    return b_.value_of(scalar(id));
  };

  for (const SpirvInstruction& phi : m_.block(header).code) {
    if (op_of(phi) != spv::Op::OpPhi) break;
    if (m_.scalar_count(phi.type) != 1) continue;
    SpvId init = 0, step_id = 0;
    for (std::size_t o = 0; o + 1 < phi.operands.size(); o += 2) {
      if (phi.operands[o + 1] == pred) init = phi.operands[o];
      if (phi.operands[o + 1] == back) step_id = phi.operands[o];
    }
    const SpirvInstruction* step = m_.definition(step_id);
    if (init == 0 || step == nullptr || !known(init)) continue;
    const bool subtracts = op_of(*step) == spv::Op::OpISub || op_of(*step) == spv::Op::OpFSub;
    if (!subtracts && op_of(*step) != spv::Op::OpIAdd && op_of(*step) != spv::Op::OpFAdd) continue;
    std::optional<double> by;
    if (step->operands[0] == phi.result)
      by = known(step->operands[1]);
    else if (step->operands[1] == phi.result && !subtracts)
      by = known(step->operands[0]);
    if (!by) continue;
    c.phi = phi.result;
    c.stepped = step_id;
    c.init = *known(init);
    c.step = subtracts ? -*by : *by;

    const auto side = [&](SpvId id, double count) -> std::optional<double> {
      if (id == c.phi) return c.init + c.step * count;
      if (id == c.stepped) return c.init + c.step * (count + 1);
      return known(id);
    };
    const auto reads_counter = [&](SpvId id) { return id == c.phi || id == c.stepped; };
    if (!reads_counter(condition->operands[0]) && !reads_counter(condition->operands[1])) continue;
    int trips = at_head ? 0 : 1;
    for (; trips <= kMaxTrips; ++trips) {
      spend(1);
      const double count = at_head ? trips : trips - 1;
      const auto x = side(condition->operands[0], count), y = side(condition->operands[1], count);
      if (!x || !y) return std::nullopt;
      const auto holds = compare(op_of(*condition), *x, *y);
      if (!holds) return std::nullopt;
      if ((*holds != negate) != stays_when) break;
    }
    if (trips > kMaxTrips) return std::nullopt;
    c.trips = trips;
    return c;
  }
  return std::nullopt;
}

// ---- loops
// ---------------------------------------------------------------------------------------------------------

void Lowerer::loop(SpvId pred, SpvId header) {
  const SpirvInstruction& merge_instruction = *m_.block(header).merge();
  const SpvId merge = merge_instruction.operands[0], cont = merge_instruction.operands[1];
  const bool asked = (merge_instruction.operands[2] & kUnrollRequested) != 0;
  std::vector<SpvId> bounds{merge};
  for (const Exit& e : exits_) bounds.push_back(e.label);
  const auto inside = region(header, bounds);
  auto counted = count_trips(pred, header, merge, inside);

  bool breaks = false;  // jumps out other than the counting test
  for (SpvId label : inside)
    for (SpvId to : successors(m_.block(label)))
      if (!inside.contains(to) && !(counted && label == counted->exit_block)) breaks = true;
  if (counted && breaks) {
    // Left early, the counter and what the head computed would have to survive: keep such loops open.
    std::set<SpvId> at_head{counted->phi, counted->stepped};
    for (SpvId label = header; label != 0 && counted->at_head;
         label = label == counted->exit_block ? 0 : m_.block(label).terminator().operands[0])
      for (const SpirvInstruction& i : m_.block(label).code)
        if (i.result != 0 && op_of(i) != spv::Op::OpPhi) at_head.insert(i.result);
    if (op_of(m_.block(merge).code.front()) == spv::Op::OpPhi || used_outside(at_head, inside))
      counted.reset();
  }
  const bool unroll =
      counted && !breaks &&
      (counted->trips == 0 || loops_ == LoopMode::Unrolled || (loops_ == LoopMode::AsWritten && asked));
  open_loops_.insert(header);
  if (unroll) {
    unrolled_loop(pred, header, merge, cont, *counted);
  } else {
    std::vector<SpvId> kept;
    keep_in_registers(inside, kept);
    rolled_loop(pred, header, merge, cont, counted, breaks, inside);
    release_registers(kept);
  }
  open_loops_.erase(header);
  joins_.erase(header);
  next_pred_ = counted ? counted->exit_block : 0;
}

// One iteration: the body up to the continue block, then the continue block up to the header.
void Lowerer::iteration(SpvId pred, SpvId header, SpvId cont) {
  if (cont == header) {
    walk(pred, header, header, true);
    return;
  }
  open_join(cont);
  if (nestable(header, cont)) {
    walk(pred, header, cont);
  } else {
    std::vector<SpvId> bounds{cont};
    for (const Exit& e : exits_) bounds.push_back(e.label);
    const auto inside = region(header, bounds);
    std::vector<SpvId> kept;
    keep_in_registers(inside, kept);
    OnceLoop once(*this, cont, inside);
    walk(pred, header, cont);
    once.close();
    release_registers(kept);
  }
  walk(0, cont, header);
}

// What the head computes when the count is reached: values the code after the loop may read.
void Lowerer::final_head(SpvId pred, SpvId header, const Counted& counted) {
  if (!counted.at_head) return;
  for (SpvId label = header;; label = m_.block(label).terminator().operands[0]) {
    if (pred != 0) enter_block(pred, label);
    const SpirvBlock& block = m_.block(label);
    for (const SpirvInstruction& i : block.code) {
      if (op_of(i) == spv::Op::OpPhi) continue;
      if (&i == block.merge() || &i == &block.terminator()) break;
      instruction(i);
    }
    if (label == counted.exit_block) return;
    pred = label;
  }
}

void Lowerer::unrolled_loop(SpvId pred, SpvId header, SpvId merge, SpvId cont, const Counted& counted) {
  counted_[counted.exit_block] = counted;
  exits_.push_back({merge, false, -1, 0});  // never taken: bounds the body
  SpvId from = pred;
  for (int trip = 0; trip < counted.trips; ++trip) {
    iteration(from, header, cont);
    from = back_edge(header);
  }
  final_head(from, header, counted);
  exits_.pop_back();
  counted_.erase(counted.exit_block);
}

SpvId Lowerer::back_edge(SpvId header) const {
  const SpirvInstruction& merge = *m_.block(header).merge();
  for (SpvId label : region(header, {merge.operands[0]}))
    for (SpvId next : successors(m_.block(label)))
      if (next == header) return label;
  return 0;
}

void Lowerer::rolled_loop(SpvId pred, SpvId header, SpvId merge, SpvId cont,
                          const std::optional<Counted>& counted, bool breaks,
                          const std::unordered_set<SpvId>& inside) {
  open_join(header);
  if (counted) {  // the counter comes from the machine
    Join& join = joins_.at(header);
    const auto at = std::find(join.phis.begin(), join.phis.end(), counted->phi) - join.phis.begin();
    join.phis.erase(join.phis.begin() + at);
    join.variables.erase(join.variables.begin() + at);
    counted_[counted->exit_block] = *counted;
  }
  edge(pred, header);
  if (!counted) open_join(merge);

  std::vector<SpvId> flags;
  open_flags(inside, merge, flags);
  const std::uint32_t id = open_machine_loop(counted ? counted->trips : -1, counted.value_or(Counted{}));
  exits_.push_back({merge, false, machine_depth_, 0});
  if (counted) {
    const Lanes i = b_.add(b_.mul(b_.leaf(NodeKind::Counter, id, 0), num(counted->step)), num(counted->init));
    values_[counted->phi] = {i[0]};
  }

  // A continue block that only steps the counter needs no place of its own: Continue goes straight on.
  bool bare = counted && cont != header;
  int edges = 0;
  for (const SpirvInstruction& i : m_.block(cont).code) {
    if (op_of(i) == spv::Op::OpPhi) continue;
    if (&i == &m_.block(cont).terminator())
      bare = bare && op_of(i) == spv::Op::OpBranch;
    else
      bare = bare && i.result == counted->stepped;
  }
  for (SpvId label : inside)
    for (SpvId to : successors(m_.block(label))) edges += to == cont ? 1 : 0;
  if (bare && edges > 1) {
    exits_.push_back({cont, true, machine_depth_, header});
    walk(pred, header, 0);
    exits_.pop_back();
    const Node& last = out_.ir.nodes[out_.ir.order.back()];
    if (last.op == Opcode::Continue && b_.is_constant(last.src[0][0], 1)) out_.ir.order.pop_back();
  } else {
    iteration(pred, header, cont);
  }
  exits_.pop_back();
  close_machine_loop();
  if (counted) {
    counted_.erase(counted->exit_block);
    if (!breaks) {
      values_[counted->phi] = {
          num(counted->init + counted->step * (counted->trips - (counted->at_head ? 0 : 1)))};
      values_[counted->stepped] = {num(counted->init + counted->step * counted->trips)};
      final_head(0, header, *counted);
    }
  }
  pass_on_flags(flags);
}

}  // namespace aluminate::compiler
