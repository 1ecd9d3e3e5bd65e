#include "shading/vm/reference_interpreter.hpp"

#include <algorithm>
#include <cmath>

#include "platform/host/error.hpp"
#include "platform/number/scalar.hpp"
#include "shading/vm/decoded.hpp"
#include "shading/vm/grid_plan.hpp"
#include "shading/vm/liveness.hpp"
#include "shading/vm/operands.hpp"
#include "shading/vm/texture_unit.hpp"

namespace aluminate::vm {
namespace {

using Vec4 = std::array<double, 4>;
using Lanes = std::array<bool, kLanes>;

struct Machine {
  const Program& program;
  const Executable& executable;
  Batch& batch;
  Counters& counters;
  Trace* trace;
  GridPlan plan;
  std::vector<std::uint8_t> live;               // per instruction: result components anybody uses
  std::vector<std::uint32_t> block_of;          // per instruction
  std::vector<std::array<Vec4, kLanes>> temps, inputs, outputs;
  std::vector<std::int32_t> iterations;         // of the open loops, outermost first
  Lanes killed{};

  bool covered(int lane) const { return (batch.covered & batch.active & std::uint64_t{1} << lane) != 0; }

  double read(const Source& s, int position, int lane) const {
    const std::size_t c = s.swizzle[static_cast<std::size_t>(position)], l = static_cast<std::size_t>(lane);
    std::size_t index = s.index;
    if (s.relative.base != RelativeBase::None) {
      const double base = s.relative.base == RelativeBase::LoopCounter
                              ? iterations[s.relative.index]
                              : std::floor(temps[s.relative.index][l][s.relative.component]);
      index += static_cast<std::size_t>(std::clamp(base * s.relative.scale, 0.0, s.relative.limit - 1.0));
    }
    double value = 0;
    switch (s.file) {
      case RegisterFile::Temp: value = temps[index][l][c]; break;
      case RegisterFile::Input: value = inputs[index][l][c]; break;
      case RegisterFile::Uniform: value = batch.constants[index * 4 + c]; break;
      case RegisterFile::Literal: value = plan.literals[index][c]; break;
      case RegisterFile::LoopCounter:
        value = std::min<double>(iterations[index], std::floor(plan.format.default_grid().greatest));
        break;
      case RegisterFile::Output: break;
    }
    if (s.absolute) value = std::fabs(value);
    return s.negate ? -value : value;
  }

  // Value of component c of the result before it is bounded.
  double evaluate(std::size_t index, int c, int lane) const {
    const Instruction& i = program.code[index];
    const number::Grid g = plan.grid(index);
    const int position = info(i.op).pipe == Pipe::Scalar ? 0 : c;
    const auto source = [&](std::size_t s) { return read(i.src[s], position, lane); };
    const auto choose = [](bool condition, double yes, double no) { return condition ? yes : no; };
    const auto dot = [&](int terms, double addend) {
      Vec4 a{}, b{};
      for (int t = 0; t < terms; ++t) {
        a[static_cast<std::size_t>(t)] = read(i.src[0], t, lane);
        b[static_cast<std::size_t>(t)] = read(i.src[1], t, lane);
      }
      const auto size = static_cast<std::size_t>(terms);
      return number::dot(g, std::span(a).first(size), std::span(b).first(size), addend);
    };
    const auto difference = [&](int neighbour) {
      const int quad = lane & ~3;
      return number::to_grid(g, read(i.src[0], position, quad + neighbour) - read(i.src[0], position, quad));
    };
    switch (i.op) {
      case Opcode::Mov: return source(0);
      case Opcode::Add:
        return number::add(g, number::add_form(plan.frac_bits[index], plan.source_frac_bits(program, index, 0, position),
                                               plan.source_frac_bits(program, index, 1, position)),
                           source(0), source(1));
      case Opcode::Mul: return number::mul(g, source(0), source(1));
      case Opcode::Mad: return number::mad(g, source(0), source(1), source(2));
      case Opcode::Min: return choose(source(0) < source(1), source(0), source(1));
      case Opcode::Max: return choose(source(0) >= source(1), source(0), source(1));
      case Opcode::Frc: return source(0) - std::floor(source(0));
      case Opcode::Flr: return std::floor(source(0));
      case Opcode::Trunc: return std::trunc(source(0));
      case Opcode::Sge: return choose(source(0) >= source(1), 1, 0);
      case Opcode::Sgt: return choose(source(0) > source(1), 1, 0);
      case Opcode::Seq: return choose(source(0) == source(1), 1, 0);
      case Opcode::Sne: return choose(source(0) != source(1), 1, 0);
      case Opcode::CndGe: return choose(source(0) >= 0, source(1), source(2));
      case Opcode::CndGt: return choose(source(0) > 0, source(1), source(2));
      case Opcode::CndEq: return choose(source(0) == 0, source(1), source(2));
      case Opcode::Dp2Add: return dot(2, read(i.src[2], 0, lane));
      case Opcode::Dp3: return dot(3, 0);
      case Opcode::Dp4: return dot(4, 0);
      case Opcode::Rcp: return number::rcp(g, source(0));
      case Opcode::Rsq: return number::rsq(g, plan.operand_step(program, index, 0), source(0));
      case Opcode::Sqrt: return number::sqrt(g, source(0));
      case Opcode::Exp: return number::exp2(g, source(0));
      case Opcode::Log: return number::log2(g, plan.operand_step(program, index, 0), source(0));
      case Opcode::Sin: return number::sin(g, source(0));
      case Opcode::Cos: return number::cos(g, source(0));
      case Opcode::DsX: return difference(1);
      case Opcode::DsY: return difference(2);
      default: break;
    }
    ALU_CHECK(false, "{} has no value", info(i.op).mnemonic);
    return 0;
  }

