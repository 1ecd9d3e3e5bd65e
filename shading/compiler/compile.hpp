// Shader source in, vm::Program out. HLSL and GLSL go through the same road: glslang to SPIR-V, validator,
// SPIRV-Tools optimizer, validator again, then our own lowering to vec4 instructions. SPIR-V modules enter
// after the first step. In-process, safe to call from several threads, no state between calls. Never: hoists
// or unrolls anything the caller did not ask for; accepts an operation it cannot express exactly.
#pragma once

#include "shading/vm/program.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace aluminate::compiler {

enum class Language : std::uint8_t {
  Auto,
  Hlsl,
  Glsl,
  Spirv
};  // Auto: .hlsl .fx .fxh | .glsl .frag .vert | .spv

/// What happens to loops whose trip count is known at compile time. Other loops always stay loops.
enum class LoopMode : std::uint8_t {
  AsWritten,  // [unroll] unrolls, everything else stays rolled
  Rolled,     // every loop stays rolled, [unroll] or not; nothing is moved out of a loop
  Unrolled,   // every loop with a known trip count is unrolled, [loop] or not
};

struct Options {
  std::string source_path;  // names the source in errors and in Program::files; read when `source` is empty
  std::optional<std::string> source;  // text in memory (or the bytes of a SPIR-V module)
  Language language = Language::Auto;
  vm::Stage stage = vm::Stage::Pixel;
  std::string entry = "main";
  std::vector<std::pair<std::string, std::string>> defines;  // NAME, VALUE; an empty VALUE defines NAME as 1
  std::vector<std::string> include_dirs;                     // after the source's own folder
  std::map<std::string, std::string, std::less<>>
      files;  // in memory, by name: found by #include after include_dirs,
              // before the disk when the includer is in memory too
  LoopMode loops = LoopMode::AsWritten;
  std::map<std::string, double> spec_constants;  // by constant_id in decimal ("3") or by name
  bool optimise = true;  // false: inlining and SSA form only; same values, more instructions
  std::string name;      // Program::name; empty = file name of source_path
};

/// Compiles one entry point. The result passes vm::validate().
/// Throws UserError{file:line:column, what, hint} for anything wrong with the source, and for every operation
/// outside the supported set, by the operation's name.
///
/// Registers: HLSL register(cN) and register(sN) are honoured; uniforms without a register follow in
/// declaration order, 16-byte registers, cbuffer packing rules. Samplers are ordered by register. Inputs and
/// outputs are named by semantic, upper case with index: POSITION0, TEXCOORD3, COLOR0, VPOS0, VFACE0 (+1
/// front, -1 back), DEPTH0; GLSL locations N are TEXCOORDN, fragment outputs COLORN. Members of uniform
/// structs are named "lights[2].position". Numbers: literals are binary32 as the languages
/// say, binary64 with the suffix L (GLSL: lf). Integers are exact below 2^20 in magnitude, true is 1, false
/// is 0. Bit operations are refused except masks of low bits and shifts by constants.
vm::Program compile(const Options& options);

}  // namespace aluminate::compiler
