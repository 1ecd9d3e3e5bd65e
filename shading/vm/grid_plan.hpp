// Chooses, once per program and number format, the grid every instruction rounds to and the grid every register
// component is known to lie on. Static: no value is looked at except literals.
//   rule 1  an instruction rounds to the format's default grid, or to the unit grid when its definition bounds the
//           result by 1: the saturate modifier, sin, cos, texture instructions
//   rule 2  exact instructions never round; their result lies on the finest grid of what they choose from
//   rule 3  a value read from a register lies on the finest grid of the writes that can reach the read (value_webs.hpp)
//   rule 4  in `auto`, what range analysis proves small rounds to a finer grid than rule 1 says (auto_grids.hpp)
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "platform/number/format.hpp"
#include "shading/vm/program.hpp"
#include "shading/vm/value_webs.hpp"

namespace aluminate::vm {

struct GridPlan {
  number::NumberFormat format;
  std::vector<std::uint8_t> frac_bits;                // per instruction: f it rounds to
  ValueWebs webs;
  std::vector<std::uint8_t> web_frac_bits;            // per web: f of the grid its values lie on
  std::vector<std::array<double, 4>> literals;        // quantised: |x| <= 1 to the unit grid, others to the default grid
  std::vector<std::array<std::uint8_t, 4>> literal_frac_bits;  // smallest f that holds the quantised literal

  number::Grid grid(std::size_t instruction) const { return format.grid(frac_bits[instruction]); }
  /// f of the grid that position p of a source of an instruction lies on.
  int source_frac_bits(const Program& program, std::size_t instruction, std::size_t source, int position) const;
  /// The step rsq and log take as the smallest positive operand: of the operand's grid, never coarser than the default.
  double operand_step(const Program& program, std::size_t instruction, int position) const;
  /// f of the grid the result of an instruction lies on, given the grids of its sources.
  int result_frac_bits(const Program& program, std::size_t instruction, int component) const;
};

/// Rules 1 and 2: what every instruction rounds to in a format that looks at nothing but the instruction.
std::vector<std::uint8_t> default_frac_bits(const Program& program, const number::NumberFormat& format);

/// The plan in which instruction i rounds to frac_bits[i].
GridPlan plan_grids(const Program& program, const number::NumberFormat& format, std::vector<std::uint8_t> frac_bits);

/// Sets web_frac_bits again, after frac_bits changed.
void follow_grids(const Program& program, GridPlan& plan);

}  // namespace aluminate::vm
