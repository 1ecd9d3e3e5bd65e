#include <fmt/format.h>

#include "shading/vm/program.hpp"

namespace aluminate::vm {
namespace {

constexpr std::string_view kComponents = "xyzw";

std::string_view prefix(RegisterFile file) {
  switch (file) {
    case RegisterFile::Temp: return "r";
    case RegisterFile::Input: return "v";
    case RegisterFile::Output: return "o";
    case RegisterFile::Uniform: return "c";
    case RegisterFile::Literal: return "l";
    case RegisterFile::LoopCounter: return "aL";
  }
  return "?";
}

std::string register_name(const Source& s) {
  std::string name = fmt::format("{}{}", prefix(s.file), s.index);
  if (s.relative.base == RelativeBase::None) return name;
  const std::string offset = s.relative.base == RelativeBase::LoopCounter
                                 ? fmt::format("aL{}", s.relative.index)
                                 : fmt::format("r{}.{}", s.relative.index, kComponents[s.relative.component & 3]);
  return s.relative.scale == 1 ? fmt::format("{}[{}]", name, offset) : fmt::format("{}[{}*{}]", name, s.relative.scale, offset);
}

std::string source_text(const Source& s) {
  std::string name = register_name(s);
  if (s.file != RegisterFile::LoopCounter) {
    name += '.';
    for (auto component : s.swizzle) name += kComponents[component & 3];
  }
  if (s.absolute) name = "|" + name + "|";
  return s.negate ? "-" + name : name;
}

}  // namespace

std::string disassemble(const Program& program, const Instruction& instruction) {
  const OpcodeInfo& op = info(instruction.op);
  std::string text(op.mnemonic);
  if (instruction.saturate) text += "_sat";
  std::string separator = " ";
  const auto append = [&](const std::string& operand) {
    text += separator + operand;
    separator = ", ";
  };
  if (instruction.dst.mask != 0) {
    std::string name = fmt::format("{}{}.", prefix(instruction.dst.file), instruction.dst.index);
    for (std::size_t c = 0; c < 4; ++c)
      if ((instruction.dst.mask >> c & 1) != 0) name += kComponents[c];
    append(name);
  }
  for (int i = 0; i < op.sources; ++i) append(source_text(instruction.src[static_cast<std::size_t>(i)]));
  switch (instruction.op) {
    case Opcode::Tex:
    case Opcode::TexBias:
    case Opcode::TexLod:
    case Opcode::TexGrad:
      append(instruction.sampler < program.samplers.size() && !program.samplers[instruction.sampler].name.empty()
                 ? fmt::format("s{} ({})", instruction.sampler, program.samplers[instruction.sampler].name)
                 : fmt::format("s{}", instruction.sampler));
      break;
    case Opcode::Loop:
      if (instruction.trip_count >= 0) append(fmt::format("{}", instruction.trip_count));
      break;
    default: break;
  }
  return text;
}

}  // namespace aluminate::vm
