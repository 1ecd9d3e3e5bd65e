#include "tests/cost/machine.hpp"

#include "shading/cost/slots.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>

namespace aluminate::test {
namespace {

using namespace vm;
using cost::Node;
using cost::Special;

/// One component of an elementwise or scalar operation. Domains are clipped so that random programs stay
/// finite; the same on both sides.
double apply(Opcode op, double a, double b, double c) {
  switch (op) {
    case Opcode::Mov:
      return a;
    case Opcode::Add:
      return a + b;
    case Opcode::Mul:
      return a * b;
    case Opcode::Mad:
      return a * b + c;
    case Opcode::Min:
      return a < b ? a : b;
    case Opcode::Max:
      return a >= b ? a : b;
    case Opcode::Frc:
      return a - std::floor(a);
    case Opcode::Flr:
      return std::floor(a);
    case Opcode::Trunc:
      return std::trunc(a);
    case Opcode::Sge:
      return a >= b ? 1 : 0;
    case Opcode::Sgt:
      return a > b ? 1 : 0;
    case Opcode::Seq:
      return a == b ? 1 : 0;
    case Opcode::Sne:
      return a != b ? 1 : 0;
    case Opcode::CndGe:
      return a >= 0 ? b : c;
    case Opcode::CndGt:
      return a > 0 ? b : c;
    case Opcode::CndEq:
      return a == 0 ? b : c;
    case Opcode::Rcp:
      return a == 0 ? 1e4 : 1 / a;
    case Opcode::Rsq:
      return 1 / std::sqrt(std::max(a, 1e-6));
    case Opcode::Sqrt:
      return std::sqrt(std::max(a, 1e-6));
    case Opcode::Exp:
      return std::exp2(std::clamp(a, -8.0, 8.0));
    case Opcode::Log:
      return std::log2(std::max(a, 1e-3));
    case Opcode::Sin:
      return std::sin(a);
    case Opcode::Cos:
      return std::cos(a);
    case Opcode::DsX:
      return 0.25 * a + 0.5;
    case Opcode::DsY:
      return 0.125 * a - 0.5;
    default:
      throw std::runtime_error("operation");
  }
}

double finish(double value, bool saturate) {
  if (saturate) value = std::clamp(value, 0.0, 1.0);
  return std::clamp(value, -1e6, 1e6);
}

double texel(int sampler, const std::vector<double>& numbers, int component) {
  double phase = 0.7 * sampler + 0.3 * component;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    phase += numbers[i] * (1.0 + 0.37 * static_cast<double>(i));
  return 0.5 + 0.5 * std::sin(phase);
}

bool kills(Opcode op, double a, double b) {
  switch (op) {
    case Opcode::KillGt:
      return a > b;
    case Opcode::KillGe:
      return a >= b;
    case Opcode::KillNe:
      return a != b;
    default:
      return a == b;
  }
}

/// Runs blocks in the order one lane meets them. run_block(b) executes block b up to its Flow instruction and
/// returns the branch condition.
void walk(const Program& program, const std::vector<Block>& blocks,
          const std::function<bool(std::size_t, const std::vector<int>&)>& run_block) {
  std::map<std::uint32_t, std::uint32_t> match, otherwise;  // opening instruction -> closing one, If -> Else
  std::vector<std::uint32_t> open;
  for (std::uint32_t i = 0; i < program.code.size(); ++i) {
    const Opcode op = program.code[i].op;
    if (op == Opcode::If || op == Opcode::Loop) open.push_back(i);
    if (op == Opcode::Else) otherwise[open.back()] = i;
    if (op == Opcode::EndIf || op == Opcode::EndLoop) {
      match[open.back()] = i;
      match[i] = open.back();
      open.pop_back();
    }
  }
  std::map<std::uint32_t, std::size_t> block_after;  // instruction that ends a block -> next block
  for (std::size_t b = 0; b < blocks.size(); ++b) block_after[blocks[b].end - 1] = b + 1;
  std::map<std::uint32_t, std::uint32_t> else_end;
  for (const auto& [if_at, else_at] : otherwise) else_end[else_at] = match[if_at];
  std::vector<std::pair<std::uint32_t, int>> loops;  // Loop instruction, iterations done
  std::size_t b = 0;
  for (int steps = 0; b < blocks.size(); ++steps) {
    if (steps > 100000) throw std::runtime_error("endless loop");
    std::vector<int> counters;
    for (const auto& loop : loops) counters.push_back(loop.second);
    const bool condition = run_block(b, counters);
    const std::uint32_t last = blocks[b].end - 1;
    const Instruction& instruction = program.code[last];
    std::size_t next = b + 1;
    switch (instruction.op) {
      case Opcode::If:
        if (!condition) next = block_after[otherwise.contains(last) ? otherwise[last] : match[last]];
        break;
      case Opcode::Else:
        next = block_after[else_end[last]];
        break;
      case Opcode::Loop:
        if (instruction.trip_count == 0) {
          next = block_after[match[last]];
        } else {
          loops.emplace_back(last, 0);
        }
        break;
      case Opcode::EndLoop: {
        auto& [loop, done] = loops.back();
        ++done;
        if (program.code[loop].trip_count < 0 || done < program.code[loop].trip_count) {
          next = block_after[loop];
        } else {
          loops.pop_back();
        }
        break;
      }
      case Opcode::Break:
        if (condition) {
          next = block_after[match[loops.back().first]];
          loops.pop_back();
        }
        break;
      default:
        break;
    }
    b = next;
  }
}

double constant(const Program& program, const LaneInput& input, RegisterFile file, int index, int component,
                const Relative& relative, double address) {
  if (relative.base != RelativeBase::None) {
    index += static_cast<int>(relative.scale) *
             std::clamp(static_cast<int>(std::floor(address)), 0, std::max(0, relative.limit - 1));
  }
  const std::size_t at = static_cast<std::size_t>(index), c = static_cast<std::size_t>(component);
  return file == RegisterFile::Uniform ? input.uniforms.at(at)[c] : program.literals.at(at)[c];
}

}  // namespace

LaneResult run_program(const Program& program, const LaneInput& input) {
  LaneResult result;
  result.outputs.assign(program.outputs.size(), Vec4{kUnwritten, kUnwritten, kUnwritten, kUnwritten});
  std::vector<Vec4> temps(static_cast<std::size_t>(program.temp_count), Vec4{});
  const std::vector<Block> blocks = find_blocks(program);
  walk(program, blocks, [&](std::size_t b, const std::vector<int>& counters) {
    bool condition = false;
    for (std::uint32_t i = blocks[b].begin; i < blocks[b].end; ++i) {
      const Instruction& instruction = program.code[i];
      const auto read = [&](std::size_t s, std::size_t lane) {
        const Source& source = instruction.src[s];
        const std::size_t c = source.swizzle[lane];
        double value = 0;
        switch (source.file) {
          case RegisterFile::Temp:
            value = temps[source.index][c];
            break;
          case RegisterFile::Input:
            value = input.inputs[source.index][c];
            break;
          case RegisterFile::LoopCounter:
            value = counters[source.index];
            break;
          default: {
            const double address = source.relative.base == RelativeBase::Temp
                                       ? temps[source.relative.index][source.relative.component]
                                   : source.relative.base == RelativeBase::LoopCounter
                                       ? counters[source.relative.index]
                                       : 0;
            value = constant(program, input, source.file, source.index, static_cast<int>(c), source.relative,
                             address);
          }
        }
        if (source.absolute) value = std::abs(value);
        return source.negate ? -value : value;
      };
      Vec4 out{};
      const OpcodeInfo& op = info(instruction.op);
      if (op.pipe == Pipe::Flow) {
        if (op.sources > 0) condition = read(0, 0) != 0;
        continue;
      }
      if (instruction.dst.mask == 0) {
        result.kills += kills(instruction.op, read(0, 0), read(1, 0));
        continue;
      }
      if (cost::is_texture(instruction.op)) {
        const SamplerDimension dimension = program.samplers[instruction.sampler].dimension;
        const std::size_t count = dimension == SamplerDimension::Tex2D ? 2 : 3;
        std::vector<double> numbers;
        for (std::size_t lane = 0; lane < count; ++lane) numbers.push_back(read(0, lane));
        if (dimension == SamplerDimension::TexCube) {
          const double scale = apply(Opcode::Rcp, std::abs(2 * numbers[2]), 0, 0);
          numbers = {finish(numbers[0] * scale + 1.5, false), finish(numbers[1] * scale + 1.5, false),
                     numbers[2] > 0 ? 4.0 : 5.0};
        }
        if (instruction.op == Opcode::TexBias || instruction.op == Opcode::TexLod)
          numbers.push_back(read(0, 3));
        for (std::size_t s = 1; instruction.op == Opcode::TexGrad && s < 3; ++s) {
          for (std::size_t lane = 0; lane < count; ++lane) numbers.push_back(read(s, lane));
        }
        for (int c = 0; c < 4; ++c) out[static_cast<std::size_t>(c)] = texel(instruction.sampler, numbers, c);
      } else if (instruction.op == Opcode::Dp2Add || instruction.op == Opcode::Dp3 ||
                 instruction.op == Opcode::Dp4) {
        const std::size_t count = instruction.op == Opcode::Dp2Add ? 2
                                  : instruction.op == Opcode::Dp3  ? 3
                                                                   : 4;
        double sum = instruction.op == Opcode::Dp2Add ? read(2, 0) : 0;
        for (std::size_t lane = 0; lane < count; ++lane) sum += read(0, lane) * read(1, lane);
        out.fill(sum);
      } else {
        for (std::size_t c = 0; c < 4; ++c) {
          const std::size_t lane = op.pipe == Pipe::Scalar ? 0 : c;
          out[c] = apply(instruction.op, read(0, lane), op.sources > 1 ? read(1, lane) : 0,
                         op.sources > 2 ? read(2, lane) : 0);
        }
      }
      Vec4& target = instruction.dst.file == RegisterFile::Output ? result.outputs[instruction.dst.index]
                                                                  : temps[instruction.dst.index];
      for (std::size_t c = 0; c < 4; ++c) {
        if (instruction.dst.mask >> c & 1) target[c] = finish(out[c], instruction.saturate);
      }
    }
    return condition;
  });
  return result;
}

LaneResult run_schedule(const Program& program, const cost::ScheduledProgram& scheduled,
                        const LaneInput& input) {
  LaneResult result;
  result.outputs.assign(program.outputs.size(), Vec4{kUnwritten, kUnwritten, kUnwritten, kUnwritten});
  std::vector<Vec4> gprs(static_cast<std::size_t>(scheduled.registers.gprs), Vec4{777, 777, 777, 777});
  for (std::size_t v = 0; v < program.inputs.size(); ++v) {
    const int gpr = scheduled.registers.input_gpr[v];
    if (gpr >= 0) gprs[static_cast<std::size_t>(gpr)] = input.inputs[v];
  }
  walk(program, scheduled.blocks, [&](std::size_t b, const std::vector<int>& counters) {
    const cost::ScheduledBlock& block = scheduled.scheduled[b];
    bool condition = false;
    double previous = 0;
    std::map<int, double> addresses;
    std::map<int, std::vector<double>> setups;
    const auto read = [&](const cost::Operand& operand, int i) {
      const cost::Ref& ref = operand.refs[static_cast<std::size_t>(i)];
      const auto gpr = [&](int index, std::size_t c) { return gprs.at(static_cast<std::size_t>(index))[c]; };
      double value = 0;
      switch (ref.kind) {
        case cost::Ref::Kind::Node:
          value = gpr(block.results[ref.index].gpr, block.results[ref.index].component[ref.component]);
          break;
        case cost::Ref::Kind::Input:
          value = gpr(scheduled.registers.input_gpr[ref.index], ref.component);
          break;
        case cost::Ref::Kind::Home:
          value = gpr(scheduled.registers.home_gpr[ref.index], ref.component);
          break;
        case cost::Ref::Kind::Literal:
          value = ref.value;
          break;
        case cost::Ref::Kind::Counter:
          value = counters[ref.index];
          break;
        case cost::Ref::Kind::Constant: {
          const double address = ref.address_node >= 0 ? addresses.at(ref.address_node)
                                 : ref.relative.base == RelativeBase::LoopCounter
                                     ? counters[ref.relative.index]
                                     : 0;
          value = constant(program, input, ref.file, static_cast<int>(ref.index), ref.component, ref.relative,
                           address);
          break;
        }
      }
      if (operand.absolute) value = std::abs(value);
      return operand.negate ? -value : value;
    };
    struct Write {
      int node;
      Vec4 lanes;
    };
    const auto evaluate = [&](int n, bool uses_previous) {
      const Node& node = block.graph.nodes[static_cast<std::size_t>(n)];
      const int carried = uses_previous ? cost::carried_operand(block.graph, node) : -1;
      Vec4 lanes{};
      const auto value = [&](int s, int i) {
        return s == carried ? previous : read(node.src[static_cast<std::size_t>(s)], i);
      };
      if (node.special == Special::Cube) {
        lanes = {value(0, 0), value(0, 1), 2 * value(0, 2), value(0, 2) > 0 ? 4.0 : 5.0};
      } else if (node.special == Special::SetPredicate) {
        condition = apply(node.op, value(0, 0), value(1, 0), 0) != 0;
      } else if (node.special == Special::LoadAddress) {
        addresses[n] = value(0, 0);
      } else if (node.special == Special::FetchSetup) {
        std::vector<double>& numbers = setups[n];
        if (node.after >= 0) numbers = setups.at(node.after);
        for (int i = 0; i < node.src[0].count; ++i) numbers.push_back(value(0, i));
      } else if (node.dest == cost::DestKind::Effect) {
        result.kills += kills(node.op, value(0, 0), value(1, 0));
      } else if (cost::is_texture(node.op)) {
        std::vector<double> numbers;
        for (int i = 0; i < node.src[0].count; ++i) numbers.push_back(value(0, i));
        if (node.after >= 0) {
          for (double number : setups.at(node.after)) numbers.push_back(number);
        }
        for (int lane = 0; lane < node.width; ++lane) {
          lanes[static_cast<std::size_t>(lane)] =
              texel(node.sampler, numbers, node.texel_component[static_cast<std::size_t>(lane)]);
        }
      } else if (node.is_reduction()) {
        double sum = node.op == Opcode::Dp2Add ? value(2, 0) : 0;
        for (int i = 0; i < node.src[0].count; ++i) sum += value(0, i) * value(1, i);
        lanes[0] = sum;
      } else {
        for (int lane = 0; lane < node.width; ++lane) {
          lanes[static_cast<std::size_t>(lane)] =
              apply(node.op, value(0, lane), node.sources > 1 ? value(1, lane) : 0,
                    node.sources > 2 ? value(2, lane) : 0);
        }
      }
      for (double& lane : lanes) lane = finish(lane, node.saturate);
      return Write{n, lanes};
    };
    for (const cost::Issue& issue : block.schedule.issues) {
      std::vector<Write> writes;  // both halves read before either writes
      for (int n : {issue.fetch, issue.vector, issue.scalar}) {
        if (n >= 0) writes.push_back(evaluate(n, n == issue.scalar && issue.uses_previous));
      }
      if (issue.previous_move >= 0) {
        const Node& node = block.graph.nodes[static_cast<std::size_t>(issue.previous_move)];
        previous = read(node.src[static_cast<std::size_t>(cost::carried_operand(block.graph, node))], 0);
      }
      for (const Write& write : writes) {
        const Node& node = block.graph.nodes[static_cast<std::size_t>(write.node)];
        for (std::size_t c = 0; c < 4; ++c) {
          const int lane = node.dest_lane[c];
          if (node.dest == cost::DestKind::Export) {
            if (lane >= 0) result.outputs[node.dest_index][c] = write.lanes[static_cast<std::size_t>(lane)];
            if (node.export_constants >> c & 1) result.outputs[node.dest_index][c] = node.export_values[c];
          }
          if (node.dest == cost::DestKind::Home && lane >= 0) {
            gprs.at(static_cast<std::size_t>(scheduled.registers.home_gpr[node.dest_index]))[c] =
                write.lanes[static_cast<std::size_t>(lane)];
          }
        }
        if (node.dest == cost::DestKind::Value) {
          const cost::Location& location = block.results[static_cast<std::size_t>(write.node)];
          for (std::size_t lane = 0; lane < static_cast<std::size_t>(node.width); ++lane) {
            gprs.at(static_cast<std::size_t>(location.gpr))[location.component[lane]] = write.lanes[lane];
          }
        }
      }
    }
    return condition;
  });
  return result;
}

}  // namespace aluminate::test