  bool test(const Instruction& i, int lane) const {
    const double a = read(i.src[0], 0, lane);
    if (!is_kill(i.op)) return a != 0;
    const double b = read(i.src[1], 0, lane);
    switch (i.op) {
      case Opcode::KillGt: return a > b;
      case Opcode::KillGe: return a >= b;
      case Opcode::KillNe: return a != b;
      default: return a == b;
    }
  }

  // All lanes' texels at once: implicit detail needs the whole quad.
  std::array<Vec4, kLanes> sample(std::size_t index, const Lanes& exec) {
    const Instruction& i = program.code[index];
    std::array<std::array<double, kLanes>, 9> coordinates{};
    std::array<std::array<double, kLanes>, 4> texels{};
    FetchRequest request;
    request.op = i.op;
    request.dimension = program.samplers[i.sampler].dimension;
    for (std::size_t k = 0; k < coordinates.size(); ++k) {
      const FetchOperand from = fetch_operand(i.op, request.dimension, k);
      for (int l = 0; from.source >= 0 && l < kLanes; ++l)
        coordinates[k][static_cast<std::size_t>(l)] = read(i.src[static_cast<std::size_t>(from.source)], from.position, l);
      request.rows[k] = coordinates[k].data();
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane)
      if (exec[lane]) request.exec |= std::uint64_t{1} << lane;
    request.covered = batch.covered & batch.active;
    const FetchCost cost = fetch_reference(batch.samplers[i.sampler], request, true, plan.grid(index),
                                           {texels[0].data(), texels[1].data(), texels[2].data(), texels[3].data()});
    counters.fetches += cost.fetches;
    counters.fetch_cycles += cost.cycles;
    std::array<Vec4, kLanes> result;
    for (std::size_t l = 0; l < kLanes; ++l) result[l] = {texels[0][l], texels[1][l], texels[2][l], texels[3][l]};
    return result;
  }

  void record(std::size_t index, int lane, const TraceEntry& entry) {
    if (trace == nullptr || trace->lane != lane) return;
    trace->entries.push_back(entry);
    trace->entries.back().instruction = static_cast<std::uint32_t>(index);
  }

