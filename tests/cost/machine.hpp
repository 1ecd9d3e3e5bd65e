// Two ways to run one lane in doubles: the program as written, and its scheduled words on physical registers.
// They must agree, or lowering, scheduling or register assignment changed the meaning.
#pragma once

#include "shading/cost/xenos_program.hpp"
#include "shading/vm/program.hpp"

#include <array>
#include <optional>
#include <vector>

namespace aluminate::test {

using Vec4 = std::array<double, 4>;

struct LaneInput {
  std::vector<Vec4> inputs, uniforms;
};

struct LaneResult {
  std::vector<Vec4> outputs;  // unwritten components stay at kUnwritten
  int kills = 0;
};
inline constexpr double kUnwritten = -12345.0;

LaneResult run_program(const vm::Program& program, const LaneInput& input);
LaneResult run_schedule(const vm::Program& program, const cost::ScheduledProgram& scheduled,
                        const LaneInput& input);

}  // namespace aluminate::test
