#include "shading/cost/wide_models.hpp"

#include "platform/host/error.hpp"
#include "shading/cost/xenos_packing.hpp"
#include "shading/cost/xenos_rewrite.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace aluminate::cost {
namespace {

using console::AluModel;
using vm::Opcode;

bool transcendental(const Node& node) {
  return node.special == Special::None && vm::info(node.op).pipe == vm::Pipe::Scalar;
}

int lanes_of(const Node& node) {
  if (node.op == Opcode::Dp4 || node.special == Special::Cube) return 4;
  if (node.op == Opcode::Dp3) return 3;
  if (node.op == Opcode::Dp2Add) return 2;
  return std::max(1, node.width);
}

/// A unit of a word: how many lanes and operations it still takes. Stages run one after the other inside a
/// word, so a later stage may use what an earlier one made.
struct Unit {
  const char* name;
  int stage;
  int lanes, operations;
};

std::vector<Unit> units_of(AluModel model) {
  switch (model) {
    case AluModel::DualSu:
      return {{"SU0", 0, 4, 2}, {"SU1", 1, 4, 2}};
    case AluModel::Vliw5:
      return {{"xyzw", 0, 4, 4}, {"t", 0, 1, 1}};
    case AluModel::MaliWord:
      return {{"tex", 0, 4, 1},  {"vmul", 1, 4, 1}, {"smul", 1, 1, 1},
              {"vadd", 2, 4, 1}, {"sadd", 2, 1, 1}, {"combine", 3, 4, 1}};
    default:
      return {{"lane", 0, 1, 1}};
  }
}

enum class Takes { No, Yes, Whole };  // Whole: the unit is busy with nothing else in this word

Takes takes(AluModel model, std::size_t unit, const Node& node) {
  if (model == AluModel::DualSu) {
    if (node.is_fetch())
      return unit == 0 ? Takes::Whole : Takes::No;  // the first unit computes texture addresses
    if (transcendental(node)) return unit == 0 ? Takes::Yes : Takes::No;
    return Takes::Yes;
  }
  if (model == AluModel::Vliw5) {
    if (node.is_fetch()) return Takes::No;
    if (unit == 1) return lanes_of(node) == 1 ? Takes::Yes : Takes::No;
    if (transcendental(node)) return Takes::No;
    return node.is_reduction() ? Takes::Whole : Takes::Yes;
  }
  // Utgard: products in the mul units, sums in the add units, transcendentals in the combiner; copies go
  // anywhere.
  const bool single = lanes_of(node) == 1;
  if (node.is_fetch()) return unit == 0 ? Takes::Whole : Takes::No;
  if (transcendental(node)) return unit == 5 ? Takes::Whole : Takes::No;
  const bool product = node.op == Opcode::Mul, copy = node.op == Opcode::Mov;
  const bool both = node.op == Opcode::Mad || node.is_reduction();
  switch (unit) {
    case 1:
      return product || copy || both ? Takes::Yes : Takes::No;
    case 2:
      return single && (product || copy) ? Takes::Yes : Takes::No;
    case 3:
      return !product && !both ? Takes::Yes : Takes::No;
    case 4:
      return single && !product && !both ? Takes::Yes : Takes::No;
    default:
      return Takes::No;
  }
}

/// Nodes by depth, deepest chains behind them first, then in program order.
std::vector<int> placement_order(const Graph& graph, const ChainLengths& lengths) {
  std::vector<int> order;
  std::vector<int> level(graph.nodes.size(), 0);
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
      if (graph.nodes[n].removed) continue;
      for_each_dependency(graph.nodes[n], [&](int from) {
        if (level[n] <= level[static_cast<std::size_t>(from)]) {
          level[n] = level[static_cast<std::size_t>(from)] + 1;
          changed = true;
        }
      });
    }
  }
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    if (!graph.nodes[n].removed) order.push_back(static_cast<int>(n));
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    const std::size_t x = static_cast<std::size_t>(a), y = static_cast<std::size_t>(b);
    if (level[x] != level[y]) return level[x] < level[y];
    return lengths.height[x] > lengths.height[y];
  });
  return order;
}

WideSchedule schedule_scalar_lanes(const Graph& graph) {
  WideSchedule schedule;
  constexpr int kQuarterRate = 4;  // transcendentals [CLRX]
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const Node& node = graph.nodes[n];
    if (node.removed || node.is_fetch()) continue;
    const int word = static_cast<int>(schedule.words);
    schedule.placed.push_back({static_cast<int>(n), word, "lane"});
    schedule.words += transcendental(node) ? kQuarterRate : lanes_of(node);
  }
  schedule.bound_words = schedule.words;  // one component at a time: nothing to pair
  return schedule;
}

}  // namespace

