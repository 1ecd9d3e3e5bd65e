#include "shading/cost/xenos_text.hpp"

#include "shading/cost/slots.hpp"

#include <fmt/format.h>

namespace aluminate::cost {
namespace {

constexpr char kComponents[] = "xyzw";

class RowWriter {
 public:
  RowWriter(const vm::Program& program, const ScheduledBlock& block, const RegisterMap& map)
      : program_(program), block_(block), map_(map) {}

  std::string text(int n, bool scalar_half, bool second_slot) const {
    const Node& node = block_.graph.nodes[static_cast<std::size_t>(n)];
    std::string line = mnemonic(node, scalar_half, second_slot);
    std::string operands = destination(n);
    const int skipped = second_slot ? carried_operand(block_.graph, node) : -1;
    for (int s = 0; s < node.sources; ++s) {
      const std::string source = s == skipped ? "ps" : operand(node.src[static_cast<std::size_t>(s)]);
      operands += (operands.empty() ? "" : ", ") + source;
    }
    if (node.is_fetch() && node.special == Special::None && is_texture(node.op))
      operands += ", " + program_.samplers[node.sampler].name;
    return line + " " + operands;
  }

  std::string move_text(int n) const {
    const Node& node = block_.graph.nodes[static_cast<std::size_t>(n)];
    return "movs ps, " + operand(node.src[static_cast<std::size_t>(carried_operand(block_.graph, node))]);
  }

 private:
  std::string mnemonic(const Node& node, bool scalar_half, bool second_slot) const {
    std::string name(vm::info(node.op).mnemonic);
    switch (node.special) {
      case Special::Cube:
        name = "cube";
        break;
      case Special::SetPredicate:
        name = "setp_" + name;
        break;
      case Special::LoadAddress:
        name = "mova";
        break;
      case Special::FetchSetup:
        name = "setlod/setgrad";
        break;
      case Special::None:
        if (is_texture(node.op)) {
          const vm::SamplerDimension dimension = program_.samplers[node.sampler].dimension;
          name = dimension == vm::SamplerDimension::Tex2D   ? "tfetch2D"
                 : dimension == vm::SamplerDimension::Tex3D ? "tfetch3D"
                                                            : "tfetchCube";
        } else if (scalar_half) {
          const bool constant =
              node.sources == 2 && (node.src[0].refs[0].is_constant() || node.src[1].refs[0].is_constant());
          if (vm::info(node.op).pipe == vm::Pipe::Either) name += constant ? "sc" : "s";
          if (second_slot) name += "_prev";
        }
        break;
    }
    return node.saturate ? name + "_sat" : name;
  }

  std::string destination(int n) const {
    const Node& node = block_.graph.nodes[static_cast<std::size_t>(n)];
    std::string mask;
    if (node.dest == DestKind::Effect) return "";
    if (node.dest == DestKind::Value) {
      const Location& location = block_.results[static_cast<std::size_t>(n)];
      std::string lanes = "____";
      for (int lane = 0; lane < node.width; ++lane) {
        const std::uint8_t c = location.component[static_cast<std::size_t>(lane)];
        lanes[c] = kComponents[c];
      }
      std::erase(lanes, '_');
      return fmt::format("r{}.{}", location.gpr, lanes);
    }
    for (std::size_t c = 0; c < 4; ++c) {
      if (node.dest_lane[c] >= 0) mask += kComponents[c];
    }
    if (node.dest == DestKind::Home) return fmt::format("r{}.{}", map_.home_gpr[node.dest_index], mask);
    for (std::size_t c = 0; c < 4; ++c) {
      if (node.export_constants >> c & 1) mask += node.export_values[c] == 0.0 ? '0' : '1';
    }
    return fmt::format("o{}.{}", node.dest_index, mask);
  }

  std::string operand(const Operand& source) const {
    std::string name, swizzle;
    for (int i = 0; i < source.count; ++i) {
      const Ref& ref = source.refs[static_cast<std::size_t>(i)];
      std::uint8_t c = ref.component;
      switch (ref.kind) {
        case Ref::Kind::Node: {
          const Location& location = block_.results[ref.index];
          name = fmt::format("r{}", location.gpr);
          c = location.component[ref.component];
          break;
        }
        case Ref::Kind::Input:
          name = fmt::format("r{}", map_.input_gpr[ref.index]);
          break;
        case Ref::Kind::Home:
          name = fmt::format("r{}", map_.home_gpr[ref.index]);
          break;
        case Ref::Kind::Counter:
          name = "aL";
          break;
        case Ref::Kind::Constant:
          name = fmt::format("{}{}", ref.file == vm::RegisterFile::Uniform ? "c" : "l", ref.index);
          if (ref.relative.base == vm::RelativeBase::Temp) name += "[a0]";
          if (ref.relative.base == vm::RelativeBase::LoopCounter) name += "[aL]";
          break;
        case Ref::Kind::Literal:
          name += (name.empty() ? "(" : ", ") + fmt::format("{:.6g}", ref.value);
          break;
      }
      if (ref.kind != Ref::Kind::Literal && ref.kind != Ref::Kind::Counter) swizzle += kComponents[c];
    }
    if (source.refs[0].kind == Ref::Kind::Literal) name += ")";
    if (!swizzle.empty()) name += "." + swizzle;
    if (source.absolute) name = "|" + name + "|";
    return source.negate ? "-" + name : name;
  }

  const vm::Program& program_;
  const ScheduledBlock& block_;
  const RegisterMap& map_;
};

int clause_of(const BlockSchedule& schedule, int issue) {
  if (schedule.export_start <= 0 || issue < schedule.export_start) return issue / kClauseIssues;
  return (schedule.export_start + kClauseIssues - 1) / kClauseIssues +
         (issue - schedule.export_start) / kClauseIssues;
}

}  // namespace

std::vector<ListingRow> xenos_rows(const vm::Program& program, int block_index, const ScheduledBlock& block,
                                   const RegisterMap& map) {
  const RowWriter writer(program, block, map);
  std::vector<ListingRow> rows;
  for (std::size_t i = 0; i < block.schedule.issues.size(); ++i) {
    const Issue& issue = block.schedule.issues[i];
    const auto row = [&](const char* pipe, int n, std::string text) {
      const Node& node = block.graph.nodes[static_cast<std::size_t>(n)];
      ListingRow entry;
      entry.block = block_index;
      entry.clause = clause_of(block.schedule, static_cast<int>(i));
      entry.word = static_cast<int>(i);
      entry.pipe = pipe;
      entry.text = std::move(text);
      entry.line = node.line;
      entry.origin = node.origin;
      rows.push_back(std::move(entry));
    };
    if (issue.is_fetch()) row("T", issue.fetch, writer.text(issue.fetch, false, false));
    if (issue.vector >= 0) row("V", issue.vector, writer.text(issue.vector, false, false));
    if (issue.scalar >= 0) row("S", issue.scalar, writer.text(issue.scalar, true, issue.uses_previous));
    if (issue.previous_move >= 0) {
      row("S", issue.previous_move, writer.move_text(issue.previous_move));
    }
  }
  return rows;
}

std::vector<ListingRow> program_rows(const vm::Program& program, int block_index, const Graph& graph,
                                     int node, int word, const std::string& unit) {
  const Node& operation = graph.nodes[static_cast<std::size_t>(node)];
  ListingRow row;
  row.block = block_index;
  row.word = word;
  row.pipe = unit;
  row.text = vm::disassemble(program, program.code[operation.origin]);
  row.line = operation.line;
  row.origin = operation.origin;
  return {row};
}

}  // namespace aluminate::cost
