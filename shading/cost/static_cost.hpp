// A shader's price before it runs: schedule of every block on a console, and the estimate the console's own
// tools printed ("cycles per 64-pixel vector"). Program and GpuModel in, numbers and one sentence out; runs
// nothing. Static, marginal per light and executed are three different things: this is the first two; the VM
// multiplies BlockCost by its executed counts for the third.
#pragma once

#include "platform/console/gpu_model.hpp"
#include "shading/vm/program.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace aluminate::cost {

inline constexpr int kVectorPixels = 64;  // the estimate's unit on every platform

/// What the estimate assumes about textures; the default is the period tool's own assumption (8 bits a
/// component, bilinear). Targets: flat textures are targets read back, one texel each, cube maps have mips. The
/// multipliers are figures of the platform.
enum class FilterAssumption : std::uint8_t { Bilinear, Trilinear, Targets };
enum class PairingRule : std::uint8_t {
  Strict,
  Loose
};  // Loose ignores the third-source rule: for sensitivity only

struct Assumptions {
  FilterAssumption filter = FilterAssumption::Bilinear;
  PairingRule pairing = PairingRule::Strict;
  int anisotropy = 1;  // samples of every flat fetch that has derivatives: the most its sampler allows
};

/// One execution of one block by one lane. Index = block of vm::find_blocks(program).
struct BlockCost {
  double alu_words =
      0;              // issue words (passes, bundles) of the platform; whole except on scalar-lane platforms
  int alu_slots = 0;  // ps_3_0 slots, texture fetches not counted
  int tex_slots = 0;  // ps_3_0 slots of the texture fetches
  int vector_ops = 0, scalar_ops = 0;
  int fetches = 0;  // texture instructions of the program (DsX, DsY not counted)
  double fetch_cyc =
      0;  // bilinear 32-bit cycles, filter assumption applied; DsX, DsY and set-LOD words included
  int exec_clauses = 0;
  int bound_words = 0;             // no schedule of this block can be shorter
  std::uint32_t static_trips = 1;  // of vm::Block; 0 = not known
};

/// Words whose first operation comes from a source line, straight through the program once.
struct LineCost {
  vm::SourceLine line{};
  double alu_words = 0;
  int alu_slots = 0, fetches = 0;
};

/// Clocks the whole chip needs for 64 pixels (or vertices), unit by unit.
struct UnitCycles {
  double alu = 0, texture = 0, vertex = 0, sequencer = 0, interpolator = 0;
  double worst() const;
};

enum class CostUnit : std::uint8_t { Alu, Texture, Vertex, Sequencer, Interpolator };
const char* cost_unit_name(CostUnit unit);  // "ALU", "texture", "vertex", "sequencer", "interpolator"

/// One row of a listing: an instruction as it issues.
struct ListingRow {
  int block = 0;
  int clause = 0;    // exec clause of the block, from 0
  int word = 0;      // position in the block; the halves of a word share it
  std::string pipe;  // "V", "S", "T"; "SU0", "SU1"; "-" for flow
  std::string text;  // "mad r3.xyz, r1.xxx, c4.xyz, -r2.xyz"
  vm::SourceLine line{};
  std::uint32_t origin = 0;  // index in Program::code
  int alu_slots = 0;  // 0 on rows that only exist on the platform
};

/// The cost of one more light. loop says how it was obtained and what the convention is.
struct LightCost {
  std::string loop;        // "rolled" or "unrolled"; empty = not asked for
  std::string convention;  // "rolled loop, ps_3_0 slots, nothing hoisted" / "unrolled, hoisted"
  double alu_words = 0;
  int alu_slots = 0, fetches = 0;
};

struct StaticCost {
  std::string name;       // Program::name
  std::string platform;   // GpuModel::id
  std::string word_name;  // "vec4+scalar word", "dual-SU pass", ...
  vm::Stage stage = vm::Stage::Pixel;

  // Whole program: counted loops multiplied out, both sides of every If, loops of unknown length once.
  double alu_words = 0;
  int alu_slots = 0, tex_slots = 0;
  int vector_ops = 0, scalar_ops = 0;
  int fetches = 0;
  double fetch_cyc = 0;
  int interpolators = 0;
  int gprs = 0, threads = 0;
  int exec_clauses = 0;
  int bound_words = 0;  // lower bound of alu_words, same multiplication
  UnitCycles cycles;    // of the longest path
  CostUnit bound = CostUnit::Alu;
  int cycles_per_vector = 0;  // floor(worst unit): the estimate's last line
  std::string sentence;       // "ALU bound: 18.67 of 18.67 clocks a 64-pixel vector; next sequencer at 54 %"

  // Branchy programs: both ends. Equal to `cycles` for straight-line ones. paths_known is false when a loop's
  // length is not known: it is then taken as 0 in the shortest and once in the longest path.
  bool straight_line = true, paths_known = true;
  double shortest_words = 0, longest_words = 0;
  UnitCycles shortest, longest;

  std::vector<BlockCost> blocks;  // parallel to vm::find_blocks
  std::vector<LineCost> lines;    // sorted by file and line
  std::vector<ListingRow> listing;
  LightCost per_light;
  Assumptions assumptions;
  std::vector<std::string> files;  // Program::files, for listings
};

/// Throws UserError naming the program when it needs more registers than the platform has.
StaticCost price(const vm::Program& program, const console::GpuModel& gpu,
                 const Assumptions& assumptions = {});

/// Marginal cost of a light from the same unrolled shader with N and N+1 lights: "unrolled, hoisted".
LightCost marginal_light(const StaticCost& lights_n, const StaticCost& lights_n_plus_1);

/// Body of the program's first outermost loop, nested blocks included: "rolled loop, ps_3_0 slots, nothing
/// hoisted". Loop control itself is not counted. Throws UserError when the program has no loop.
LightCost loop_body_light(const vm::Program& program, const StaticCost& cost);

}  // namespace aluminate::cost
