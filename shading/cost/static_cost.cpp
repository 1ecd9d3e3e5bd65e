#include "shading/cost/static_cost.hpp"

#include "platform/console/occupancy.hpp"
#include "platform/host/error.hpp"
#include "shading/cost/program_paths.hpp"
#include "shading/cost/slots.hpp"
#include "shading/cost/wide_models.hpp"
#include "shading/cost/xenos_lowering.hpp"
#include "shading/cost/xenos_program.hpp"
#include "shading/cost/xenos_rewrite.hpp"
#include "shading/cost/xenos_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

namespace aluminate::cost {
namespace {

using console::AluModel;
using console::GpuModel;
using vm::Opcode;

const char* word_name_of(AluModel model) {
  switch (model) {
    case AluModel::Vec4PlusScalar:
      return "vec4+scalar word";
    case AluModel::DualSu:
      return "dual-SU pass";
    case AluModel::Vliw5:
      return "VLIW5 bundle";
    case AluModel::ScalarLane:
      return "component operation";
    case AluModel::MaliWord:
      return "Utgard word";
  }
  return "word";
}

/// Words attributed to the source line of a word's first operation.
using WordsByOrigin = std::vector<std::pair<vm::SourceLine, double>>;

/// Slots, operations and fetches: the same on every platform.
void count_instructions(const vm::Program& program, const vm::Block& block, const GpuModel& gpu,
                        const Assumptions& assumptions, const std::vector<int>& slots, BlockCost& cost) {
  const auto mipmapped = [&](vm::SamplerDimension dimension) {
    return assumptions.filter == FilterAssumption::Trilinear ||
           (assumptions.filter == FilterAssumption::Targets && dimension == vm::SamplerDimension::TexCube);
  };
  for (std::uint32_t i = block.begin; i < block.end; ++i) {
    const vm::Instruction& instruction = program.code[i];
    cost.alu_slots += slots[i];
    cost.tex_slots += texture_slots(program, instruction);
    if (is_texture(instruction.op)) {
      ++cost.fetches;
      const vm::SamplerDimension dimension = program.samplers[instruction.sampler].dimension;
      const bool is_anisotropic = dimension == vm::SamplerDimension::Tex2D && instruction.op != Opcode::TexLod;
      cost.fetch_cyc += (mipmapped(dimension) ? gpu.texture.trilinear_cyc.value : 1.0) *
                        (is_anisotropic ? assumptions.anisotropy : 1) *
                        (dimension == vm::SamplerDimension::Tex3D ? gpu.texture.volume_cyc.value : 1.0);
    }
  }
}

void count_graph(const Graph& graph, BlockCost& cost) {
  for (const Node& node : graph.nodes) {
    if (node.removed) continue;
    // Gradients and set-up words occupy the fetch pipe for a bilinear cycle each; texture fetches are counted
    // above.
    if (node.is_fetch() && (node.special == Special::FetchSetup || !is_texture(node.op)))
      cost.fetch_cyc += 1.0;
  }
}

void price_xenos(const vm::Program& program, const Assumptions& assumptions, StaticCost& cost,
                 WordsByOrigin& words) {
  const ScheduledProgram scheduled = schedule_program(program, assumptions.pairing);
  cost.gprs = scheduled.registers.gprs;
  for (std::size_t b = 0; b < scheduled.blocks.size(); ++b) {
    const ScheduledBlock& block = scheduled.scheduled[b];
    BlockCost& entry = cost.blocks[b];
    entry.alu_words = block.schedule.words;
    entry.bound_words = block.schedule.bound_words;
    entry.exec_clauses = block.schedule.clauses;
    count_graph(block.graph, entry);
    for (const Issue& issue : block.schedule.issues) {
      entry.vector_ops += issue.vector >= 0;
      entry.scalar_ops += (issue.scalar >= 0) + (issue.previous_move >= 0);
      if (issue.is_fetch()) continue;
      const int first = issue.vector >= 0   ? issue.vector
                        : issue.scalar >= 0 ? issue.scalar
                                            : issue.previous_move;
      words.emplace_back(block.graph.nodes[static_cast<std::size_t>(first)].line,
                         std::max(1u, entry.static_trips));
    }
    std::vector<ListingRow> rows = xenos_rows(program, static_cast<int>(b), block, scheduled.registers);
    cost.listing.insert(cost.listing.end(), rows.begin(), rows.end());
  }
}

void price_wide(const vm::Program& program, const std::vector<vm::Block>& blocks, const GpuModel& gpu,
                StaticCost& cost, WordsByOrigin& words) {
  const std::vector<std::uint8_t> homes = components_across_blocks(program, blocks);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const Graph graph = lower_block(program, blocks[b], homes, Packing::Off);
    const WideSchedule schedule = schedule_wide(graph, gpu.alu_model);
    BlockCost& entry = cost.blocks[b];
    entry.alu_words = schedule.words;
    entry.bound_words = static_cast<int>(std::ceil(schedule.bound_words));
    entry.exec_clauses = (static_cast<int>(schedule.words) + kClauseIssues - 1) / kClauseIssues;
    count_graph(graph, entry);
    int last_word = -1;
    for (const PlacedOperation& placed : schedule.placed) {
      const Node& node = graph.nodes[static_cast<std::size_t>(placed.node)];
      const bool scalar = node.special == Special::None && vm::info(node.op).pipe == vm::Pipe::Scalar;
      if (!node.is_fetch()) ++(scalar ? entry.scalar_ops : entry.vector_ops);
      const std::vector<ListingRow> rows =
          program_rows(program, static_cast<int>(b), graph, placed.node, placed.word, placed.unit);
      cost.listing.insert(cost.listing.end(), rows.begin(), rows.end());
      if (placed.word != last_word) words.emplace_back(node.line, std::max(1u, entry.static_trips));
      last_word = placed.word;
    }
  }
  const bool inputs_in_registers = gpu.alu_model == AluModel::Vliw5 || gpu.alu_model == AluModel::ScalarLane;
  cost.gprs = live_registers(program, inputs_in_registers);
  if (gpu.alu_model == AluModel::DualSu)
    cost.gprs = std::max(cost.gprs, 2);  // the least the console's tools report [UNI]
}

struct Interpolants {
  int all = 0, coordinates = 0;
  bool color = false;
};

Interpolants interpolants_of(const vm::Program& program) {
  Interpolants found;
  for (const vm::InputSymbol& input : program.inputs) {
    if (input.mask == 0 || input.semantic.starts_with("VPOS") || input.semantic.starts_with("VFACE"))
      continue;
    ++found.all;
    if (input.semantic.starts_with("COLOR")) {
      found.color = true;
    } else {
      ++found.coordinates;
    }
  }
  return found;
}

UnitCycles cycles_of(const vm::Program& program, const GpuModel& gpu, const PathSum& path) {
  UnitCycles cycles;
  const bool vertex = program.stage == vm::Stage::Vertex;
  cycles.alu = path[0] * kVectorPixels / (vertex ? gpu.vertex.lanes_per_clk : gpu.alu.lanes_per_clk).value;
  cycles.texture = path[1] * kVectorPixels / gpu.texture.bilinear_per_clk.value;
  cycles.sequencer = gpu.sequencer.clk_base.value + gpu.sequencer.clk_per_clause.value * path[2];
  if (vertex) {
    cycles.vertex = gpu.vertex.fetch_clk_per_64.value;
    return cycles;
  }
  const Interpolants interpolants = interpolants_of(program);
  cycles.interpolator = std::max(gpu.interpolator.clk_min.value,
                                 gpu.interpolator.clk_per_interpolant.value * interpolants.coordinates) +
                        (interpolants.color ? gpu.interpolator.clk_color_extra.value : 0.0);
  return cycles;
}

std::array<double, 5> as_array(const UnitCycles& cycles) {
  return {cycles.alu, cycles.texture, cycles.vertex, cycles.sequencer, cycles.interpolator};
}

void name_bound(StaticCost& cost) {
  std::array<double, 5> units = as_array(cost.cycles);
  const auto worst = std::max_element(units.begin(), units.end());
  cost.bound = static_cast<CostUnit>(worst - units.begin());
  // Thirds of a clock are exact multiples of 1/3 in principle; guard the floor against the last bit.
  cost.cycles_per_vector = static_cast<int>(std::floor(*worst + 1e-9));
  const double most = *worst;
  *worst = -1;
  const auto next = std::max_element(units.begin(), units.end());
  cost.sentence = fmt::format(
      "bound by {}: {:.2f} clocks for 64 {}; next {} at {:.0f} %", cost_unit_name(cost.bound), most,
      cost.stage == vm::Stage::Vertex ? "vertices" : "pixels",
      cost_unit_name(static_cast<CostUnit>(next - units.begin())), most > 0 ? 100.0 * *next / most : 0.0);
}

void collect_lines(const vm::Program& program, const std::vector<vm::Block>& blocks,
                   const std::vector<int>& slots, const WordsByOrigin& words, StaticCost& cost) {
  std::map<std::tuple<std::uint16_t, std::uint32_t>, LineCost> lines;
  const auto at = [&](const vm::SourceLine& line) -> LineCost& {
    LineCost& entry = lines[{line.file, line.line}];
    if (entry.line.line == 0) entry.line = line;
    return entry;
  };
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const int trips = static_cast<int>(std::max(1u, blocks[b].static_trips));
    for (std::uint32_t i = blocks[b].begin; i < blocks[b].end; ++i) {
      LineCost& entry = at(program.code[i].line);
      entry.alu_slots += trips * slots[i];
      entry.fetches += trips * (is_texture(program.code[i].op) ? 1 : 0);
    }
  }
  for (const auto& [line, count] : words) at(line).alu_words += count;
  for (auto& [key, entry] : lines) cost.lines.push_back(entry);
}

}  // namespace

