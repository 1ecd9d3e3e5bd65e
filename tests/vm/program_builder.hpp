// Writes programs for tests in the order a person would read them: p.op(Opcode::Mad, r(0, "xyz"), v(0), c(1), l(p.literal(0.5))).
#pragma once

#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "shading/vm/program.hpp"

namespace aluminate::vm::testing {

inline std::array<std::uint8_t, 4> swizzle(std::string_view text) {
  std::array<std::uint8_t, 4> s{};
  for (std::size_t i = 0; i < 4; ++i) {
    const char c = text[std::min(i, text.size() - 1)];  // the last letter is repeated, as in ps_3_0 text
    s[i] = c == 'x' ? 0 : c == 'y' ? 1 : c == 'z' ? 2 : 3;
  }
  return s;
}

inline Source source(RegisterFile file, int index, std::string_view text) {
  Source s;
  s.file = file;
  s.index = static_cast<std::uint16_t>(index);
  s.swizzle = swizzle(text);
  return s;
}
inline Source r(int index, std::string_view text = "xyzw") { return source(RegisterFile::Temp, index, text); }
inline Source v(int index, std::string_view text = "xyzw") { return source(RegisterFile::Input, index, text); }
inline Source c(int index, std::string_view text = "xyzw") { return source(RegisterFile::Uniform, index, text); }
inline Source l(int index, std::string_view text = "xyzw") { return source(RegisterFile::Literal, index, text); }
inline Source loop_counter(int nest) { return source(RegisterFile::LoopCounter, nest, "x"); }
inline Source operator-(Source s) {
  s.negate = !s.negate;
  return s;
}
inline Source magnitude(Source s) {
  s.absolute = true;
  s.negate = false;
  return s;
}

inline Destination to(RegisterFile file, int index, std::string_view mask) {
  Destination d{file, static_cast<std::uint16_t>(index), 0};
  for (char ch : mask) d.mask |= static_cast<std::uint8_t>(ch == 'x' ? 1 : ch == 'y' ? 2 : ch == 'z' ? 4 : 8);
  return d;
}
inline Destination rd(int index, std::string_view mask = "xyzw") { return to(RegisterFile::Temp, index, mask); }
inline Destination o(int index, std::string_view mask = "xyzw") { return to(RegisterFile::Output, index, mask); }

/// Grows inputs, outputs, temps and uniforms to what the instructions name.
class Builder {
 public:
  Program program;

  int literal(double x, double y = 0, double z = 0, double w = 0) {
    program.literals.push_back({x, y, z, w});
    return static_cast<int>(program.literals.size()) - 1;
  }
  Instruction& op(Opcode opcode, Destination dst, std::initializer_list<Source> sources) {
    Instruction i;
    i.op = opcode;
    i.dst = dst;
    std::copy(sources.begin(), sources.end(), i.src.begin());
    i.line = {0, 1, static_cast<std::uint32_t>(program.code.size() + 1)};
    if (dst.mask != 0 && dst.file == RegisterFile::Temp) program.temp_count = std::max(program.temp_count, dst.index + 1);
    if (dst.mask != 0 && dst.file == RegisterFile::Output && program.outputs.size() <= dst.index)
      program.outputs.resize(dst.index + 1u);
    for (const Source& s : sources) {
      const int end = s.index + std::max<int>(1, s.relative.limit);
      if (s.file == RegisterFile::Temp) program.temp_count = std::max(program.temp_count, end);
      if (s.file == RegisterFile::Uniform) program.uniform_count = std::max(program.uniform_count, end);
      if (s.file == RegisterFile::Input && program.inputs.size() < static_cast<std::size_t>(end))
        program.inputs.resize(static_cast<std::size_t>(end));
      if (s.relative.base == RelativeBase::Temp) program.temp_count = std::max(program.temp_count, s.relative.index + 1);
    }
    program.code.push_back(i);
    return program.code.back();
  }
  void flow(Opcode opcode, std::initializer_list<Source> sources = {}) { op(opcode, {}, sources); }
  void loop(int trip_count = -1) { op(Opcode::Loop, {}, {}).trip_count = trip_count; }
};

}  // namespace aluminate::vm::testing
