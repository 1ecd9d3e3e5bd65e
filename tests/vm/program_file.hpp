// Programs as bytes, so that a machine that cannot compile shaders can run what this one compiled. For machines of the same
// byte order and alignment; names and source lines are left behind.
#pragma once

#include <cstdint>
#include <istream>
#include <ostream>
#include <type_traits>

#include "shading/vm/program.hpp"

namespace aluminate::vm::testing {

static_assert(std::is_trivially_copyable_v<Instruction>);

template <class T>
void write_values(std::ostream& out, const T* values, std::size_t count) {
  out.write(reinterpret_cast<const char*>(values), static_cast<std::streamsize>(count * sizeof(T)));
}
template <class T>
bool read_values(std::istream& in, T* values, std::size_t count) {
  return static_cast<bool>(in.read(reinterpret_cast<char*>(values), static_cast<std::streamsize>(count * sizeof(T))));
}

struct ProgramHeader {
  std::uint64_t instruction_bytes = sizeof(Instruction), code = 0, literals = 0, inputs = 0, outputs = 0, samplers = 0;
  std::int32_t temps = 0, uniforms = 0;
  std::uint64_t stage = 0;
};

inline void write_program(std::ostream& out, const Program& p) {
  ProgramHeader h;
  h.code = p.code.size();
  h.literals = p.literals.size();
  h.inputs = p.inputs.size();
  h.outputs = p.outputs.size();
  h.samplers = p.samplers.size();
  h.temps = p.temp_count;
  h.uniforms = p.uniform_count;
  h.stage = static_cast<std::uint64_t>(p.stage);
  write_values(out, &h, 1);
  write_values(out, p.code.data(), p.code.size());
  write_values(out, p.literals.data(), p.literals.size());
  for (const InputSymbol& i : p.inputs) write_values(out, &i.mask, 1);
  for (const OutputSymbol& o : p.outputs) write_values(out, &o.mask, 1);
  for (const SamplerSymbol& s : p.samplers) {
    write_values(out, &s.dimension, 1);
    const std::uint8_t compare = s.shadow_compare ? 1 : 0;
    write_values(out, &compare, 1);
  }
}

/// False at the end of the file, or when it was written by a machine that lays instructions out otherwise.
inline bool read_program(std::istream& in, Program& p) {
  ProgramHeader h;
  if (!read_values(in, &h, 1) || h.instruction_bytes != sizeof(Instruction)) return false;
  p = {};
  p.code.resize(h.code);
  p.literals.resize(h.literals);
  p.inputs.resize(h.inputs);
  p.outputs.resize(h.outputs);
  p.samplers.resize(h.samplers);
  p.temp_count = h.temps;
  p.uniform_count = h.uniforms;
  p.stage = static_cast<Stage>(h.stage);
  bool good = read_values(in, p.code.data(), p.code.size()) && read_values(in, p.literals.data(), p.literals.size());
  for (InputSymbol& i : p.inputs) good = good && read_values(in, &i.mask, 1);
  for (OutputSymbol& o : p.outputs) good = good && read_values(in, &o.mask, 1);
  for (SamplerSymbol& s : p.samplers) {
    std::uint8_t compare = 0;
    good = good && read_values(in, &s.dimension, 1) && read_values(in, &compare, 1);
    s.shadow_compare = compare != 0;
  }
  return good;
}

}  // namespace aluminate::vm::testing