double UnitCycles::worst() const {
  const std::array<double, 5> units = as_array(*this);
  return *std::max_element(units.begin(), units.end());
}

const char* cost_unit_name(CostUnit unit) {
  constexpr const char* kNames[] = {"ALU", "texture", "vertex", "sequencer", "interpolator"};
  return kNames[static_cast<std::size_t>(unit)];
}

StaticCost price(const vm::Program& program, const GpuModel& gpu, const Assumptions& assumptions) {
  StaticCost cost;
  cost.name = program.name;
  cost.platform = gpu.id;
  cost.word_name = word_name_of(gpu.alu_model);
  cost.stage = program.stage;
  cost.assumptions = assumptions;
  cost.files = program.files;

  const std::vector<vm::Block> blocks = vm::find_blocks(program);
  cost.blocks.resize(blocks.size());
  const std::vector<int> slots = instruction_slots(program);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    cost.blocks[b].static_trips = blocks[b].static_trips;
    count_instructions(program, blocks[b], gpu, assumptions, slots, cost.blocks[b]);
  }
  WordsByOrigin words;
  if (gpu.alu_model == AluModel::Vec4PlusScalar) {
    price_xenos(program, assumptions, cost, words);
  } else {
    price_wide(program, blocks, gpu, cost, words);
  }
  std::set<std::uint32_t> shown;  // slots stand on the first row of each instruction
  for (ListingRow& row : cost.listing)
    row.alu_slots = shown.insert(row.origin).second ? slots[row.origin] : 0;
  const int most_gprs = static_cast<int>(gpu.registers.per_thread_max.value);
  if (cost.gprs > most_gprs) {
    throw UserError(
        fmt::format("{}: needs {} vec4 registers, {} has {} a thread",
                    program.name.empty() ? "program" : program.name, cost.gprs, gpu.id, most_gprs),
        "spilling is not modelled: keep fewer values alive across the program");
  }
  cost.threads = console::threads_in_flight(gpu, cost.gprs, program.stage == vm::Stage::Vertex);
  cost.interpolators = program.stage == vm::Stage::Pixel ? interpolants_of(program).all : 0;

  std::vector<PathSum> of_block;
  for (const BlockCost& block : cost.blocks) {
    const int trips = static_cast<int>(std::max(1u, block.static_trips));
    cost.alu_words += trips * block.alu_words;
    cost.alu_slots += trips * block.alu_slots;
    cost.tex_slots += trips * block.tex_slots;
    cost.vector_ops += trips * block.vector_ops;
    cost.scalar_ops += trips * block.scalar_ops;
    cost.fetches += trips * block.fetches;
    cost.fetch_cyc += trips * block.fetch_cyc;
    cost.exec_clauses += trips * block.exec_clauses;
    cost.bound_words += trips * block.bound_words;
    of_block.push_back({block.alu_words, block.fetch_cyc, static_cast<double>(block.exec_clauses)});
  }
  const PathBounds paths = bound_paths(program, blocks, of_block);
  cost.straight_line = paths.straight_line;
  cost.paths_known = paths.known;
  cost.shortest_words = paths.shortest[0];
  cost.longest_words = paths.longest[0];
  cost.shortest = cycles_of(program, gpu, paths.shortest);
  cost.longest = cycles_of(program, gpu, paths.longest);
  cost.cycles = cost.longest;
  name_bound(cost);
  collect_lines(program, blocks, slots, words, cost);
  return cost;
}