WideSchedule schedule_wide(const Graph& graph, AluModel model) {
  if (model == AluModel::ScalarLane) return schedule_scalar_lanes(graph);
  const std::vector<Unit> units = units_of(model);
  const ChainLengths lengths = chain_lengths(graph);
  std::vector<std::vector<Unit>> words;
  std::vector<std::pair<int, int>> done(graph.nodes.size(), {-1, -1});  // (word, stage) that makes the result
  WideSchedule schedule;
  int lanes = 0, last_word = -1;
  for (int n : placement_order(graph, lengths)) {
    const Node& node = graph.nodes[static_cast<std::size_t>(n)];
    std::pair<int, int> ready = {0, -1};
    for_each_dependency(node,
                        [&](int from) { ready = std::max(ready, done[static_cast<std::size_t>(from)]); });
    if (node.is_fetch() && model == AluModel::Vliw5) {  // fetches have their own clause there
      done[static_cast<std::size_t>(n)] = ready;
      continue;
    }
    if (!node.is_fetch()) lanes += lanes_of(node);
    bool placed = false;
    for (int word = ready.first; !placed; ++word) {
      if (word >= static_cast<int>(words.size())) words.push_back(units);
      for (std::size_t u = 0; u < units.size() && !placed; ++u) {
        Unit& unit = words[static_cast<std::size_t>(word)][u];
        if (word == ready.first && unit.stage <= ready.second) continue;
        const Takes answer = takes(model, u, node);
        const int need = lanes_of(node);
        if (answer == Takes::No || unit.operations < 1 || unit.lanes < need) continue;
        if (answer == Takes::Whole && unit.lanes != units[u].lanes) continue;
        // A multiply-add or dot product of Utgard runs through the mul and the add unit of one word.
        const bool through = model == AluModel::MaliWord && (node.op == Opcode::Mad || node.is_reduction());
        Unit* add = through ? &words[static_cast<std::size_t>(word)][u + 2] : nullptr;
        if (add != nullptr && (add->operations < 1 || add->lanes < need)) continue;
        unit.lanes = answer == Takes::Whole ? 0 : unit.lanes - need;
        --unit.operations;
        if (add != nullptr) --add->operations;
        done[static_cast<std::size_t>(n)] = {word, add != nullptr ? add->stage : unit.stage};
        last_word = std::max(last_word, word);
        schedule.placed.push_back({n, word, unit.name});
        placed = true;
      }
      ALU_CHECK(placed || word < ready.first + 100000, "operation {} fits no unit",
                vm::info(node.op).mnemonic);
    }
  }
  schedule.words = last_word + 1;
  const int width = model == AluModel::DualSu ? 8 : model == AluModel::Vliw5 ? 5 : 10;
  schedule.bound_words = (lanes + width - 1) / width;
  std::stable_sort(schedule.placed.begin(), schedule.placed.end(),
                   [](const auto& a, const auto& b) { return a.word < b.word; });
  return schedule;
}

int live_registers(const vm::Program& program, bool inputs_in_registers) {
  // Lifetimes of whole components, first to last mention; a loop keeps what it mentions alive throughout.
  struct Life {
    int first = -1, last = -1;
  };
  const std::size_t temps = static_cast<std::size_t>(program.temp_count), inputs = program.inputs.size();
  std::vector<Life> life((temps + inputs) * 4);
  std::vector<std::pair<int, int>> loops;
  std::vector<int> open;
  const auto mention = [&](std::size_t reg, int c, int position) {
    Life& entry = life[reg * 4 + static_cast<std::size_t>(c)];
    if (entry.first < 0) entry.first = reg >= temps ? 0 : position;
    entry.last = position;
  };
  for (std::size_t i = 0; i < program.code.size(); ++i) {
    const vm::Instruction& instruction = program.code[i];
    if (instruction.op == Opcode::Loop) open.push_back(static_cast<int>(i));
    if (instruction.op == Opcode::EndLoop && !open.empty()) {
      if (open.size() == 1) loops.emplace_back(open.back(), static_cast<int>(i));
      open.pop_back();
    }
    for (std::size_t s = 0; s < static_cast<std::size_t>(vm::info(instruction.op).sources); ++s) {
      const vm::Source& source = instruction.src[s];
      for (int lane = 0; lane < 4; ++lane) {
        if (!reads_lane(program, instruction, static_cast<int>(s), lane)) continue;
        if (source.file == vm::RegisterFile::Temp)
          mention(source.index, source.swizzle[static_cast<std::size_t>(lane)], static_cast<int>(i));
        if (source.file == vm::RegisterFile::Input)
          mention(temps + source.index, source.swizzle[static_cast<std::size_t>(lane)], static_cast<int>(i));
      }
    }
    if (instruction.dst.file == vm::RegisterFile::Temp) {
      for (int c = 0; c < 4; ++c) {
        if (instruction.dst.mask >> c & 1) mention(instruction.dst.index, c, static_cast<int>(i));
      }
    }
  }
  std::vector<int> change(program.code.size() + 2, 0);
  for (std::size_t reg = 0; reg < temps + (inputs_in_registers ? inputs : 0); ++reg) {
    for (std::size_t c = 0; c < 4; ++c) {
      Life entry = life[reg * 4 + c];
      if (entry.first < 0) continue;
      for (const auto& [begin, end] : loops) {
        const bool crosses =
            entry.first <= end && entry.last >= begin && (entry.first < begin || entry.last > end);
        if (crosses) {
          entry.first = std::min(entry.first, begin);
          entry.last = std::max(entry.last, end);
        }
      }
      ++change[static_cast<std::size_t>(entry.first)];
      --change[static_cast<std::size_t>(entry.last) + 1];
    }
  }
  int alive = 0, most = 0;
  for (int delta : change) {
    alive += delta;
    most = std::max(most, alive);
  }
  return std::max(1, (most + 3) / 4);
}

}  // namespace aluminate::cost
