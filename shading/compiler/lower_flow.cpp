// Control flow. SPIR-V's structured constructs become If/Else/EndIf and Loop/EndLoop; values that meet at a
// join are copied into a variable on every edge. A jump out of the middle (break, continue, an early return
// turned into a jump) is one of:
//   Break, Continue    when the label belongs to the innermost machine loop
//   nesting            when one side of an if always jumps to where the walk ends: the rest moves into the
//   other side a loop that runs once around the construct, left by Break, when neither fits
#include "shading/compiler/lowerer.hpp"

#include <spirv/unified1/spirv.hpp11>

#include <algorithm>

namespace aluminate::compiler {

using vm::Opcode;

namespace {

spv::Op op_of(const SpirvInstruction& i) { return static_cast<spv::Op>(i.op); }

}  // namespace

// Repeated walks (unrolling, cases that fall through, questions about blocks) multiply; this bounds them all.
void Lowerer::spend(std::size_t steps) const {
  spent_ += steps;
  if (spent_ > kMaxLoweringSteps)
    throw UserError(place(b_.line()), "the shader takes too much work to compile",
                    "unroll less: mark large loops [loop], or compile with rolled loops");
}

std::vector<SpvId> Lowerer::successors(const SpirvBlock& block) const {
  const SpirvInstruction& t = block.terminator();
  switch (op_of(t)) {
    case spv::Op::OpBranch:
      return {t.operands[0]};
    case spv::Op::OpBranchConditional:
      return {t.operands[1], t.operands[2]};
    case spv::Op::OpSwitch: {
      std::vector<SpvId> targets{t.operands[1]};
      for (std::size_t k = 3; k < t.operands.size(); k += 2) targets.push_back(t.operands[k]);
      return targets;
    }
    default:
      return {};
  }
}

// Blocks reachable from `first` without going through a bound; bounds are not part of it.
std::unordered_set<SpvId> Lowerer::region(SpvId first, const std::vector<SpvId>& bounds) const {
  std::unordered_set<SpvId> seen;
  std::vector<SpvId> open{first};
  while (!open.empty()) {
    const SpvId label = open.back();
    open.pop_back();
    if (std::find(bounds.begin(), bounds.end(), label) != bounds.end() || !seen.insert(label).second)
      continue;
    for (SpvId next : successors(m_.block(label))) open.push_back(next);
  }
  spend(seen.size());
  return seen;
}

// Which of merge, stop and the open exits control can reach from `label` first.
std::set<SpvId> Lowerer::exits_from(SpvId label, SpvId merge, SpvId stop) const {
  std::vector<SpvId> bounds;
  if (merge != 0) bounds.push_back(merge);
  if (stop != 0) bounds.push_back(stop);
  for (const Exit& e : exits_) bounds.push_back(e.label);
  std::set<SpvId> reached;
  const auto is_bound = [&](SpvId l) { return std::find(bounds.begin(), bounds.end(), l) != bounds.end(); };
  if (is_bound(label)) return {label};
  for (SpvId inside : region(label, bounds))
    for (SpvId next : successors(m_.block(inside)))
      if (is_bound(next)) reached.insert(next);
  return reached;
}

const Lowerer::Exit* Lowerer::find_exit(SpvId label) const {
  for (auto it = exits_.rbegin(); it != exits_.rend(); ++it)
    if (it->label == label) return &*it;
  return nullptr;
}

// True when every jump to `stop` on the way from `label` can be expressed by nesting.
bool Lowerer::nestable(SpvId label, SpvId stop) const {
  for (int steps = 0; steps < 100000; ++steps) {
    spend(1);
    if (label == stop || find_exit(label) != nullptr) return true;
    const SpirvBlock& block = m_.block(label);
    const SpirvInstruction* merge = block.merge();
    const SpirvInstruction& t = block.terminator();
    if (auto counted = counted_.find(label); counted != counted_.end()) {
      label = counted->second.stay;
      continue;
    }
    if (merge == nullptr || (op_of(*merge) == spv::Op::OpLoopMerge && open_loops_.contains(label))) {
      const auto next = successors(block);
      if (next.empty()) return true;
      if (next.size() == 1) {
        label = next[0];
        continue;
      }
      if (next.size() != 2) return false;
      if (find_exit(next[0]) != nullptr && next[0] != stop)
        label = next[1];
      else if (find_exit(next[1]) != nullptr && next[1] != stop)
        label = next[0];
      else
        return nestable(next[0], stop) && nestable(next[1], stop);
      continue;
    }
    const SpvId m = merge->operands[0];
    if ((op_of(*merge) == spv::Op::OpLoopMerge && !open_loops_.contains(label)) ||
        op_of(t) == spv::Op::OpSwitch) {
      const auto inside = region(label, {m});
      for (SpvId l : inside)
        for (SpvId next : successors(m_.block(l)))
          if (next == stop && stop != m) return false;
      label = m;
      continue;
    }
    const SpvId yes = t.operands[1], no = t.operands[2];
    const auto a = exits_from(yes, m, stop), b = exits_from(no, m, stop);
    const bool a_jumps = a.contains(stop) && stop != m, b_jumps = b.contains(stop) && stop != m;
    const bool a_falls = a.contains(m), b_falls = b.contains(m);
    if (!a_jumps && !b_jumps) {
      if (!a_falls && !b_falls) return true;
      label = m;
      continue;
    }
    if ((a_jumps && a_falls) || (b_jumps && b_falls)) return false;
    if (a_jumps && b_falls) return nestable(yes, stop) && nestable(no, stop);
    if (b_jumps && a_falls) return nestable(no, stop) && nestable(yes, stop);
    return nestable(yes, stop) && nestable(no, stop);
  }
  return false;
}

// ---- branches
// ------------------------------------------------------------------------------------------------------

void Lowerer::begin_if(Ref condition) {
  b_.flow(Opcode::If, condition);
  b_.push_scope();
}

void Lowerer::begin_else() {
  b_.pop_scope();
  b_.flow(Opcode::Else);
  b_.push_scope();
}

void Lowerer::end_if() {
  b_.pop_scope();
  std::vector<NodeId>& order = out_.ir.order;
  const auto last_is = [&](Opcode op) { return !order.empty() && out_.ir.nodes[order.back()].op == op; };
  if (last_is(Opcode::Else)) order.pop_back();  // nothing on the other side
  if (last_is(Opcode::If))
    order.pop_back();  // nothing at all
  else
    b_.flow(Opcode::EndIf);
}

// Follows blocks that only jump on to where they end: the last of them, and the label it jumps to.
std::pair<SpvId, SpvId> Lowerer::jump_target(SpvId from, SpvId label, SpvId stop, SpvId merge) const {
  while (label != stop && label != merge && find_exit(label) == nullptr) {
    const SpirvBlock& block = m_.block(label);
    if (block.code.size() != 1 || op_of(block.terminator()) != spv::Op::OpBranch) break;
    from = label;
    label = block.terminator().operands[0];
  }
  return {from, label};
}

// Leaves for an exit label under the current mask, or where `condition` holds.
void Lowerer::leave(const Exit& exit, SpvId from, std::optional<Ref> condition) {
  std::vector<std::pair<NodeId, Lanes>> copies = edge_copies(from, exit.label);
  if (exit.is_continue) {
    // The continue block holds nothing but the loop's own step: take its edge to the header as well.
    enter_block(from, exit.label);
    copies = edge_copies(exit.label, exit.header);
  }
  const bool direct = exit.depth == machine_depth_;
  const bool block = condition && (!copies.empty() || !direct);
  if (block) begin_if(*condition);
  parallel_copy(copies);
  if (!direct) {
    NodeId flag = flags_.at(exit.label);
    b_.write(Sink::Variable, flag, num(1), {0});
  }
  const Opcode op = direct && exit.is_continue ? Opcode::Continue : Opcode::Break;
  b_.flow(op, condition && !block ? *condition : num(1));
  if (block) end_if();
}

bool Lowerer::is_kill_block(SpvId label, SpvId merge) const {
  const SpirvBlock& block = m_.block(label);
  bool kills = false;
  for (const SpirvInstruction& i : block.code) switch (op_of(i)) {
      case spv::Op::OpKill:
      case spv::Op::OpTerminateInvocation:
        return true;
      case spv::Op::OpDemoteToHelperInvocation:
        kills = true;
        break;
      case spv::Op::OpFunctionCall:
        if (!m_.kills(i.operands[0])) return false;
        kills = true;
        break;
      case spv::Op::OpUnreachable:
        return kills;
      case spv::Op::OpBranch:
        return kills && i.operands[0] == merge && op_of(m_.block(merge).code.front()) != spv::Op::OpPhi;
      default:
        return false;
    }
  return false;
}

/// Lowers from `label` until control reaches `stop`; true when it does. pred is the block control comes from.
/// inside: label is a loop header that is also where the walk ends; do not stop before it.
bool Lowerer::walk(SpvId pred, SpvId label, SpvId stop, bool inside) {
  struct Depth {
    int& d;
    explicit Depth(int& depth) : d(depth) { ++d; }
    ~Depth() { --d; }
  } depth(walk_depth_);
  if (walk_depth_ > kMaxBlockNesting)
    throw UserError(place(b_.line()), fmt::format("control flow is nested deeper than {}", kMaxBlockNesting));

  while (true) {
    if (label == stop && !inside) {
      edge(pred, stop);
      return true;
    }
    inside = false;
    if (const Exit* exit = find_exit(label)) {
      leave(*exit, pred, std::nullopt);
      return false;
    }
    const SpirvBlock& block = m_.block(label);
    const SpirvInstruction* merge = block.merge();
    if (merge != nullptr && op_of(*merge) == spv::Op::OpLoopMerge && !open_loops_.contains(label)) {
      const SpvId after = merge->operands[0];
      loop(pred, label);
      pred = next_pred_;
      label = after;
      continue;
    }
    enter_block(pred, label);
    for (const SpirvInstruction& i : block.code) {
      if (op_of(i) == spv::Op::OpPhi) continue;
      if (&i == merge || &i == &block.terminator()) break;
      instruction(i);
    }
    const SpirvInstruction& t = block.terminator();
    if (t.line.line != 0) b_.set_line(t.line);
    switch (op_of(t)) {
      case spv::Op::OpBranch:
        pred = label;
        label = t.operands[0];
        continue;
      case spv::Op::OpKill:
      case spv::Op::OpTerminateInvocation:
        b_.kill_if(num(1));
        if (machine_depth_ > 0) b_.flow(Opcode::Break, num(1));  // or its loop might never end
        return false;
      case spv::Op::OpReturn:
      case spv::Op::OpUnreachable:
        return false;
      case spv::Op::OpBranchConditional: {
        bool done = false, falls = false;
        SpvId next = 0;
        selection(label,
                  merge != nullptr && op_of(*merge) == spv::Op::OpSelectionMerge ? merge->operands[0] : 0,
                  stop, next, done, falls);
        if (done) return falls;
        pred = next_pred_;
        label = next;
        continue;
      }
      case spv::Op::OpSwitch: {
        ALU_CHECK(merge != nullptr, "switch without merge");
        const SpvId m = merge->operands[0];
        switch_case(label, m);
        pred = next_pred_;
        label = m;
        if (unreachable_) {
          unreachable_ = false;
          return false;
        }
        continue;
      }
      default:
        refuse(t, spirv_op_name(t.op));
    }
  }
}

void Lowerer::selection(SpvId from, SpvId merge, SpvId stop, SpvId& next, bool& done, bool& falls) {
  const SpirvInstruction& t = m_.block(from).terminator();
  Ref condition = scalar(t.operands[0]);
  SpvId yes = t.operands[1], no = t.operands[2];
  next_pred_ = from;
  if (auto counted = counted_.find(from); counted != counted_.end()) {  // the trip count stands for this test
    next = counted->second.stay;
    return;
  }
  if (auto known = b_.value_of(condition)) {
    next = *known != 0 ? yes : no;
    return;
  }
  if (yes == no) {
    next = yes;
    return;
  }
  const auto inverted = [&] { return b_.logical_not(condition)[0]; };
  if (is_kill_block(yes, merge)) {
    b_.kill_if(condition);
    next = no;
    return;
  }
  if (is_kill_block(no, merge)) {
    b_.kill_if(inverted());
    next = yes;
    return;
  }
  // A conditional jump out: Break or Continue without an If around it.
  const auto [yes_from, yes_to] = jump_target(from, yes, stop, merge);
  const auto [no_from, no_to] = jump_target(from, no, stop, merge);
  if (const Exit* exit = find_exit(yes_to); exit != nullptr && yes_to != stop) {
    leave(*exit, yes_from, condition);
    next = no;
    return;
  }
  if (const Exit* exit = find_exit(no_to); exit != nullptr && no_to != stop) {
    leave(*exit, no_from, inverted());
    next = yes;
    return;
  }
  const auto a = exits_from(yes, merge, stop), b = exits_from(no, merge, stop);
  const bool merges = merge != 0 && merge != stop;
  const bool a_falls = merges && a.contains(merge), b_falls = merges && b.contains(merge);
  const bool a_stops = stop != 0 && a.contains(stop), b_stops = stop != 0 && b.contains(stop);

  std::vector<SpvId> bounds{merge, stop};
  for (const Exit& e : exits_) bounds.push_back(e.label);
  std::vector<SpvId> kept;

  if (!a_falls && !b_falls) {  // both sides run to the end of this walk or leave
    auto inside = region(yes, bounds);
    inside.merge(region(no, bounds));
    keep_in_registers(inside, kept);
    const bool empty_yes = yes == stop && edge_is_empty(from, stop);
    if (!empty_yes) {
      begin_if(condition);
      falls = walk(from, yes, stop);
      if (!(no == stop && edge_is_empty(from, stop))) {
        begin_else();
        falls = walk(from, no, stop) || falls;
      } else {
        falls = true;
      }
    } else {
      begin_if(inverted());
      walk(from, no, stop);
      falls = true;
    }
    end_if();
    release_registers(kept);
    done = true;
    return;
  }
  const bool a_nests = a_stops && !a_falls && b_falls, b_nests = b_stops && !b_falls && a_falls;
  if (a_nests || b_nests) {  // one side is through: the rest of the walk belongs to the other
    const SpvId rest = a_nests ? no : yes, through = a_nests ? yes : no;
    std::vector<SpvId> outer;
    if (stop != 0) outer.push_back(stop);
    for (const Exit& e : exits_) outer.push_back(e.label);
    auto inside = region(rest, outer);
    inside.merge(region(through, outer));
    keep_in_registers(inside, kept);
    const bool nothing = through == stop && edge_is_empty(from, stop);
    begin_if(a_nests ? inverted() : condition);
    falls = walk(from, rest, stop);
    if (!nothing) {
      begin_else();
      walk(from, through, stop);
    }
    falls = true;
    end_if();
    release_registers(kept);
    done = true;
    return;
  }
  // The plain form: both sides meet at the merge block, or leave the loop from inside.
  auto inside = region(yes, bounds);
  inside.merge(region(no, bounds));
  keep_in_registers(inside, kept);
  open_join(merge);
  const bool empty_yes = yes == merge && edge_is_empty(from, merge),
             empty_no = no == merge && edge_is_empty(from, merge);
  if (empty_yes && empty_no) {
    // nothing on either side
  } else if (empty_yes) {
    begin_if(inverted());
    walk(from, no, merge);
    end_if();
  } else {
    begin_if(condition);
    walk(from, yes, merge);
    if (!empty_no) {
      begin_else();
      walk(from, no, merge);
    }
    end_if();
  }
  release_registers(kept);
  next = merge;
  next_pred_ = from;
}

// An if chain over the cases. A case that falls into the next simply continues there: its code appears twice.
void Lowerer::switch_case(SpvId from, SpvId merge) {
  const SpirvInstruction& t = m_.block(from).terminator();
  if (m_.type(m_.definition(t.operands[0])->type).kind != SpirvType::Kind::Int)
    refuse(t, "a switch over this type", "switch over an int");
  const Ref selector = scalar(t.operands[0]);
  const SpvId default_label = t.operands[1];
  std::vector<std::pair<SpvId, std::vector<std::int64_t>>> cases;  // label, values
  for (std::size_t k = 2; k + 1 < t.operands.size(); k += 2) {
    const auto v = static_cast<std::int32_t>(t.operands[k]);
    const SpvId label = t.operands[k + 1];
    if (label == default_label) continue;
    auto it = std::find_if(cases.begin(), cases.end(), [&](const auto& c) { return c.first == label; });
    if (it == cases.end()) it = cases.insert(cases.end(), {label, {}});
    it->second.push_back(v);
  }
  std::vector<SpvId> bounds{merge};
  for (const Exit& e : exits_) bounds.push_back(e.label);
  std::unordered_set<SpvId> inside;
  for (SpvId s : successors(m_.block(from))) inside.merge(region(s, bounds));
  std::vector<SpvId> kept;
  keep_in_registers(inside, kept);
  open_join(merge);

  bool nests = nestable(default_label, merge);
  for (const auto& c : cases) nests = nests && nestable(c.first, merge);
  std::optional<OnceLoop> once;
  if (!nests) once.emplace(*this, merge, inside);

  bool falls = false;
  if (auto known = b_.value_of(selector)) {
    SpvId target = default_label;
    for (const auto& [label, numbers] : cases)
      for (std::int64_t v : numbers)
        if (static_cast<double>(v) == *known) target = label;
    falls = walk(from, target, merge);
  } else {
    int open = 0;
    for (const auto& [label, numbers] : cases) {
      Lanes hit = b_.op(Opcode::Seq, selector, num(static_cast<double>(numbers[0])));
      for (std::size_t k = 1; k < numbers.size(); ++k)
        hit = b_.op(Opcode::Max, hit, b_.op(Opcode::Seq, selector, num(static_cast<double>(numbers[k]))));
      begin_if(hit[0]);
      falls = walk(from, label, merge) || falls;
      begin_else();
      if (++open > kMaxBlockNesting)
        refuse(t, fmt::format("a switch with more than {} cases", kMaxBlockNesting), "index a table instead");
    }
    falls = walk(from, default_label, merge) || falls;
    for (; open > 0; --open) end_if();
  }
  if (once) {
    once->close();
    falls = true;
  }
  release_registers(kept);
  next_pred_ = from;
  unreachable_ = !falls;
}

}  // namespace aluminate::compiler