LightCost marginal_light(const StaticCost& n, const StaticCost& more) {
  LightCost light;
  light.loop = "unrolled";
  light.convention = "unrolled, hoisted";
  light.alu_words = more.alu_words - n.alu_words;
  light.alu_slots = more.alu_slots - n.alu_slots;
  light.fetches = more.fetches - n.fetches;
  return light;
}

LightCost loop_body_light(const vm::Program& program, const StaticCost& cost) {
  const std::vector<vm::Block> blocks = vm::find_blocks(program);
  const std::vector<int> slots = instruction_slots(program);
  LightCost light;
  light.loop = "rolled";
  light.convention = "rolled loop, ps_3_0 slots, nothing hoisted";
  std::size_t begin = 0;
  while (begin < blocks.size() && blocks[begin].loop_depth == 0) ++begin;
  if (begin == blocks.size()) {
    throw UserError(fmt::format("{} has no loop", program.name.empty() ? "program" : program.name),
                    "compile it with its light loop rolled");
  }
  const double outer_trips = std::max(1u, blocks[begin].static_trips);
  for (std::size_t b = begin; b < blocks.size() && blocks[b].loop_depth > 0; ++b) {
    // A block inside an inner loop runs more often than the body itself.
    const double times = std::max(1u, blocks[b].static_trips) / outer_trips;
    int flow_slots = 0;
    for (std::uint32_t i = blocks[b].begin; i < blocks[b].end; ++i) {
      const Opcode op = program.code[i].op;
      if (op == Opcode::Loop || op == Opcode::EndLoop) flow_slots += slots[i];
    }
    light.alu_words += times * cost.blocks[b].alu_words;
    light.alu_slots += static_cast<int>(times * (cost.blocks[b].alu_slots - flow_slots));
    light.fetches += static_cast<int>(times * cost.blocks[b].fetches);
  }
  return light;
}

}  // namespace aluminate::cost
