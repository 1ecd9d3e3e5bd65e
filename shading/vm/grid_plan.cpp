#include "shading/vm/grid_plan.hpp"

#include <algorithm>
#include <cmath>

#include "platform/number/scalar.hpp"
#include "shading/vm/operands.hpp"

namespace aluminate::vm {
namespace {

bool bounded_by_one(const Instruction& i) {
  return i.saturate || i.op == Opcode::Sin || i.op == Opcode::Cos || shape_of(i.op) == Shape::Texture;
}

// Smallest f such that value is a multiple of 2^-f.
std::uint8_t frac_bits_of(double value) {
  std::uint8_t f = 0;
  while (f < number::kUnitFracBits && value != std::floor(value)) {
    value *= 2;
    ++f;
  }
  return f;
}

}  // namespace

int GridPlan::source_frac_bits(const Program& program, std::size_t instruction, std::size_t which, int position) const {
  const Source& source = program.code[instruction].src[which];
  if (format.kind == number::Kind::Reference) return 0;
  const std::size_t component = source.swizzle[static_cast<std::size_t>(position)];
  switch (source.file) {
    case RegisterFile::Temp: return web_frac_bits[webs.read[instruction][which][component]];
    case RegisterFile::Literal: {
      const std::size_t registers = source.relative.base == RelativeBase::None ? 1 : source.relative.limit;
      int finest = 0;
      for (std::size_t r = 0; r < registers; ++r)
        finest = std::max<int>(finest, literal_frac_bits[source.index + r][component]);
      return finest;
    }
    case RegisterFile::LoopCounter: return 0;
    default: return format.frac_bits;
  }
}

double GridPlan::operand_step(const Program& program, std::size_t instruction, int position) const {
  return format.grid(std::max(source_frac_bits(program, instruction, 0, position), format.frac_bits)).step;
}

int GridPlan::result_frac_bits(const Program& program, std::size_t index, int component) const {
  const Instruction& i = program.code[index];
  const auto source = [&](std::size_t s) { return source_frac_bits(program, index, s, component); };
  switch (i.op) {
    case Opcode::Mov:
    case Opcode::Frc: return source(0);
    case Opcode::Min:
    case Opcode::Max: return std::max(source(0), source(1));
    case Opcode::CndGe:
    case Opcode::CndGt:
    case Opcode::CndEq: return std::max(source(1), source(2));
    case Opcode::Flr:
    case Opcode::Trunc:
    case Opcode::Sge:
    case Opcode::Sgt:
    case Opcode::Seq:
    case Opcode::Sne: return 0;
    default: return frac_bits[index];
  }
}

std::vector<std::uint8_t> default_frac_bits(const Program& program, const number::NumberFormat& format) {
  std::vector<std::uint8_t> bits;
  bits.reserve(program.code.size());
  for (const Instruction& i : program.code)
    bits.push_back(static_cast<std::uint8_t>(format.has_unit_grid() && bounded_by_one(i) ? number::kUnitFracBits
                                                                                         : format.frac_bits));
  return bits;
}

GridPlan plan_grids(const Program& program, const number::NumberFormat& format, std::vector<std::uint8_t> frac_bits) {
  GridPlan plan;
  plan.format = format;
  plan.frac_bits = std::move(frac_bits);
  plan.webs = find_value_webs(program);

  for (const auto& literal : program.literals) {
    auto& value = plan.literals.emplace_back();
    auto& bits = plan.literal_frac_bits.emplace_back();
    for (std::size_t c = 0; c < 4; ++c) {
      const bool unit = std::fabs(literal[c]) <= 1.0;
      value[c] = number::sanitise(unit ? format.unit_grid() : format.default_grid(), literal[c]).value;
      bits[c] = format.kind == number::Kind::Reference ? 0 : frac_bits_of(value[c]);
    }
  }
  follow_grids(program, plan);
  return plan;
}

void follow_grids(const Program& program, GridPlan& plan) {
  // Finest grid written to each web: repeated until nothing changes, because Mov and its like pass grids on.
  // Grids only grow finer and are bounded, so this ends.
  plan.web_frac_bits.assign(plan.webs.count, 0);
  for (bool changed = plan.format.kind != number::Kind::Reference; changed;) {
    changed = false;
    for (std::size_t index = 0; index < program.code.size(); ++index) {
      const Instruction& i = program.code[index];
      if (i.dst.mask == 0 || i.dst.file != RegisterFile::Temp) continue;
      for (int c = 0; c < 4; ++c) {
        if ((i.dst.mask >> c & 1) == 0) continue;
        auto& known = plan.web_frac_bits[plan.webs.written[index][static_cast<std::size_t>(c)]];
        const int written = plan.result_frac_bits(program, index, c);
        if (written > known) {
          known = static_cast<std::uint8_t>(written);
          changed = true;
        }
      }
    }
  }
}

}  // namespace aluminate::vm