  void execute(std::size_t index, const Lanes& exec) {
    const Instruction& i = program.code[index];
    if (is_kill(i.op)) {
      for (int l = 0; l < kLanes; ++l) {
        if (!exec[static_cast<std::size_t>(l)]) continue;
        const bool condition = test(i, l);
        killed[static_cast<std::size_t>(l)] |= condition;
        record(index, l, {.result = {condition ? 1.0 : 0.0}});
      }
      return;
    }
    std::array<Vec4, kLanes> texels{};
    if (shape_of(i.op) == Shape::Texture) texels = sample(index, exec);
    std::array<Vec4, kLanes> results{};
    for (int l = 0; l < kLanes; ++l) {
      const auto lane = static_cast<std::size_t>(l);
      if (!exec[lane]) continue;
      TraceEntry entry;
      entry.mask = i.dst.mask;
      bool replicated_counted = false;
      for (int c = 0; c < 4; ++c) {
        const auto component = static_cast<std::size_t>(c);
        if ((i.dst.mask >> c & 1) == 0) continue;
        const double value = shape_of(i.op) == Shape::Texture ? texels[lane][component] : evaluate(index, c, l);
        const number::Ranged r = number::finish(plan.grid(index), i.saturate, value);
        results[lane][component] = r.value;
        if (!r.saturated) continue;
        entry.saturated |= static_cast<std::uint8_t>(1u << c);
        // One number replicated to several components overflows once.
        const bool replicated = shape_of(i.op) == Shape::Dot || shape_of(i.op) == Shape::ScalarUnit;
        if (covered(l) && (live[index] >> c & 1) != 0 && !(replicated && replicated_counted)) {
          ++counters.saturations[index];
          replicated_counted = true;
        }
      }
      entry.result = results[lane];
      record(index, l, entry);
    }
    auto& file = i.dst.file == RegisterFile::Temp ? temps[i.dst.index] : outputs[i.dst.index];
    for (std::size_t l = 0; l < kLanes; ++l)
      if (exec[l])
        for (std::size_t c = 0; c < 4; ++c)
          if ((i.dst.mask >> c & 1) != 0) file[l][c] = results[l][c];
  }

  void count_block(std::size_t index, const Lanes& exec) {
    const std::uint32_t block = block_of[index];
    BlockCount& count = counters.blocks[block];
    ++count.executions;
    for (int l = 0; l < kLanes; ++l) {
      if (!exec[static_cast<std::size_t>(l)]) continue;
      ++(covered(l) ? count.covered_lanes : count.helper_lanes);
      if (batch.lane_blocks != nullptr) ++batch.lane_blocks[block * kLanes + static_cast<std::uint32_t>(l)];
    }
  }

  // Index of the instruction that ends the region opened at `begin`: its Else or EndIf, or its EndLoop.
  std::size_t find_end(std::size_t begin) const {
    int depth = 0;
    for (std::size_t i = begin + 1;; ++i) {
      const Opcode op = program.code[i].op;
      if (depth == 0 && (op == Opcode::Else || op == Opcode::EndIf || op == Opcode::EndLoop)) return i;
      if (op == Opcode::If || op == Opcode::Loop) ++depth;
      if (op == Opcode::EndIf || op == Opcode::EndLoop) --depth;
    }
  }

  static bool any(const Lanes& lanes) { return std::find(lanes.begin(), lanes.end(), true) != lanes.end(); }

  // Runs [begin, end) for the lanes of exec and removes those that left by Break; `waiting` collects Continue.
  // Recursive over regions, so that the nesting of the source is the nesting of the calls.
  void run_region(std::size_t begin, std::size_t end, Lanes& exec, Lanes& waiting) {
    bool block_begins = true;
    for (std::size_t i = begin; i < end; ++i) {
      if (!any(exec)) return;
      if (block_begins) count_block(i, exec);
      block_begins = info(program.code[i].op).pipe == Pipe::Flow;
      const Instruction& in = program.code[i];
      switch (in.op) {
        case Opcode::If: i = run_if(i, exec, waiting); break;
        case Opcode::Loop: i = run_loop(i, exec); break;
        case Opcode::Break:
        case Opcode::Continue:
          for (int l = 0; l < kLanes; ++l) {
            const auto lane = static_cast<std::size_t>(l);
            if (!exec[lane]) continue;
            const bool condition = test(in, l);
            record(i, l, {.result = {condition ? 1.0 : 0.0}});
            if (!condition) continue;
            exec[lane] = false;
            if (in.op == Opcode::Continue) waiting[lane] = true;
          }
          break;
        case Opcode::Else:
        case Opcode::EndIf:
        case Opcode::EndLoop: break;  // the last instruction of a region: counted with its block, does nothing itself
        default: execute(i, exec); break;
      }
    }
  }

