// Random programs: every schedule is legal, computes what the program computes, and is not shorter than its
// bound.
#include "shading/cost/legality.hpp"
#include "shading/cost/xenos_program.hpp"
#include "tests/cost/machine.hpp"
#include "tests/cost/program_builder.hpp"
#include "tests/cost/random_program.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace aluminate::test {
namespace {

RandomShape shape_of(std::uint32_t seed) {
  RandomShape shape;
  shape.instructions = 4 + static_cast<int>(seed % 57);
  shape.flow = seed % 3 == 0;
  shape.fetches = seed % 4 != 1;
  shape.relative = seed % 5 == 0;
  return shape;
}

LaneInput lane_input(std::uint32_t seed) {
  LaneInput input;
  const auto value = [&](std::uint32_t i) {
    return static_cast<double>((seed * 7919u + i * 104729u) % 2001u) / 500.0 - 2.0;
  };
  for (std::uint32_t v = 0; v < 4; ++v)
    input.inputs.push_back({value(v * 4), value(v * 4 + 1), value(v * 4 + 2), value(v * 4 + 3)});
  for (std::uint32_t u = 0; u < 8; ++u)
    input.uniforms.push_back({value(50 + u * 4), value(51 + u * 4), value(52 + u * 4), value(53 + u * 4)});
  return input;
}

std::string listing_of(const vm::Program& program) {
  std::string text;
  for (const vm::Instruction& instruction : program.code)
    text += vm::disassemble(program, instruction) + "\n";
  return text;
}

constexpr std::uint32_t kPrograms = 2200;

TEST(XenosSchedule, IsLegalOnRandomPrograms) {
  for (cost::PairingRule pairing : {cost::PairingRule::Strict, cost::PairingRule::Loose}) {
    for (std::uint32_t seed = 0; seed < kPrograms; ++seed) {
      const vm::Program program = random_program(seed, shape_of(seed));
      const cost::ScheduledProgram scheduled = cost::schedule_program(program, pairing);
      const std::vector<std::string> broken = cost::broken_rules(program, scheduled, pairing);
      ASSERT_TRUE(broken.empty()) << "seed " << seed << ": " << broken.front() << "\n" << listing_of(program);
    }
  }
}

TEST(XenosSchedule, ComputesWhatTheProgramComputes) {
  int compared = 0;
  for (std::uint32_t seed = 0; seed < kPrograms; ++seed) {
    const vm::Program program = random_program(seed, shape_of(seed));
    const cost::ScheduledProgram scheduled = cost::schedule_program(program, cost::PairingRule::Strict);
    const LaneInput input = lane_input(seed);
    const LaneResult want = run_program(program, input);
    SCOPED_TRACE(listing_of(program) + std::to_string(seed));
    const LaneResult got = run_schedule(program, scheduled, input);
    EXPECT_EQ(got.kills, want.kills) << "seed " << seed;
    for (std::size_t o = 0; o < want.outputs.size(); ++o) {
      for (std::size_t c = 0; c < 4; ++c) {
        // Only rsq-to-sqrt folding regroups arithmetic; everything else is the same doubles in the same
        // order.
        const double tolerance = 1e-9 * std::max(1.0, std::abs(want.outputs[o][c]));
        ASSERT_NEAR(got.outputs[o][c], want.outputs[o][c], tolerance) << "seed " << seed << " o" << o << "."
                                                                      << "xyzw"[c] << "\n"
                                                                      << listing_of(program);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 10000);
}

TEST(XenosSchedule, NeverBeatsItsBound) {
  double words = 0, bound = 0;
  for (std::uint32_t seed = 0; seed < kPrograms; ++seed) {
    const vm::Program program = random_program(seed, shape_of(seed));
    for (const cost::ScheduledBlock& block :
         cost::schedule_program(program, cost::PairingRule::Strict).scheduled) {
      ASSERT_GE(block.schedule.words, block.schedule.bound_words) << "seed " << seed;
      words += block.schedule.words;
      bound += block.schedule.bound_words;
    }
  }
  RecordProperty("gap_percent", std::to_string(100 * (words / bound - 1)));
  std::cout << "gap over the bound: " << 100 * (words / bound - 1) << " %\n";
}

TEST(XenosSchedule, IsDeterministic) {
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    const vm::Program program = random_program(seed, shape_of(seed));
    const cost::ScheduledProgram a = cost::schedule_program(program, cost::PairingRule::Strict),
                                 b = cost::schedule_program(program, cost::PairingRule::Strict);
    ASSERT_EQ(a.registers.gprs, b.registers.gprs);
    for (std::size_t i = 0; i < a.scheduled.size(); ++i) {
      ASSERT_EQ(a.scheduled[i].schedule.issues.size(), b.scheduled[i].schedule.issues.size());
      for (std::size_t k = 0; k < a.scheduled[i].schedule.issues.size(); ++k) {
        EXPECT_EQ(a.scheduled[i].schedule.issues[k].vector, b.scheduled[i].schedule.issues[k].vector);
        EXPECT_EQ(a.scheduled[i].schedule.issues[k].scalar, b.scheduled[i].schedule.issues[k].scalar);
      }
    }
  }
}

// The checker itself must see what it claims to see.
TEST(XenosLegality, SeesEachKindOfDamage) {
  const vm::Program program = program_from_text(R"(
in TEXCOORD0 xyzw
out COLOR0 xyzw
uniform a 4
sampler s 2d
tex r0, v0.xy, s0
mad r1, r0, c0, v0
rcp r2.x, r0.w
mul r2.xyz, r1, r2.x
mul r3.x, v0.z, r0.y
mul o0, r2.xyzx, r3.x
)");
  const cost::ScheduledProgram good = cost::schedule_program(program, cost::PairingRule::Strict);
  ASSERT_TRUE(cost::broken_rules(program, good, cost::PairingRule::Strict).empty());
  const auto damaged = [&](auto&& change) {
    cost::ScheduledProgram bad = good;
    change(bad.scheduled[0]);
    return !cost::broken_rules(program, bad, cost::PairingRule::Strict).empty();
  };
  EXPECT_TRUE(damaged([](cost::ScheduledBlock& block) {
    std::swap(block.schedule.issues.front(), block.schedule.issues.back());
  }));
  EXPECT_TRUE(damaged([](cost::ScheduledBlock& block) { block.schedule.issues.pop_back(); }));
  EXPECT_TRUE(damaged(
      [](cost::ScheduledBlock& block) { block.schedule.issues.push_back(block.schedule.issues.back()); }));
  EXPECT_TRUE(damaged([](cost::ScheduledBlock& block) { block.schedule.clauses = 1; }));
  EXPECT_TRUE(damaged([](cost::ScheduledBlock& block) {
    for (cost::Issue& issue : block.schedule.issues) std::swap(issue.vector, issue.scalar);
  }));
  EXPECT_TRUE(damaged([](cost::ScheduledBlock& block) {
    for (cost::Location& location : block.results) location.gpr = location.gpr >= 0 ? 0 : -1;
  }));
}

}  // namespace
}  // namespace aluminate::test
