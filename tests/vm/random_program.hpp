// Seeded random programs that are valid and that stress what could differ between two interpreters: every opcode,
// modifiers, swizzles that overlap the destination, nested control flow, kills, derivatives, relative addressing.
#pragma once

#include <random>

#include "tests/vm/program_builder.hpp"

namespace aluminate::vm::testing {

class RandomProgram {
 public:
  explicit RandomProgram(std::uint64_t seed, bool control_flow) : random_(seed), control_flow_(control_flow) {}

  Program make() {
    // Random numbers are drawn in separate statements throughout: argument order is the compiler's choice.
    for (int i = 0; i < 6; ++i) {
      const std::array<double, 4> value = {number(), number(), number(), number()};
      b_.literal(value[0], value[1], value[2], value[3]);
    }
    b_.literal(0, 1, 0.5, -1);
    b_.program.temp_count = 6;
    b_.program.uniform_count = 8;
    b_.program.inputs.resize(3);
    b_.program.outputs.resize(2);
    b_.program.samplers.resize(4);  // two flat ones, a cube, a volume
    b_.program.samplers[2].dimension = SamplerDimension::TexCube;
    b_.program.samplers[3].dimension = SamplerDimension::Tex3D;
    const int length = pick(4, 28);
    for (int i = 0; i < length; ++i) statement();
    while (!open_.empty()) close();
    for (int i = 0; i < 2; ++i) b_.op(Opcode::Mov, o(i), {r(pick(0, 5))});
    return b_.program;
  }

 private:
  int pick(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  bool chance(int percent) { return pick(1, 100) <= percent; }
  double number() {
    const double unit = std::uniform_real_distribution<double>(-2, 2)(random_);
    switch (pick(0, 5)) {
      case 0: return pick(-4, 4);
      case 1: return unit * 1000;
      case 2: return unit * 1e-6;
      case 3: return unit * 3e6;
      default: return unit;
    }
  }

  Source any_source() {
    Source s;
    switch (pick(0, 9)) {
      case 0:
      case 1: s = v(pick(0, 2)); break;
      case 2: s = c(pick(0, 7)); break;
      case 3: s = l(pick(0, 6)); break;
      case 4: s = loops_ > 0 ? loop_counter(pick(0, loops_ - 1)) : r(pick(0, 5)); break;
      case 5:
        s = chance(50) ? c(pick(0, 3)) : l(pick(0, 3));
        s.relative.limit = static_cast<std::uint16_t>(pick(1, 3));
        s.relative.scale = static_cast<std::uint16_t>(pick(1, 2));
        if (loops_ > 0 && chance(60)) {
          s.relative.base = RelativeBase::LoopCounter;
          s.relative.index = static_cast<std::uint16_t>(pick(0, loops_ - 1));
        } else {
          s.relative.base = RelativeBase::Temp;
          s.relative.index = static_cast<std::uint16_t>(pick(0, 5));
          s.relative.component = static_cast<std::uint8_t>(pick(0, 3));
        }
        break;
      default: s = r(pick(0, 5)); break;
    }
    for (auto& component : s.swizzle) component = static_cast<std::uint8_t>(pick(0, 3));
    s.negate = chance(25);
    s.absolute = chance(15);
    return s;
  }

  void arithmetic() {
    static constexpr Opcode kOps[] = {
        Opcode::Mov,    Opcode::Add, Opcode::Add,  Opcode::Mul, Opcode::Mul,   Opcode::Mad,   Opcode::Mad,
        Opcode::Min,    Opcode::Max, Opcode::Frc,  Opcode::Flr, Opcode::Trunc, Opcode::Sge,   Opcode::Sgt,
        Opcode::Seq,    Opcode::Sne, Opcode::CndGe,Opcode::CndGt,Opcode::CndEq,Opcode::Dp2Add,Opcode::Dp3,
        Opcode::Dp4,    Opcode::Rcp, Opcode::Rsq,  Opcode::Sqrt,Opcode::Exp,   Opcode::Log,   Opcode::Sin,
        Opcode::Cos,    Opcode::DsX, Opcode::DsY,  Opcode::Tex, Opcode::TexBias,Opcode::TexLod,Opcode::TexGrad};
    const Opcode op = kOps[pick(0, static_cast<int>(std::size(kOps)) - 1)];
    Destination d = chance(85) ? rd(pick(0, 5)) : o(pick(0, 1));
    d.mask = static_cast<std::uint8_t>(pick(1, 15));
    Instruction& i = b_.op(op, d, {any_source(), any_source(), any_source()});
    i.saturate = chance(20);
    i.sampler = static_cast<std::uint8_t>(pick(0, 3));
  }

  void statement() {
    if (control_flow_) {
      switch (pick(0, 19)) {
        case 0:
        case 1:
          if (open_.size() < 5) {
            const Source condition = test();
            b_.flow(Opcode::If, {condition});
            open_.push_back(Opcode::If);
            return;
          }
          break;
        case 2:
          if (open_.size() < 4 && loops_ < 2) {
            b_.loop(chance(70) ? pick(0, 5) : -1);
            open_.push_back(Opcode::Loop);
            ++loops_;
            // An open loop must end: lanes leave once its counter reaches a small number.
            if (b_.program.code.back().trip_count < 0) {
              b_.op(Opcode::Sge, rd(5, "w"), {loop_counter(loops_ - 1), l(6, "y")});
              b_.flow(Opcode::Break, {r(5, "w")});
            }
            return;
          }
          break;
        case 3:
          if (!open_.empty() && open_.back() == Opcode::If) {
            b_.flow(Opcode::Else);
            open_.back() = Opcode::Else;
            return;
          }
          break;
        case 4:
        case 5:
          if (!open_.empty()) {
            close();
            return;
          }
          break;
        case 6:
          if (loops_ > 0) {
            const Source condition = test();
            b_.flow(chance(50) ? Opcode::Break : Opcode::Continue, {condition});
            return;
          }
          break;
        default: break;
      }
    }
    if (chance(4)) {
      static constexpr Opcode kKills[] = {Opcode::KillGt, Opcode::KillGe, Opcode::KillNe, Opcode::KillEq};
      const Opcode op = kKills[pick(0, 3)];
      b_.op(op, {}, {any_source(), any_source()});
      return;
    }
    arithmetic();
  }

  // A condition that is true in some lanes and false in others more often than not.
  Source test() {
    if (chance(20)) return any_source();
    b_.op(Opcode::Sgt, rd(4, "w"), {v(pick(0, 2), "x"), r(pick(0, 5), "y")});
    return r(4, "w");
  }

  void close() {
    const bool loop = open_.back() == Opcode::Loop;
    b_.flow(loop ? Opcode::EndLoop : Opcode::EndIf);
    open_.pop_back();
    loops_ -= loop ? 1 : 0;
  }

  std::mt19937_64 random_;
  bool control_flow_;
  Builder b_;
  std::vector<Opcode> open_;
  int loops_ = 0;
};

}  // namespace aluminate::vm::testing
