#include "tests/cost/random_program.hpp"

namespace aluminate::test {
namespace {

using namespace vm;

/// xorshift: the same sequence with every standard library.
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : state_(seed * 2654435761u + 1u) {}
  int below(int limit) {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 17;
    state_ ^= state_ << 5;
    return static_cast<int>(state_ % static_cast<std::uint32_t>(limit));
  }
  bool chance(int percent) { return below(100) < percent; }

 private:
  std::uint32_t state_;
};

class Generator {
 public:
  Generator(std::uint32_t seed, const RandomShape& shape) : dice_(seed), shape_(shape) {}

  Program run() {
    program_.name = "random";
    program_.files = {"random.hlsl"};
    const int inputs = 1 + dice_.below(4);
    for (int i = 0; i < inputs; ++i) program_.inputs.push_back({"TEXCOORD" + std::to_string(i), 0xf});
    program_.uniform_count = 8;
    program_.uniforms.push_back({"u", 0, 8, 4});
    for (int i = 0; i < 3; ++i) program_.literals.push_back({0.5 * i, 2.0, -1.0 + i, 0.25});
    program_.literals.push_back({0.0, 1.0, 2.0, 3.0});
    program_.samplers = {{"flat", SamplerDimension::Tex2D, false},
                         {"cube", SamplerDimension::TexCube, false},
                         {"volume", SamplerDimension::Tex3D, false}};
    const int outputs = 1 + dice_.below(3) / 2;
    for (int i = 0; i < outputs; ++i) program_.outputs.push_back({"COLOR" + std::to_string(i), 0xf});
    program_.temp_count = kTemps;
    for (std::uint16_t t = 0; t < kTemps; ++t) {  // nothing reads an undefined register
      Instruction mov = instruction(Opcode::Mov);
      mov.dst = {RegisterFile::Temp, t, 0xf};
      mov.src[0] = dice_.chance(50) ? input_source() : constant_source();
      mov.src[0].relative = {};
      program_.code.push_back(mov);
    }
    body(shape_.instructions, 0);
    for (std::uint16_t o = 0; o < program_.outputs.size(); ++o) {
      for (int c = 0; c < 4; ++c) {
        if (c > 0 && dice_.chance(60)) continue;
        Instruction last = instruction(dice_.chance(50) ? Opcode::Mov : Opcode::Mul);
        last.dst = {RegisterFile::Output, o, static_cast<std::uint8_t>(0xf & (0xf << c))};
        for (Source& source : last.src) source = any_source();
        program_.code.push_back(last);
      }
    }
    validate(program_);
    return program_;
  }

 private:
  static constexpr int kTemps = 6;

  Instruction instruction(Opcode op) {
    Instruction made;
    made.op = op;
    made.line = {0, 1, static_cast<std::uint32_t>(program_.code.size() + 1)};
    return made;
  }

  void swizzle(Source& source) {
    for (std::uint8_t& c : source.swizzle) c = static_cast<std::uint8_t>(dice_.below(4));
    if (dice_.chance(50)) source.swizzle = {0, 1, 2, 3};
    source.negate = dice_.chance(25);
    source.absolute = dice_.chance(15);
  }
  Source input_source() {
    Source source;
    source.file = RegisterFile::Input;
    source.index = static_cast<std::uint16_t>(dice_.below(static_cast<int>(program_.inputs.size())));
    swizzle(source);
    return source;
  }
  Source constant_source() {
    Source source;
    const bool uniform = dice_.chance(50);
    source.file = uniform ? RegisterFile::Uniform : RegisterFile::Literal;
    source.index =
        static_cast<std::uint16_t>(dice_.below(uniform ? 4 : static_cast<int>(program_.literals.size())));
    swizzle(source);
    if (uniform && shape_.relative && dice_.chance(30)) {
      source.index = 0;
      source.relative.limit = 4;
      if (loops_ > 0 && dice_.chance(50)) {
        source.relative.base = RelativeBase::LoopCounter;
        source.relative.index = 0;
      } else {
        source.relative.base = RelativeBase::Temp;
        source.relative.index = static_cast<std::uint16_t>(dice_.below(kTemps));
        source.relative.component = static_cast<std::uint8_t>(dice_.below(4));
      }
    }
    return source;
  }
  Source any_source() {
    if (dice_.chance(20)) return input_source();
    if (dice_.chance(20)) return constant_source();
    Source source;
    source.index = static_cast<std::uint16_t>(dice_.below(kTemps));
    swizzle(source);
    return source;
  }

  void body(int count, int depth) {
    for (int i = 0; i < count; ++i) {
      if (shape_.flow && depth < 2 && dice_.chance(6)) {
        i += structure(count - i, depth);
      } else {
        operation();
      }
    }
  }

  int structure(int room, int depth) {
    const int inside = 1 + dice_.below(std::min(room, 8));
    if (dice_.chance(60)) {
      Instruction test = instruction(Opcode::If);
      test.src[0] = any_source();
      if (dice_.chance(50)) {  // a comparison in front, sometimes used twice
        Instruction compare = instruction(dice_.chance(50) ? Opcode::Sge : Opcode::Sgt);
        compare.dst = {RegisterFile::Temp, static_cast<std::uint16_t>(dice_.below(kTemps)), 1};
        compare.src[0] = any_source();
        compare.src[1] = any_source();
        program_.code.push_back(compare);
        test.src[0] = Source{};
        test.src[0].index = compare.dst.index;
        test.src[0].swizzle = {0, 0, 0, 0};
      }
      program_.code.push_back(test);
      body(inside, depth + 1);
      if (dice_.chance(50)) {
        program_.code.push_back(instruction(Opcode::Else));
        body(inside, depth + 1);
      }
      program_.code.push_back(instruction(Opcode::EndIf));
    } else {
      Instruction loop = instruction(Opcode::Loop);
      loop.trip_count = dice_.below(4);
      program_.code.push_back(loop);
      ++loops_;
      body(inside, depth + 1);
      if (dice_.chance(40)) {
        Instruction leave = instruction(Opcode::Break);
        leave.src[0] = any_source();
        program_.code.push_back(leave);
        body(1, depth + 1);
      }
      --loops_;
      program_.code.push_back(instruction(Opcode::EndLoop));
    }
    return inside;
  }

  void operation() {
    for (;;) {
      const Opcode op = static_cast<Opcode>(dice_.below(static_cast<int>(kOpcodes.size())));
      const OpcodeInfo& known = info(op);
      if (known.pipe == Pipe::Flow) continue;
      if (known.pipe == Pipe::Fetch && (!shape_.fetches || dice_.chance(60))) continue;
      Instruction made = instruction(op);
      for (int s = 0; s < known.sources; ++s) made.src[static_cast<std::size_t>(s)] = any_source();
      if (known.pipe == Pipe::Fetch) made.sampler = static_cast<std::uint8_t>(dice_.below(3));
      const bool kill = known.mnemonic.starts_with("kill");
      if (!kill)
        made.dst = {RegisterFile::Temp, static_cast<std::uint16_t>(dice_.below(kTemps)),
                    static_cast<std::uint8_t>(1 + dice_.below(15))};
      made.saturate = !kill && known.pipe != Pipe::Fetch && dice_.chance(25);
      program_.code.push_back(made);
      return;
    }
  }

  Dice dice_;
  RandomShape shape_;
  Program program_;
  int loops_ = 0;
};

}  // namespace

Program random_program(std::uint32_t seed, const RandomShape& shape) { return Generator(seed, shape).run(); }

}  // namespace aluminate::test
