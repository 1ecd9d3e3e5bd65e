#include "shading/cost/legality.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

namespace aluminate::cost {
namespace {

using vm::Opcode;

/// Physical register component.
using Cell = std::pair<int, int>;

/// Who wrote a component last: (block, node, lane); inputs are (-1, v, component), homes across blocks (-2,
/// temp, component).
using Writer = std::tuple<int, int, int>;

class Checker {
 public:
  Checker(const vm::Program& program, const ScheduledProgram& scheduled, PairingRule pairing)
      : program_(program), scheduled_(scheduled), strict_(pairing == PairingRule::Strict) {}

  std::vector<std::string> run() {
    for (std::size_t v = 0; v < program_.inputs.size(); ++v) {
      const int gpr = scheduled_.registers.input_gpr[v];
      for (int c = 0; gpr >= 0 && c < 4; ++c) {
        if (program_.inputs[v].mask >> c & 1) cells_[{gpr, c}] = {-1, static_cast<int>(v), c};
      }
    }
    for (std::size_t b = 0; b < scheduled_.blocks.size(); ++b) check_block(static_cast<int>(b));
    return std::move(broken_);
  }

 private:
  template <class... Values>
  void fail(fmt::format_string<Values...> text, Values&&... values) {
    broken_.push_back(fmt::format("block {} issue {}: ", block_, issue_) +
                      fmt::format(text, std::forward<Values>(values)...));
  }

  const ScheduledBlock& block() const { return scheduled_.scheduled[static_cast<std::size_t>(block_)]; }
  const Node& node(int n) const { return block().graph.nodes[static_cast<std::size_t>(n)]; }

  void check_block(int b) {
    block_ = b;
    done_.clear();
    const BlockSchedule& schedule = block().schedule;
    int carried = -1;
    for (std::size_t i = 0; i < schedule.issues.size(); ++i) {
      issue_ = static_cast<int>(i);
      const Issue& issue = schedule.issues[i];
      if (issue.is_fetch()) {
        check_fetch(issue);
        carried = -1;
        continue;
      }
      check_word(issue, carried);
      carried = issue.previous_move;
    }
    if (carried >= 0) fail("a movs without its _prev");
    for (std::size_t n = 0; n < block().graph.nodes.size(); ++n) {
      if (!node(static_cast<int>(n)).removed && !done_.contains(static_cast<int>(n)))
        fail("operation {} never issues", n);
    }
    check_clauses(schedule);
    forget_block();
  }

  /// Across blocks only inputs and homes carry values.
  void forget_block() {
    for (auto it = cells_.begin(); it != cells_.end();) {
      const auto [where, n, lane] = it->second;
      if (where < 0) {
        ++it;
        continue;
      }
      const Node& writer = node(n);
      if (writer.dest != DestKind::Home) {
        it = cells_.erase(it);
        continue;
      }
      it->second = {-2, writer.dest_index, it->first.second};
      ++it;
    }
  }

  void check_clauses(const BlockSchedule& schedule) {
    const int total = static_cast<int>(schedule.issues.size());
    const int split = schedule.export_start < 0 ? total : schedule.export_start;
    const int least =
        (split + kClauseIssues - 1) / kClauseIssues + (total - split + kClauseIssues - 1) / kClauseIssues;
    if (schedule.clauses != least)
      fail("{} clauses for {} + {} issues", schedule.clauses, split, total - split);
    for (int i = split; i < total; ++i) {
      if (schedule.issues[static_cast<std::size_t>(i)].is_fetch())
        fail("a fetch after the exports were allocated");
    }
  }

  // --- one word
  // -------------------------------------------------------------------------------------------------------