  std::size_t run_if(std::size_t begin, Lanes& exec, Lanes& waiting) {
    Lanes then_lanes{}, else_lanes{};
    for (int l = 0; l < kLanes; ++l) {
      const auto lane = static_cast<std::size_t>(l);
      if (!exec[lane]) continue;
      const bool condition = test(program.code[begin], l);
      record(begin, l, {.result = {condition ? 1.0 : 0.0}});
      (condition ? then_lanes : else_lanes)[lane] = true;
    }
    std::size_t end = find_end(begin);
    run_region(begin + 1, end + 1, then_lanes, waiting);
    if (program.code[end].op == Opcode::Else) {
      const std::size_t otherwise = end;
      end = find_end(otherwise);
      run_region(otherwise + 1, end + 1, else_lanes, waiting);
    }
    for (std::size_t l = 0; l < kLanes; ++l) exec[l] = then_lanes[l] || else_lanes[l];
    return end;
  }

  std::size_t run_loop(std::size_t begin, const Lanes& entered) {
    const std::size_t end = find_end(begin);
    const int trips = program.code[begin].trip_count;
    Lanes exec = entered;
    iterations.push_back(0);
    while (iterations.back() < (trips < 0 ? kLoopLimit : trips) && any(exec)) {
      Lanes waiting{};
      run_region(begin + 1, end + 1, exec, waiting);
      for (std::size_t l = 0; l < kLanes; ++l) exec[l] = exec[l] || waiting[l];
      ++iterations.back();
    }
    iterations.pop_back();
    if (trips < 0 && any(exec) && (counters.overrun_loop < 0 || static_cast<std::int32_t>(begin) < counters.overrun_loop))
      counters.overrun_loop = static_cast<std::int32_t>(begin);
    return end;
  }
};

}  // namespace

void run_reference(const Program& program, const Executable& executable, Batch& batch, Counters& counters, Trace* trace) {
  Machine machine{program, executable, batch, counters, trace, plan_grids(program, executable.format(), executable.decoded().frac_bits),
                  find_liveness(program).live_mask, {}, {}, {}, {}, {}, {}};
  machine.block_of.resize(program.code.size());
  const std::vector<Block> blocks = find_blocks(program);
  for (std::uint32_t b = 0; b < blocks.size(); ++b)
    for (std::uint32_t i = blocks[b].begin; i < blocks[b].end; ++i) machine.block_of[i] = b;
  machine.temps.resize(static_cast<std::size_t>(program.temp_count));
  machine.inputs.resize(program.inputs.size());
  machine.outputs.resize(program.outputs.size());

  Lanes exec{};
  for (std::size_t l = 0; l < kLanes; ++l) exec[l] = (batch.active >> l & 1) != 0;
  batch.killed = 0;
  const number::Grid grid = executable.format().default_grid();
  for (std::size_t r = 0; r < executable.inputs().size(); ++r)
    for (std::size_t l = 0; l < kLanes; ++l) {
      const RowBinding& row = executable.inputs()[r];
      if (!exec[l] && !batch.inputs_on_grid) continue;
      const double raw = batch.inputs[r * kLanes + l];
      const number::Ranged value = batch.inputs_on_grid ? number::Ranged{raw, false} : number::sanitise(grid, raw);
      machine.inputs[row.index][l][row.component] = value.value;
      if (value.saturated && machine.covered(static_cast<int>(l))) ++counters.sanitised_inputs;
    }

  Lanes waiting{};
  machine.run_region(0, program.code.size(), exec, waiting);

  for (std::size_t l = 0; l < kLanes; ++l) {
    if ((batch.active >> l & 1) == 0) continue;
    if (machine.killed[l]) {
      batch.killed |= std::uint64_t{1} << l;
      continue;
    }
    for (std::size_t r = 0; r < executable.outputs().size(); ++r) {
      const RowBinding& row = executable.outputs()[r];
      batch.outputs[r * kLanes + l] = machine.outputs[row.index][l][row.component];
    }
  }
}

}  // namespace aluminate::vm
