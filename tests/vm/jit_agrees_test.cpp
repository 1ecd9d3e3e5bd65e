// Compiled code against the interpreter: the same bits in outputs, kills and counters, at every width.
#include <gtest/gtest.h>

#include "tests/vm/jit_agreement.hpp"

namespace aluminate::vm::testing {
namespace {

TEST(Jit, RandomProgramsGiveTheInterpretersBitsAndCounts) {
  JitCoverage coverage;
  for (std::uint64_t n = 0; n < 300; ++n) {
    const JitCase c = nth_case(n);
    const Program program = RandomProgram(c.seed, c.control_flow).make();
    const std::string difference = compare_tiers(program, c, coverage);
    ASSERT_TRUE(difference.empty()) << difference << "\ncase " << n << " seed " << c.seed << " " << c.format << " width "
                                    << c.options.width << (c.options.assume == Assume::Typical ? " typical\n" : " general\n")
                                    << listing_of(program);
  }
  // A run in which nothing saturates, nothing is fetched and no check was left out would prove nothing.
  EXPECT_EQ(coverage.compiled, 300);
  EXPECT_EQ(coverage.refused, 0);
  EXPECT_GT(coverage.saturated, 60);
  EXPECT_GT(coverage.killed, 30);
  EXPECT_GT(coverage.fetched, 50);
  EXPECT_GT(coverage.proven, 300);
  EXPECT_GT(coverage.checked, 200);
}

// Lanes leave a loop from inside an If, and what follows writes the same register for those that stay: what the first had
// must be in memory although every later path overwrites it, under a mask.
TEST(Jit, LanesThatLeftALoopKeepTheirValues) {
  Builder b;
  b.op(Opcode::Min, rd(2, "x"), {v(0, "y"), l(b.literal(3))});
  b.loop();
  b.op(Opcode::Add, rd(0, "x"), {v(0, "x"), loop_counter(0)});
  b.op(Opcode::Sge, rd(1, "x"), {loop_counter(0), r(2, "x")});
  b.flow(Opcode::If, {r(1, "x")});
  b.flow(Opcode::Break, {r(1, "x")});
  b.flow(Opcode::EndIf);
  b.op(Opcode::Mov, rd(0, "x"), {v(0, "z")});
  b.flow(Opcode::EndLoop);
  b.op(Opcode::Mov, o(0, "x"), {r(0)});
  JitCoverage coverage;
  for (std::uint64_t seed = 0; seed < 4; ++seed)
    for (std::uint32_t width : {8u, 16u, 32u, 64u}) {
      JitCase c;
      c.seed = seed;
      c.options.width = width;
      EXPECT_EQ(compare_tiers(b.program, c, coverage), "") << "width " << width << " seed " << seed;
    }
}

}  // namespace
}  // namespace aluminate::vm::testing
