// The compiled shader: what the compiler makes, the scheduler prices and the interpreter runs.
// Platform-neutral and number-format-neutral: registers are virtual vec4 registers (as many as the shader likes),
// values are numbers; grids are chosen when a program is prepared for a NumberFormat, words and GPRs when it is
// scheduled for a console.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace aluminate::vm {

enum class Pipe : std::uint8_t { Vector, Scalar, Either, Fetch, Flow };

enum class Opcode : std::uint8_t {
#define ALU_OP(name, mnemonic, sources, pipe, slots, meaning, rounding) name,
#include "shading/vm/isa.def"
#undef ALU_OP
};

struct OpcodeInfo {
  std::string_view name, mnemonic;
  int sources;
  Pipe pipe;
  int ps3_slots;
  std::string_view meaning, rounding;
};

inline constexpr std::array kOpcodes = {
#define ALU_OP(name, mnemonic, sources, pipe, slots, meaning, rounding) \
  OpcodeInfo{#name, mnemonic, sources, Pipe::pipe, slots, meaning, rounding},
#include "shading/vm/isa.def"
#undef ALU_OP
};

constexpr const OpcodeInfo& info(Opcode op) { return kOpcodes[static_cast<std::size_t>(op)]; }

enum class Stage : std::uint8_t { Vertex, Pixel };

enum class RegisterFile : std::uint8_t {
  Temp,         // r#: virtual vec4 register
  Input,        // v#: vertex attribute or interpolant, Program::inputs
  Output,       // o#: write only, Program::outputs
  Uniform,      // c#: bound by the caller, Program::uniforms names them
  Literal,      // l#: Program::literals
  LoopCounter,  // aL: iteration number of loop nest `index` (0 = outermost), 0, 1, 2, ...
};

/// Relative addressing of Uniform or Literal registers: register = index + scale * value.
enum class RelativeBase : std::uint8_t { None, LoopCounter, Temp };
struct Relative {
  RelativeBase base = RelativeBase::None;
  std::uint16_t index = 0;      // loop nest, or Temp register
  std::uint8_t component = 0;   // of the Temp register; its value is floored
  std::uint16_t scale = 1;      // registers per step
  std::uint16_t limit = 0;      // number of registers addressable from index: reads beyond are clamped to the last
  bool operator==(const Relative&) const = default;
};

struct Source {
  RegisterFile file = RegisterFile::Temp;
  std::uint16_t index = 0;
  std::array<std::uint8_t, 4> swizzle = {0, 1, 2, 3};  // component read for x, y, z, w
  bool negate = false;    // applied after absolute
  bool absolute = false;
  Relative relative{};
  bool operator==(const Source&) const = default;
};

struct Destination {
  RegisterFile file = RegisterFile::Temp;  // Temp or Output
  std::uint16_t index = 0;
  std::uint8_t mask = 0;                   // bit 0 = x ... bit 3 = w; 0 for Flow and Kill
};

/// A line of the user's source. file indexes Program::files; 0 line = not known.
struct SourceLine {
  std::uint16_t file = 0;
  std::uint16_t column = 0;
  std::uint32_t line = 0;
};

struct Instruction {
  Opcode op = Opcode::Mov;
  bool saturate = false;         // clamp the result to [0, 1]
  Destination dst{};
  std::array<Source, 3> src{};   // src[0..sources)
  std::uint8_t sampler = 0;      // Tex*: index into Program::samplers
  std::int32_t trip_count = -1;  // Loop: iterations known at compile time; -1 = until every lane has left by Break
  SourceLine line{};
};

enum class SamplerDimension : std::uint8_t { Tex2D, TexCube, Tex3D };

struct InputSymbol {             // one vec4 register v#
  std::string semantic;          // "POSITION0", "NORMAL0", "TEXCOORD3", "COLOR0", "VPOS0", "VFACE0"; upper case, with index
  std::uint8_t mask = 0xf;       // components the program reads
};
struct OutputSymbol {            // one vec4 register o#
  std::string semantic;          // "POSITION0", "TEXCOORD3", "COLOR0" (pixel: render target 0), "DEPTH0"
  std::uint8_t mask = 0xf;       // components the program writes
};
struct UniformSymbol {           // occupies registers c[reg .. reg + registers)
  std::string name;              // "world_to_clip", "light_position"
  int reg = 0;
  int registers = 1;             // array size x registers per element
  int components = 4;            // of one register, 1..4
  int component = 0;             // first one: members of structs may share a register ("lights[0].range" in .w)
};
struct SamplerSymbol {
  std::string name;
  SamplerDimension dimension = SamplerDimension::Tex2D;
  bool shadow_compare = false;
};

struct Program {
  std::string name;              // file or variant name for reports
  Stage stage = Stage::Pixel;
  std::vector<std::string> files;
  std::vector<Instruction> code;
  std::vector<std::array<double, 4>> literals;
  std::vector<InputSymbol> inputs;
  std::vector<OutputSymbol> outputs;
  std::vector<UniformSymbol> uniforms;
  std::vector<SamplerSymbol> samplers;
  int temp_count = 0;            // r0 .. r(temp_count-1)
  int uniform_count = 0;         // c0 .. c(uniform_count-1)

  /// True when every lane runs the same instructions the same number of times whatever its data: no If, Break or
  /// Continue, and every Loop counted. Kill does not matter: a killed lane keeps executing.
  bool straight_line() const;
};

/// Basic blocks: maximal runs of instructions between Flow instructions, in code order. The Flow instruction that ends
/// a block belongs to it. Counters and schedules are per block.
struct Block {
  std::uint32_t begin = 0, end = 0;   // [begin, end) in Program::code
  std::uint32_t static_trips = 1;     // product of the counted loops around it; 0 = not known at compile time
  std::uint8_t loop_depth = 0;
};
std::vector<Block> find_blocks(const Program& program);

/// Throws InternalError naming the instruction when registers, masks, swizzles, nesting or sampler indices are not valid.
void validate(const Program& program);

/// "mad r3.xyz, r1.xxxx, c4.xyzw, -r2.xyzw": one line, no newline.
std::string disassemble(const Program& program, const Instruction& instruction);

}  // namespace aluminate::vm
