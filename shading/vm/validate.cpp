// Everything decoding and execution take for granted, checked once per program.
#include <cmath>

#include "platform/host/error.hpp"
#include "shading/vm/counters.hpp"
#include "shading/vm/program.hpp"

namespace aluminate::vm {
namespace {

bool is_kill(Opcode op) {
  return op == Opcode::KillGt || op == Opcode::KillGe || op == Opcode::KillNe || op == Opcode::KillEq;
}

bool is_texture(Opcode op) {
  return op == Opcode::Tex || op == Opcode::TexBias || op == Opcode::TexLod || op == Opcode::TexGrad;
}

class Validator {
 public:
  explicit Validator(const Program& program) : program_(program) {}

  void check_all() {
    for (const auto& literal : program_.literals)
      for (double value : literal) require(std::isfinite(value), "literal is not finite");
    for (at_ = 0; at_ < program_.code.size(); ++at_) check(program_.code[at_]);
    at_ = program_.code.size();
    require(nesting_.empty(), "If or Loop without its end");
  }

 private:
  void require(bool condition, const char* what) const {
    if (condition) return;
    const bool inside = at_ < program_.code.size();
    throw InternalError(fmt::format("program '{}': instruction {}{}{}: {}", program_.name, at_, inside ? " " : "",
                                    inside ? info(program_.code[at_].op).mnemonic : "(end)", what));
  }

  void check_source(const Source& s) const {
    for (auto component : s.swizzle) require(component < 4, "swizzle component beyond w");
    const std::size_t index = s.index;
    std::size_t size = 0;
    switch (s.file) {
      case RegisterFile::Temp: size = static_cast<std::size_t>(program_.temp_count); break;
      case RegisterFile::Input: size = program_.inputs.size(); break;
      case RegisterFile::Output: require(false, "output registers cannot be read"); break;
      case RegisterFile::Uniform: size = static_cast<std::size_t>(program_.uniform_count); break;
      case RegisterFile::Literal: size = program_.literals.size(); break;
      case RegisterFile::LoopCounter: size = loop_depth(); break;
    }
    require(index < size, "source register out of range");
    if (s.relative.base == RelativeBase::None) return;
    require(s.file == RegisterFile::Uniform || s.file == RegisterFile::Literal,
            "only uniforms and literals have relative addressing");
    require(s.relative.limit > 0 && index + s.relative.limit <= size, "relative addressing reaches beyond the register file");
    require(s.relative.scale > 0, "relative addressing with scale 0");
    if (s.relative.base == RelativeBase::LoopCounter) {
      require(s.relative.index < loop_depth(), "relative addressing by a loop that is not open");
    } else {
      require(s.relative.index < program_.temp_count, "relative addressing by a temp out of range");
      require(s.relative.component < 4, "relative addressing component beyond w");
    }
  }

  void check(const Instruction& instruction) {
    const OpcodeInfo& op = info(instruction.op);
    const bool writes = op.pipe != Pipe::Flow && !is_kill(instruction.op);
    require(instruction.dst.mask <= 0xf, "write mask beyond w");
    require(writes == (instruction.dst.mask != 0), writes ? "empty write mask" : "write mask on an instruction without result");
    require(writes || !instruction.saturate, "saturate on an instruction without result");
    if (writes) {
      require(instruction.dst.file == RegisterFile::Temp || instruction.dst.file == RegisterFile::Output,
              "destination is neither temp nor output");
      const std::size_t size = instruction.dst.file == RegisterFile::Temp ? static_cast<std::size_t>(program_.temp_count)
                                                                          : program_.outputs.size();
      require(instruction.dst.index < size, "destination register out of range");
    }
    for (int i = 0; i < op.sources; ++i) check_source(instruction.src[static_cast<std::size_t>(i)]);
    if (is_texture(instruction.op)) require(instruction.sampler < program_.samplers.size(), "sampler out of range");
    check_nesting(instruction);
  }

  void check_nesting(const Instruction& instruction) {
    switch (instruction.op) {
      case Opcode::If: nesting_.push_back(Opcode::If); break;
      case Opcode::Else:
        require(!nesting_.empty() && nesting_.back() == Opcode::If, "Else without If");
        nesting_.back() = Opcode::Else;
        break;
      case Opcode::EndIf:
        require(!nesting_.empty() && nesting_.back() != Opcode::Loop, "EndIf without If");
        nesting_.pop_back();
        break;
      case Opcode::Loop:
        require(instruction.trip_count <= kLoopLimit, "more iterations than the loop limit");
        nesting_.push_back(Opcode::Loop);
        break;
      case Opcode::EndLoop:
        require(!nesting_.empty() && nesting_.back() == Opcode::Loop, "EndLoop without Loop");
        nesting_.pop_back();
        break;
      case Opcode::Break:
      case Opcode::Continue: require(loop_depth() > 0, "Break or Continue outside a loop"); break;
      default: break;
    }
    require(nesting_.size() < 64, "nested too deeply");
  }

  std::size_t loop_depth() const {
    std::size_t depth = 0;
    for (Opcode op : nesting_) depth += op == Opcode::Loop ? 1 : 0;
    return depth;
  }

  const Program& program_;
  std::size_t at_ = 0;
  std::vector<Opcode> nesting_;
};

}  // namespace

void validate(const Program& program) { Validator(program).check_all(); }

}  // namespace aluminate::vm
