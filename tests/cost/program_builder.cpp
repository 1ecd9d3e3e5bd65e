#include "tests/cost/program_builder.hpp"

#include <sstream>
#include <stdexcept>

namespace aluminate::test {
namespace {

using namespace vm;

std::uint8_t component(char c) {
  switch (c) {
    case 'x':
    case 'r':
      return 0;
    case 'y':
    case 'g':
      return 1;
    case 'z':
    case 'b':
      return 2;
    case 'w':
    case 'a':
      return 3;
    default:
      throw std::runtime_error(std::string("component ") + c);
  }
}

struct Register {
  RegisterFile file;
  std::uint16_t index;
  std::string swizzle;
};

Register register_of(std::string word) {
  Register reg{};
  const auto dot = word.find('.');
  if (dot != std::string::npos) {
    reg.swizzle = word.substr(dot + 1);
    word.resize(dot);
  }
  switch (word.at(0)) {
    case 'r':
      reg.file = RegisterFile::Temp;
      break;
    case 'v':
      reg.file = RegisterFile::Input;
      break;
    case 'o':
      reg.file = RegisterFile::Output;
      break;
    case 'c':
      reg.file = RegisterFile::Uniform;
      break;
    case 'l':
      reg.file = RegisterFile::Literal;
      break;
    default:
      throw std::runtime_error("register " + word);
  }
  reg.index = static_cast<std::uint16_t>(std::stoi(word.substr(1)));
  return reg;
}

Source source_of(std::string word) {
  Source source;
  if (word.at(0) == '-') {
    source.negate = true;
    word.erase(0, 1);
  }
  if (word.at(0) == '|') {
    source.absolute = true;
    std::erase(word, '|');
  }
  const Register reg = register_of(word);
  source.file = reg.file;
  source.index = reg.index;
  if (!reg.swizzle.empty()) {
    for (std::size_t i = 0; i < 4; ++i)
      source.swizzle[i] = component(reg.swizzle[std::min(i, reg.swizzle.size() - 1)]);
  }
  return source;
}

}  // namespace

Program program_from_text(const std::string& text, const std::string& name) {
  Program program;
  program.name = name;
  program.files = {name + ".hlsl"};
  std::istringstream lines(text);
  std::uint32_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    for (char& c : line) {
      if (c == ',' || c == ';') c = ' ';
    }
    std::istringstream words(line);
    std::string word;
    if (!(words >> word) || word[0] == '#') continue;
    if (word == "vertex") {
      program.stage = Stage::Vertex;
      continue;
    }
    if (word == "in" || word == "out") {
      std::string semantic, mask;
      words >> semantic >> mask;
      std::uint8_t bits = 0;
      for (char c : mask) bits |= static_cast<std::uint8_t>(1 << component(c));
      if (word == "in")
        program.inputs.push_back({semantic, bits});
      else
        program.outputs.push_back({semantic, bits});
      continue;
    }
    if (word == "uniform") {
      UniformSymbol symbol;
      words >> symbol.name >> symbol.components;
      symbol.reg = program.uniform_count++;
      program.uniforms.push_back(symbol);
      continue;
    }
    if (word == "sampler") {
      SamplerSymbol symbol;
      std::string kind;
      words >> symbol.name >> kind;
      symbol.dimension = kind == "cube" ? SamplerDimension::TexCube
                         : kind == "3d" ? SamplerDimension::Tex3D
                                        : SamplerDimension::Tex2D;
      program.samplers.push_back(symbol);
      continue;
    }
    if (word == "lit") {
      std::array<double, 4> values{};
      for (double& value : values) words >> value;
      program.literals.push_back(values);
      continue;
    }
    Instruction instruction;
    instruction.line = {0, 1, number};
    if (word.ends_with("_sat")) {
      instruction.saturate = true;
      word.resize(word.size() - 4);
    }
    bool found = false;
    for (std::size_t op = 0; op < kOpcodes.size(); ++op) {
      if (kOpcodes[op].mnemonic == word) {
        instruction.op = static_cast<Opcode>(op);
        found = true;
      }
    }
    if (!found) throw std::runtime_error("line " + std::to_string(number) + ": " + word);
    const OpcodeInfo& op = info(instruction.op);
    if (instruction.op == Opcode::Loop) {
      words >> instruction.trip_count;
      program.code.push_back(instruction);
      continue;
    }
    const bool effect = op.pipe == Pipe::Flow || word.starts_with("kill");
    if (!effect) {
      words >> word;
      const Register reg = register_of(word);
      instruction.dst.file = reg.file;
      instruction.dst.index = reg.index;
      instruction.dst.mask = reg.swizzle.empty() ? 0xf : 0;
      for (char c : reg.swizzle) instruction.dst.mask |= static_cast<std::uint8_t>(1 << component(c));
      if (reg.file == RegisterFile::Temp) program.temp_count = std::max(program.temp_count, reg.index + 1);
    }
    for (int s = 0; s < op.sources; ++s) {
      if (!(words >> word)) throw std::runtime_error("line " + std::to_string(number) + ": operand missing");
      instruction.src[static_cast<std::size_t>(s)] = source_of(word);
    }
    if (words >> word) instruction.sampler = static_cast<std::uint8_t>(std::stoi(word.substr(1)));
    program.code.push_back(instruction);
  }
  validate(program);
  return program;
}

}  // namespace aluminate::test
