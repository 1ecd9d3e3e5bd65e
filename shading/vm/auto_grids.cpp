#include "shading/vm/auto_grids.hpp"

#include <algorithm>

#include "shading/vm/range_plan.hpp"

namespace aluminate::vm {
namespace {

// After so many rounds whatever still does not fit goes back to its first grid, which needs no proof; after the last,
// everything does. Shipped shaders need one or two: the bound is for programs made to defeat it.
constexpr int kPatience = 6, kLastRound = 12;

// Settling sums is worth while, not necessary: it may stop anywhere.
constexpr int kSettlingPasses = 16;

bool rounds(Opcode op) {
  switch (op) {
    case Opcode::Add:
    case Opcode::Mul:
    case Opcode::Mad:
    case Opcode::Dp2Add:
    case Opcode::Dp3:
    case Opcode::Dp4:
    case Opcode::Rcp:
    case Opcode::Rsq:
    case Opcode::Sqrt:
    case Opcode::Exp:
    case Opcode::Log:
    case Opcode::DsX:
    case Opcode::DsY: return true;
    default: return false;
  }
}

// Greatest magnitude that each instruction makes, over its components.
std::vector<double> find_reach(const Program& program, const Decoded& decoded) {
  const RangePlan ranges = plan_ranges(decoded, Assume::Nothing, SquaredLength::InRange);
  std::vector<double> reach(program.code.size(), 0);
  for (std::size_t o = 0; o < decoded.operations.size(); ++o) {
    double& known = reach[decoded.operations[o].instruction];
    known = std::max(known, ranges.operations[o].reach);
  }
  return reach;
}

class Refiner {
 public:
  Refiner(const Program& program, GridPlan& plan) : program_(program), plan_(plan), base_(plan.frac_bits) {}

  void raise(const std::vector<double>& reach) {
    for (std::size_t i = 0; i < program_.code.size(); ++i)
      if (may_rise(i) && reach[i] > 0) plan_.frac_bits[i] = finest(i, reach[i]);
    settle_sums();
  }

  void give_up() {
    plan_.frac_bits = base_;
    follow_grids(program_, plan_);
  }

  /// True when a grid was taken back.
  bool take_back(const std::vector<double>& reach, bool patient) {
    bool changed = false;
    for (std::size_t i = 0; i < program_.code.size(); ++i) {
      std::uint8_t& bits = plan_.frac_bits[i];
      if (bits == base_[i] || reach[i] <= plan_.grid(i).greatest) continue;
      bits = patient ? std::min(bits, finest(i, reach[i])) : base_[i];
      changed = true;
    }
    if (changed) settle_sums();
    return changed;
  }

 private:
  bool may_rise(std::size_t i) const { return rounds(program_.code[i].op) && base_[i] == plan_.format.frac_bits; }

  std::uint8_t finest(std::size_t i, double reach) const {
    int bits = number::kUnitFracBits;
    while (bits > base_[i] && reach > plan_.format.grid(bits).greatest) --bits;
    return static_cast<std::uint8_t>(bits);
  }

  // A sum on a coarser grid than its operands needs two more operations, and the operands' last bits are lost in it: they
  // are made on the sum's grid at once. A sum on a finer grid than its operands has no use for it.
  void settle_sums() {
    bool changed = true;
    for (int pass = 0; changed && pass < kSettlingPasses; ++pass) {
      changed = false;
      follow_grids(program_, plan_);
      // Backwards, so that one pass takes a grid from the end of a chain of sums to its beginning.
      std::vector<std::uint8_t> allowed(plan_.webs.count, number::kUnitFracBits);
      for (std::size_t i = program_.code.size(); i-- > 0;) {
        const Instruction& now = program_.code[i];
        if (now.dst.file == RegisterFile::Temp)
          for (std::size_t c = 0; c < 4; ++c)
            if ((now.dst.mask >> c & 1) != 0) changed |= lower(i, allowed[plan_.webs.written[i][c]]);
        if (now.op == Opcode::Add && !now.saturate) changed |= settle_sum(i, allowed);
      }
    }
    follow_grids(program_, plan_);
  }

  bool settle_sum(std::size_t i, std::vector<std::uint8_t>& allowed) {
    const Instruction& sum = program_.code[i];
    int operands = 0;
    for (int c = 0; c < 4; ++c)
      if ((sum.dst.mask >> c & 1) != 0)
        for (std::size_t s = 0; s < 2; ++s) operands = std::max(operands, plan_.source_frac_bits(program_, i, s, c));
    const bool changed = lower(i, operands);
    for (std::size_t c = 0; c < 4; ++c)
      if ((sum.dst.mask >> c & 1) != 0)
        for (std::size_t s = 0; s < 2; ++s)
          if (sum.src[s].file == RegisterFile::Temp) {
            std::uint8_t& bits = allowed[plan_.webs.read[i][s][sum.src[s].swizzle[c]]];
            bits = std::min(bits, plan_.frac_bits[i]);
          }
    return changed;
  }

  bool lower(std::size_t i, int bits) {
    bits = std::max<int>(bits, base_[i]);
    if (!may_rise(i) || plan_.frac_bits[i] <= bits) return false;
    plan_.frac_bits[i] = static_cast<std::uint8_t>(bits);
    return true;
  }

  const Program& program_;
  GridPlan& plan_;
  std::vector<std::uint8_t> base_;
};

}  // namespace

Decoded refine_grids(const Program& program, GridPlan& plan, Decoded decoded,
                     const std::function<Decoded(const GridPlan&)>& decode) {
  Refiner refiner(program, plan);
  refiner.raise(find_reach(program, decoded));
  for (int round = 0;; ++round) {
    decoded = decode(plan);
    if (round == kLastRound || !refiner.take_back(find_reach(program, decoded), round < kPatience)) return decoded;
    if (round + 1 == kLastRound) refiner.give_up();
  }
}

}  // namespace aluminate::vm
