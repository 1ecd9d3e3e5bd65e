// Range analysis: what it claims holds for every value the interpreter makes, and what shaders rely on is found.
#include <gtest/gtest.h>

#include "shading/vm/decoded.hpp"
#include "shading/vm/range_plan.hpp"
#include "tests/vm/random_batch.hpp"
#include "tests/vm/random_program.hpp"

namespace aluminate::vm::testing {
namespace {

std::vector<bool> proven(const Program& program, const char* format_name, Assume assume) {
  const Executable executable = prepare(program, format(format_name));
  const RangePlan plan = plan_ranges(executable.decoded(), assume);
  std::vector<bool> result(program.code.size(), true);
  for (std::size_t i = 0; i < plan.operations.size(); ++i) {
    const Operation& op = executable.decoded().operations[i];
    const bool counts = op.post == Post::Range || op.kernel == Kernel::ClampRange;
    if (counts && !plan.operations[i].in_range) result[op.instruction] = false;
  }
  return result;
}

TEST(RangePlan, InstructionsItProvesNeverSaturate) {
  int proofs = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const Numbers numbers = seed % 2 == 0 ? Numbers::Tame : Numbers::Hostile;
    const Assume assume = numbers == Numbers::Tame ? Assume::Typical : Assume::Nothing;
    const char* name = kFormats[seed / 2 % std::size(kFormats)];
    Machine machine(RandomProgram(seed * 8 + 5, seed % 3 == 0).make(), name);
    fill(machine, seed, numbers);
    machine.run();
    const std::vector<bool> claims = proven(machine.program, name, assume);
    for (std::size_t i = 0; i < claims.size(); ++i) {
      if (!claims[i]) continue;
      ++proofs;
      ASSERT_EQ(machine.counters.saturations[i], 0u) << "seed " << seed << " " << name << " instruction " << i;
    }
  }
  EXPECT_GT(proofs, 2000);
}

// dp3, rsq, mul: no interval sees that the result is bounded.
TEST(RangePlan, KnowsThatNormalisingBounds) {
  Builder b;
  b.op(Opcode::Dp3, rd(0, "w"), {v(0), v(0)});
  b.op(Opcode::Rsq, rd(0, "w"), {r(0, "w")});
  b.op(Opcode::Mul, rd(0, "xyz"), {v(0), r(0, "w")});
  b.op(Opcode::Dp3, rd(1, "x"), {r(0), r(0)});
  b.op(Opcode::Mul, o(0, "x"), {r(1, "x"), r(1, "x")});
  EXPECT_EQ(proven(b.program, "fx31", Assume::Typical), std::vector<bool>(5, true));
  // With inputs as large as the format the square overflows, and what follows may too.
  EXPECT_FALSE(proven(b.program, "fx31", Assume::Nothing)[0]);
}

// How shaders write it: v * rsqrt(max(dot(v, v), epsilon)), then a half vector of two of them.
TEST(RangePlan, NormalisingThroughALowerBoundIsProvenToo) {
  Builder b;
  const int epsilon = b.literal(1e-8);
  for (int i = 0; i < 2; ++i) {
    b.op(Opcode::Dp3, rd(i, "w"), {v(i), v(i)});
    b.op(Opcode::Max, rd(i, "w"), {r(i, "w"), l(epsilon, "x")});
    b.op(Opcode::Rsq, rd(i, "w"), {r(i, "w")});
    b.op(Opcode::Mul, rd(i, "xyz"), {v(i), r(i, "w")});
  }
  b.op(Opcode::Add, rd(2, "xyz"), {r(0), r(1)});
  b.op(Opcode::Dp3, rd(2, "w"), {r(2), r(2)});
  b.op(Opcode::Mul, o(0, "x"), {r(2, "w"), r(2, "w")});
  EXPECT_EQ(proven(b.program, "fx31", Assume::Typical), std::vector<bool>(11, true));
}

// saturate() costs nothing where the value is in [0, 1] anyway: Schlick's (1 - x)^5 of a saturated x.
TEST(RangePlan, PowersOfASaturatedValueStayWithinOne) {
  Builder b;
  b.op(Opcode::Mov, rd(0, "x"), {v(0)}).saturate = true;
  b.op(Opcode::Add, rd(1, "x"), {l(b.literal(1), "x"), -r(0)}).saturate = true;
  b.op(Opcode::Mul, rd(2, "x"), {r(1), r(1)}).saturate = true;
  b.op(Opcode::Mul, rd(2, "x"), {r(2), r(1)}).saturate = true;
  b.op(Opcode::Mov, o(0, "x"), {r(2)});
  const Executable executable = prepare(b.program, format("fx31"));
  const RangePlan plan = plan_ranges(executable.decoded(), Assume::Typical);
  int powers = 0;
  for (std::size_t i = 0; i < plan.operations.size(); ++i) {
    if (executable.decoded().operations[i].kernel != Kernel::Mul &&
        executable.decoded().operations[i].kernel != Kernel::Sub)
      continue;
    ++powers;
    EXPECT_TRUE(plan.operations[i].result.within(0, 1)) << i;
    EXPECT_TRUE(plan.operations[i].never_minus_zero) << i;
  }
  EXPECT_EQ(powers, 3);
}

TEST(RangePlan, ALoopMayAddUp) {
  Builder b;
  b.op(Opcode::Mov, rd(0, "x"), {l(b.literal(0))});
  b.loop(1000);
  b.op(Opcode::Add, rd(0, "x"), {r(0, "x"), v(0, "x")});
  b.flow(Opcode::EndLoop);
  b.op(Opcode::Mov, o(0, "x"), {r(0)});
  EXPECT_FALSE(proven(b.program, "fx31", Assume::Typical)[2]);
}

}  // namespace
}  // namespace aluminate::vm::testing
