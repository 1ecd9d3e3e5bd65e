// `auto`: grids that range analysis made finer, never coarser, and that hold what they must.
#include <gtest/gtest.h>

#include "shading/vm/decoded.hpp"
#include "tests/vm/random_batch.hpp"
#include "tests/vm/random_program.hpp"

namespace aluminate::vm::testing {
namespace {

std::vector<std::uint8_t> grids(const Program& program, const char* name) {
  return prepare(program, format(name)).decoded().frac_bits;
}

TEST(AutoGrids, NeverCoarserThanFx31AndNeverTheFirstToSaturate) {
  int raised = 0;
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    Machine machine(RandomProgram(seed * 8 + 6, seed % 3 == 0).make(), "auto");
    const std::vector<std::uint8_t> base = grids(machine.program, "fx31"), fine = machine.executable.decoded().frac_bits;
    fill(machine, seed, seed % 2 == 0 ? Numbers::Tame : Numbers::Hostile);
    machine.run();
    std::uint64_t first = 0, later = 0;
    for (std::size_t i = 0; i < base.size(); ++i) {
      ASSERT_GE(fine[i], base[i]) << "seed " << seed << " instruction " << i;
      raised += fine[i] > base[i] ? 1 : 0;
      (fine[i] > base[i] ? later : first) += machine.counters.saturations[i];
    }
    if (first == 0) {
      ASSERT_EQ(later, 0u) << "seed " << seed;
    }
  }
  EXPECT_GT(raised, 100);
}

// |v / |v|| <= 1.75 as the machine computes it: 50 bits. Three products of two such numbers reach 9.2: 47 bits.
TEST(AutoGrids, DirectionsAndTheirCosinesAreFine) {
  Builder b;
  for (int vector = 0; vector < 2; ++vector) {
    b.op(Opcode::Dp3, rd(vector, "w"), {v(vector), v(vector)});
    b.op(Opcode::Rsq, rd(vector, "w"), {r(vector, "w")});
    b.op(Opcode::Mul, rd(vector, "xyz"), {v(vector), r(vector, "w")});
  }
  b.op(Opcode::Dp3, rd(2, "x"), {r(0), r(1)});
  b.op(Opcode::Mad, rd(2, "y"), {r(2, "x"), r(2, "x"), l(b.literal(1), "x")});
  b.op(Opcode::Rcp, o(0, "x"), {r(2, "y")});
  const std::vector<std::uint8_t> f = grids(b.program, "auto");
  EXPECT_EQ(f[0], 31);  // squares of what the format holds
  EXPECT_EQ(f[1], 35);  // 1 / sqrt(2^-31) < 2^16
  EXPECT_EQ(f[2], 50);
  EXPECT_EQ(f[6], 47);
  EXPECT_EQ(f[7], 44);
  EXPECT_EQ(f[8], 50);  // 1 + x^2 >= 1
}

// A sum on a coarser grid than its operands would cost two more operations: the operands take the sum's grid.
TEST(AutoGrids, SumsStayPlain) {
  Builder b;
  for (int i = 0; i < 2; ++i) {
    b.op(Opcode::Dp3, rd(i, "w"), {v(i), v(i)});
    b.op(Opcode::Rsq, rd(i, "w"), {r(i, "w")});
    b.op(Opcode::Mul, rd(i, "xyz"), {v(i), r(i, "w")});
  }
  b.op(Opcode::Add, o(0, "xyz"), {r(0), r(1)});
  const Executable automatic = prepare(b.program, format("auto")), fixed = prepare(b.program, format("fx31"));
  EXPECT_EQ(automatic.decoded().frac_bits[6], 49);  // 3.5 < 4
  EXPECT_EQ(automatic.decoded().frac_bits[5], 49);
  EXPECT_EQ(automatic.operation_count(), fixed.operation_count());
  for (const Operation& op : automatic.decoded().operations) {
    EXPECT_NE(op.kernel, Kernel::AddRound);
    EXPECT_NE(op.kernel, Kernel::AddRoundSum);
  }
}

// A register that holds a saturated number and later a distance: the distance is not taken for as fine as the first.
TEST(AutoGrids, ARegisterUsedTwiceHoldsTwoValues) {
  Builder b;
  b.op(Opcode::Mov, rd(0, "x"), {v(0, "x")});
  b.op(Opcode::Mul, rd(0, "x"), {r(0), v(0, "x")}).saturate = true;
  b.op(Opcode::Mov, o(0, "x"), {r(0)});
  b.op(Opcode::Mul, rd(0, "x"), {v(0, "x"), v(0, "y")});
  b.op(Opcode::Add, o(0, "y"), {r(0), v(0, "x")});
  for (const char* name : {"fx31", "auto"}) {
    const Executable executable = prepare(b.program, format(name));
    for (const Operation& op : executable.decoded().operations) EXPECT_NE(op.kernel, Kernel::AddRound) << name;
  }
}

// Both branches of an If reach the read after it, and a loop carries its last write to its first read.
TEST(AutoGrids, JoinedValuesLieOnTheFinestGrid) {
  Builder b;
  b.op(Opcode::Mul, rd(0, "x"), {v(0, "x"), v(0, "x")});
  b.flow(Opcode::If, {v(0, "y")});
  b.op(Opcode::Mul, rd(0, "x"), {v(0, "x"), v(0, "x")}).saturate = true;
  b.flow(Opcode::EndIf);
  b.op(Opcode::Add, rd(1, "x"), {r(0, "x"), v(0, "x")});
  b.loop(3);
  b.op(Opcode::Add, rd(1, "y"), {r(2, "x"), v(0, "x")});
  b.op(Opcode::Mul, rd(2, "x"), {v(0, "x"), v(0, "x")}).saturate = true;
  b.flow(Opcode::EndLoop);
  b.op(Opcode::Mov, o(0, "xy"), {r(1)});
  int rounded = 0;
  const Executable executable = prepare(b.program, format("fx31"));
  for (const Operation& op : executable.decoded().operations) rounded += op.kernel == Kernel::AddRound ? 1 : 0;
  EXPECT_EQ(rounded, 2);
}

}  // namespace
}  // namespace aluminate::vm::testing