  void check_word(const Issue& issue, int carried) {
    if (issue.vector < 0 && issue.scalar < 0 && issue.previous_move < 0) fail("an empty word");
    if (issue.scalar >= 0 && issue.previous_move >= 0) fail("two scalar operations");
    if (issue.uses_previous != (carried >= 0)) fail("movs and _prev are not in neighbouring words");
    if (carried >= 0 && issue.scalar != carried) fail("another operation's previous value");
    const bool second_half = issue.scalar >= 0 || issue.previous_move >= 0;

    std::set<Cell> temps_read;
    std::set<int> temps;
    std::vector<std::string> constants;
    if (issue.vector >= 0) {
      const Node& v = node(issue.vector);
      if (v.special == Special::None && vm::info(v.op).pipe == vm::Pipe::Scalar)
        fail("{} on the vector half", vm::info(v.op).mnemonic);
      if (v.special == Special::SetPredicate && second_half) fail("a predicate is not alone");
      if (strict_ && v.sources == 3 && second_half)
        fail("{} shares its third source", vm::info(v.op).mnemonic);
      for (int s = 0; s < v.sources; ++s) read(v, s, temps, constants);
    }
    if (issue.scalar >= 0) check_scalar(node(issue.scalar), issue.uses_previous, temps, constants);
    if (issue.previous_move >= 0) {
      const Node& m = node(issue.previous_move);
      read(m, carried_operand(block().graph, m), temps, constants);
      if (issue.vector >= 0 && node(issue.vector).dest == DestKind::Export) fail("a movs in an export word");
    }
    if (constants.size() > 2) fail("{} constant registers", constants.size());
    if (temps.size() > 3 && strict_) fail("{} temporary registers", temps.size());
    if (issue.vector >= 0 && issue.scalar >= 0) {
      const Node &v = node(issue.vector), &s = node(issue.scalar);
      const bool exporting = v.dest == DestKind::Export || s.dest == DestKind::Export;
      const bool effect = v.dest == DestKind::Effect || s.dest == DestKind::Effect;
      if (exporting && !effect && (v.dest != s.dest || v.dest_index != s.dest_index))
        fail("two destinations in an export word");
    }
    for (int n : {issue.vector, issue.scalar}) {
      if (n >= 0) write(n);
    }
  }

  void check_scalar(const Node& s, bool uses_previous, std::set<int>& temps,
                    std::vector<std::string>& constants) {
    if (s.width != 1) fail("{} components on the scalar half", s.width);
    const vm::Pipe pipe = s.special == Special::None ? vm::info(s.op).pipe : vm::Pipe::Vector;
    if (pipe != vm::Pipe::Scalar && pipe != vm::Pipe::Either)
      fail("{} on the scalar half", vm::info(s.op).mnemonic);
    std::set<int> own;
    std::vector<std::string> own_constants;
    for (int i = 0; i < s.sources; ++i) {
      if (uses_previous && i == carried_operand(block().graph, s)) continue;
      read(s, i, own, own_constants);
    }
    const bool compare =
        s.op == Opcode::Sge || s.op == Opcode::Sgt || s.op == Opcode::Seq || s.op == Opcode::Sne;
    if (strict_ && !compare) {
      if (own.size() > 1) fail("{} reads two registers", vm::info(s.op).mnemonic);
      if (own_constants.size() > 1) fail("{} reads two constants", vm::info(s.op).mnemonic);
      if (own.size() + own_constants.size() == 2 && s.op != Opcode::Add && s.op != Opcode::Mul) {
        fail("{} has no form with a constant", vm::info(s.op).mnemonic);
      }
    }
    temps.insert(own.begin(), own.end());
    for (const std::string& name : own_constants) {
      if (std::find(constants.begin(), constants.end(), name) == constants.end()) constants.push_back(name);
    }
  }

  void check_fetch(const Issue& issue) {
    std::set<int> temps;
    std::vector<std::string> constants;
    const Node& fetch = node(issue.fetch);
    if (!fetch.is_fetch()) fail("an ALU operation as fetch");
    for (int s = 0; s < fetch.sources; ++s) {
      read(fetch, s, temps, constants);
      if (fetch.src[static_cast<std::size_t>(s)].negate || fetch.src[static_cast<std::size_t>(s)].absolute)
        fail("a fetch with modifiers");
    }
    if (!constants.empty()) fail("a fetch reads a constant");
    write(issue.fetch);
  }

