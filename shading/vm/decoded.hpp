// The decoded form of a program: what the interpreter runs and a JIT would translate.
//   Operation  one result component for 64 lanes (or one dot product, one texture fetch, one test)
//   rows       offsets are in doubles from the start of a space; a row is 64 of them
// Everything is plain data; kernels are bound for the CPU at preparation.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "platform/number/format.hpp"
#include "shading/vm/executable.hpp"
#include "shading/vm/program.hpp"

namespace aluminate::vm {

/// Elementwise kernels are named for the scalar definition they repeat in 64 lanes (platform/number/scalar.hpp).
enum class Kernel : std::uint8_t {
  Copy,       // a, then absolute, then negate
  Saturate,   // dst = min(max(dst, 0), 1)
  ClampRange, // dst clamped to the grid's range, counted
  Frc, Flr, Trunc, Rcp, Rsq, Sqrt, Exp, Log, Sin, Cos,
  RcpReference, RsqReference, ExpReference, LogReference,  // ref64's own sequences
  Add,        // a + b
  Sub,        // a - b
  AddRound,   // ((a + M) + b) - M
  AddRoundSum,// ((a + b) + M) - M
  Mul, NegMul,                          // R(ab), R(-ab)
  Min, Max, Sge, Sgt, Seq, Sne,
  Mad, NegMad, MadNegC, NegMadNegC,     // R(+-ab +- c)
  CndGe, CndGt, CndEq,
  Dot2, Dot3, Dot4, NegDot2, NegDot3, NegDot4,  // sources a0 b0 a1 b1 ..., then the addend (Dot2 only)
  // not elementwise
  RelativeUniform,  // dst = space[offset + 4 * scale * clamp(index)], index from a row or a loop counter
  DsX, DsY,
  Texture,
  KillGt, KillGe, KillNe, KillEq,       // frame.killed
  NotZero,                              // frame.condition
};

enum class Space : std::uint8_t { Row, Input, Uniform, Literal, Loop };
inline constexpr int kSpaces = 5;

struct Operand {
  Space space = Space::Row;
  std::uint32_t offset = 0;
  bool is_row() const { return space == Space::Row || space == Space::Input; }
  bool operator==(const Operand&) const = default;
};

enum class Post : std::uint8_t {
  None,      // cannot leave the range
  Range,     // clamp and count
  Saturate,  // clamp to [0, 1], not counted
};

struct Operation;
struct Frame;
using KernelFunction = void (*)(const Operation&, Frame&) noexcept;

struct Operation {
  KernelFunction function = nullptr;
  const number::Grid* grid = nullptr;   // rounding and range
  double operand_step = 0;              // Rsq, Log
  std::uint32_t dst = 0;                // row offset
  std::uint32_t instruction = 0;        // index into Program::code
  std::array<Operand, 9> src{};
  Kernel kernel = Kernel::Copy;
  Post post = Post::None;
  bool masked = false;                  // writes lanes of the execution mask only
  bool absolute = false, negate = false;// Copy
  std::uint8_t sampler = 0;             // Texture
  Opcode texture_op = Opcode::Tex;
  SamplerDimension dimension = SamplerDimension::Tex2D;
  std::uint8_t texture_mask = 0;        // Texture: components wanted, to rows texture_dst
  std::array<std::uint32_t, 4> texture_dst{};
  Relative relative{};                  // RelativeUniform
  std::uint8_t loop_level = 0;          // RelativeUniform by loop counter: index into Frame::iterations
};

enum class Flow : std::uint8_t { None, If, Else, EndIf, Loop, EndLoop, Break, Continue };

struct DecodedBlock {
  std::uint32_t first = 0, last = 0;    // operations [first, last)
  Flow flow = Flow::None;               // what ends the block
  std::uint8_t level = 0;               // of the If or Loop this flow instruction belongs to; Break, Continue: of the loop
  std::uint8_t loop = 0;                // loop nest number (Loop, EndLoop)
  std::int32_t trip_count = -1;         // Loop, EndLoop
  std::uint32_t target = 0;             // If, Else: block whose end is the matching Else or EndIf; Loop: of EndLoop;
                                        // EndLoop: first block of the body; EndIf, Break, Continue: block that ends the
                                        // enclosing region, for when no lane is left
  std::uint32_t instruction = 0;        // the Loop instruction (Loop, EndLoop)
};

struct Decoded {
  number::NumberFormat format;
  std::vector<RowBinding> inputs, outputs;
  std::vector<std::uint32_t> output_rows;       // row offset of each output
  std::vector<std::uint32_t> zero_rows;         // row offsets cleared before the first instruction
  std::vector<std::uint8_t> frac_bits;          // per instruction of the program: f of the grid it rounds to
  std::vector<number::Grid> grids;              // Operation::grid points in here
  std::vector<double> literals;                 // quantised, 4 per register
  std::vector<Operation> operations;
  std::vector<DecodedBlock> blocks;             // one per find_blocks(program)
  number::Grid input_grid;
  double loop_value_limit = 0;                  // greatest number of the format: loop counters stop there
  /// How often each block runs whatever the data; empty when data decide.
  std::vector<std::uint64_t> straight_trips;
  std::size_t instruction_count = 0;
  std::size_t uniform_values = 0;               // doubles of the constant bank
  int input_row = 0;                            // first of inputs.size() rows for sanitised inputs
  int row_count = 0;
  int level_count = 0;                          // deepest nesting of If and Loop
  int loop_count = 0;                           // deepest nesting of Loop
};

inline constexpr int kMaxLoops = 64;  // validate() allows no deeper nesting

/// What kernels see of a running batch.
struct Frame {
  double* rows = nullptr;
  const double* base[kSpaces] = {};
  std::uint64_t exec = 0;        // lanes executing now
  std::uint64_t active = 0;
  std::uint64_t covered = 0;
  std::uint64_t killed = 0;
  std::uint64_t condition = 0;   // result of NotZero
  std::uint64_t* saturations = nullptr;
  Counters* counters = nullptr;
  const SamplerBinding* samplers = nullptr;
  std::int32_t iterations[kMaxLoops] = {};   // by loop nest number
  double loop_values[kMaxLoops] = {};        // the same as register values: never beyond the format's range
};

/// Kernels for the best instruction set of this CPU. src_const: bit i set = source i is one number for all lanes.
struct KernelKey {
  Kernel kernel = Kernel::Copy;
  std::uint8_t src_const = 0;
  Post post = Post::None;
  bool masked = false;
};
/// nullptr when no kernel takes that combination of constant sources: copy one to a row then.
KernelFunction find_kernel(const KernelKey& key);

/// Rounds input rows to the grid; inactive lanes become 0. Returns replaced values in covered lanes.
std::uint64_t sanitise_row(const number::Grid& grid, const double* from, double* to, std::uint64_t active,
                           std::uint64_t covered);
/// |value| <= bound for all of them; false for NaN.
bool all_within(const double* values, std::size_t count, double bound);
/// Copies the lanes of mask.
void copy_row(const double* from, double* to, std::uint64_t mask);

/// Name of the instruction set find_kernel() picks: "AVX3", "AVX2", "EMU128".
const char* kernel_target();
/// All that are compiled in and run on this CPU; force_kernel_target(name) makes later prepare() calls use one of them,
/// force_kernel_target(nullptr) returns to the best. For tests.
std::vector<const char*> kernel_targets();
void force_kernel_target(const char* name);

}  // namespace aluminate::vm