  // --- registers
  // ------------------------------------------------------------------------------------------------------

  void read(const Node& reader, int s, std::set<int>& temps, std::vector<std::string>& constants) {
    const Operand& operand = reader.src[static_cast<std::size_t>(s)];
    std::set<int> registers;
    std::set<double> literals;
    std::set<std::string> names;
    for (int i = 0; i < operand.count; ++i) {
      const Ref& ref = operand.refs[static_cast<std::size_t>(i)];
      if (ref.address_node >= 0 && !done_.contains(ref.address_node))
        fail("address register used before it is loaded");
      Cell cell{-1, 0};
      Writer wanted{};
      switch (ref.kind) {
        case Ref::Kind::Literal:
          literals.insert(ref.value);
          continue;
        case Ref::Kind::Constant:
          names.insert(fmt::format("{}{}:{}:{}:{}", static_cast<int>(ref.file), ref.index,
                                   static_cast<int>(ref.relative.base), ref.relative.index,
                                   ref.address_node));
          continue;
        case Ref::Kind::Counter:
          names.insert(fmt::format("aL{}", ref.index));
          continue;
        case Ref::Kind::Input:
          cell = {scheduled_.registers.input_gpr[ref.index], ref.component};
          wanted = {-1, static_cast<int>(ref.index), ref.component};
          break;
        case Ref::Kind::Home:
          cell = {scheduled_.registers.home_gpr[ref.index], ref.component};
          wanted = {-2, static_cast<int>(ref.index), ref.component};
          break;
        case Ref::Kind::Node: {
          const int n = static_cast<int>(ref.index);
          if (!done_.contains(n)) fail("operation {} is read before it issues", n);
          const Location& location = block().results[ref.index];
          cell = {location.gpr, location.component[ref.component]};
          wanted = {block_, n, ref.component};
          break;
        }
      }
      registers.insert(cell.first);
      const auto found = cells_.find(cell);
      const bool undefined_home =
          found == cells_.end() && std::get<0>(wanted) == -2;  // never written: any value will do
      if (!undefined_home && (found == cells_.end() || found->second != wanted))
        fail("r{}.{} does not hold the value read", cell.first, "xyzw"[cell.second]);
    }
    if (!literals.empty()) names.insert("literal");
    if (registers.size() + names.size() > 1)
      fail("an operand from {} registers", registers.size() + names.size());
    temps.insert(registers.begin(), registers.end());
    for (const std::string& name : names) {
      if (std::find(constants.begin(), constants.end(), name) == constants.end()) constants.push_back(name);
    }
  }

  void write(int n) {
    if (!done_.insert(n).second) fail("operation {} issues twice", n);
    const Node& writer = node(n);
    if (writer.after >= 0 && !done_.contains(writer.after)) fail("set-up after its fetch");
    if (writer.dest == DestKind::Value) {
      const Location& location = block().results[static_cast<std::size_t>(n)];
      for (int lane = 0; lane < writer.width; ++lane)
        cells_[{location.gpr, location.component[static_cast<std::size_t>(lane)]}] = {block_, n, lane};
    } else if (writer.dest == DestKind::Home) {
      const int gpr = scheduled_.registers.home_gpr[writer.dest_index];
      for (int c = 0; c < 4; ++c) {
        if (writer.dest_lane[static_cast<std::size_t>(c)] >= 0)
          cells_[{gpr, c}] = {block_, n, writer.dest_lane[static_cast<std::size_t>(c)]};
      }
    }
  }

  const vm::Program& program_;
  const ScheduledProgram& scheduled_;
  bool strict_;
  int block_ = 0, issue_ = 0;
  std::map<Cell, Writer> cells_;
  std::set<int> done_;
  std::vector<std::string> broken_;
};

}  // namespace

std::vector<std::string> broken_rules(const vm::Program& program, const ScheduledProgram& scheduled,
                                      PairingRule pairing) {
  return Checker(program, scheduled, pairing).run();
}

}  // namespace aluminate::cost
