// Masks, loops, and what is counted, against counts made by hand.
#include <gtest/gtest.h>

#include "platform/host/error.hpp"
#include "tests/vm/machine.hpp"
#include "tests/vm/program_builder.hpp"

namespace aluminate::vm::testing {
namespace {

using Counts = std::vector<BlockCount>;

// Lanes 0..15 have v0.x = 1, the others 0.
void set_first_quarter(Machine& m) {
  for (int lane = 0; lane < kLanes; ++lane) m.set_input(0, 0, lane, lane < 16 ? 1 : 0);
}

TEST(ControlFlow, IfElseRunsEachLaneOnOneSideAndCountsBoth) {
  Builder b;
  const int k = b.literal(10, 20);
  b.flow(Opcode::If, {v(0, "x")});
  b.op(Opcode::Mov, rd(0, "x"), {l(k, "x")});
  b.flow(Opcode::Else);
  b.op(Opcode::Mov, rd(0, "x"), {l(k, "y")});
  b.flow(Opcode::EndIf);
  b.op(Opcode::Mov, o(0, "x"), {r(0, "x")});
  for (bool oracle : {false, true}) {
    Machine m(b.program, "fx31");
    set_first_quarter(m);
    oracle ? m.run_oracle(kAllLanes, 0x3fffffff) : m.run(kAllLanes, 0x3fffffff);  // lanes 0..29 are covered
    for (int lane = 0; lane < kLanes; ++lane) EXPECT_EQ(m.output(0, 0, lane), lane < 16 ? 10 : 20) << lane;
    EXPECT_EQ(m.counters.blocks, (Counts{{1, 30, 34}, {1, 16, 0}, {1, 14, 34}, {1, 30, 34}}));
  }
}

TEST(ControlFlow, ASideWithoutLanesIsSkippedAndCostsNothing) {
  Builder b;
  b.flow(Opcode::If, {v(0, "x")});
  b.op(Opcode::Mov, rd(0, "x"), {v(0, "x")});
  b.flow(Opcode::Else);
  b.op(Opcode::Mov, rd(0, "x"), {v(0, "y")});
  b.flow(Opcode::EndIf);
  b.op(Opcode::Mov, o(0, "x"), {r(0, "x")});
  Machine m(b.program, "fx31");
  m.set_input(0, 0, 0);
  m.set_input(0, 1, 5);
  m.run();
  EXPECT_EQ(m.output(0, 0, 3), 5);
  EXPECT_EQ(m.counters.blocks, (Counts{{1, 64, 0}, {}, {1, 64, 0}, {1, 64, 0}}));
}

TEST(ControlFlow, NestedIfsMaskTheirWrites) {
  Builder b;
  const int k = b.literal(1, 2, 4, 0);
  b.op(Opcode::Mov, rd(0, "x"), {l(k, "w")});
  b.flow(Opcode::If, {v(0, "x")});
  b.op(Opcode::Add, rd(0, "x"), {r(0, "x"), l(k, "x")});
  b.flow(Opcode::If, {v(0, "y")});
  b.op(Opcode::Add, rd(0, "x"), {r(0, "x"), l(k, "y")});
  b.flow(Opcode::EndIf);
  b.flow(Opcode::Else);
  b.op(Opcode::Add, rd(0, "x"), {r(0, "x"), l(k, "z")});
  b.flow(Opcode::EndIf);
  b.op(Opcode::Mov, o(0, "x"), {r(0, "x")});
  Machine m(b.program, "fx31");
  for (int lane = 0; lane < kLanes; ++lane) {
    m.set_input(0, 0, lane, lane & 1);
    m.set_input(0, 1, lane, lane & 2);
  }
  m.run();
  for (int lane = 0; lane < kLanes; ++lane)
    EXPECT_EQ(m.output(0, 0, lane), (lane & 1) == 0 ? 4 : (lane & 2) == 0 ? 1 : 3) << lane;
}

TEST(ControlFlow, BreakLeavesAndContinueSkipsLaneByLane) {
  // Adds 1, 2, 3, ... and skips 2; lane i leaves when the counter reaches i % 8.
  Builder b;
  const int k = b.literal(0, 1, 2, 100);
  b.op(Opcode::Mov, rd(0, "x"), {l(k, "x")});                                     // sum
  b.loop();
  b.op(Opcode::Sge, rd(1, "x"), {loop_counter(0), v(0, "x")});
  b.flow(Opcode::Break, {r(1, "x")});
  b.op(Opcode::Seq, rd(1, "x"), {loop_counter(0), l(k, "y")});
  b.flow(Opcode::Continue, {r(1, "x")});
  b.op(Opcode::Add, rd(0, "x"), {r(0, "x"), loop_counter(0)});
  b.op(Opcode::Add, rd(0, "x"), {r(0, "x"), l(k, "y")});
  b.flow(Opcode::EndLoop);
  b.op(Opcode::Mov, o(0, "x"), {r(0, "x")});
  for (bool oracle : {false, true}) {
    Machine m(b.program, "fx31");
    for (int lane = 0; lane < kLanes; ++lane) m.set_input(0, 0, lane, lane % 8);
    oracle ? m.run_oracle() : m.run();
    for (int lane = 0; lane < kLanes; ++lane) {
      int sum = 0;
      for (int i = 0; i < lane % 8; ++i) sum += i == 1 ? 0 : i + 1;
      EXPECT_EQ(m.output(0, 0, lane), sum) << lane;
    }
    // Before the loop; test for break 8 times with 64, 56, ... 8 lanes; then those that stay; then without iteration 1.
    EXPECT_EQ(m.counters.blocks, (Counts{{1, 64, 0}, {8, 288, 0}, {7, 224, 0}, {6, 176, 0}, {1, 64, 0}})) << oracle;
    EXPECT_EQ(m.lane_blocks[1 * kLanes + 5], 6u);  // lane 5 tests in iterations 0..5
    EXPECT_EQ(m.lane_blocks[3 * kLanes + 5], 4u);  // and adds in 0, 2, 3, 4
  }
}

TEST(ControlFlow, CountedLoopsRunTheirTripsAndIndexUniforms) {
  Builder b;
  const int k = b.literal(0);
  Source light = c(1, "x");
  light.relative = {RelativeBase::LoopCounter, 0, 0, 2, 7};
  b.op(Opcode::Mov, rd(0, "x"), {l(k)});
  b.loop(4);
  b.op(Opcode::Add, rd(0, "x"), {r(0, "x"), light});
  b.flow(Opcode::EndLoop);
  b.op(Opcode::Mov, o(0, "x"), {r(0, "x")});
  EXPECT_TRUE(b.program.straight_line());
  Machine m(b.program, "fx31");
  for (std::size_t i = 0; i < 8; ++i) m.constants[4 * i] = static_cast<double>(1 << i);
  m.run();
  EXPECT_EQ(m.output(0, 0, 9), 2 + 8 + 32 + 128);
  EXPECT_EQ(m.counters.blocks, (Counts{{1, 64, 0}, {4, 256, 0}, {1, 64, 0}}));
}

TEST(ControlFlow, AnEndlessLoopIsLeftAndNamed) {
  Builder b;
  b.program.files = {"endless.hlsl"};
  b.op(Opcode::Mov, rd(0, "x"), {v(0, "x")});
  b.loop();
  b.flow(Opcode::EndLoop);
  b.op(Opcode::Mov, o(0, "x"), {r(0, "x")});
  Machine m(b.program, "fx31");
  m.set_input(0, 0, 3);
  m.run();
  EXPECT_EQ(m.counters.overrun_loop, 1);
  EXPECT_EQ(m.counters.blocks[1].executions, 65535u);
  EXPECT_EQ(m.output(0, 0, 0), 3);  // execution went on after the loop
  try {
    raise_loop_overrun(b.program, m.counters);
    FAIL() << "not raised";
  } catch (const UserError& e) {
    EXPECT_STREQ(e.what(), "endless.hlsl:2:1: loop did not end within 65535 iterations");
  }
}

TEST(ControlFlow, DerivativesUseTheWholeQuadWhateverTheMask) {
  Builder b;
  b.op(Opcode::Mul, rd(0, "x"), {v(0, "x"), v(0, "x")});
  b.flow(Opcode::If, {v(0, "y")});
  b.op(Opcode::DsX, rd(1, "x"), {r(0, "x")});
  b.op(Opcode::Mul, rd(2, "x"), {v(0, "x"), v(0, "x")});  // written by the masked lanes only:
  b.op(Opcode::DsY, rd(1, "y"), {r(2, "x")});             // others count as 0
  b.flow(Opcode::EndIf);
  b.op(Opcode::Mov, o(0, "xy"), {r(1, "xy")});
  for (bool oracle : {false, true}) {
    Machine m(b.program, "fx31");
    for (int lane = 0; lane < kLanes; ++lane) {
      m.set_input(0, 0, lane, lane % 4 + 1);
      m.set_input(0, 1, lane, lane % 4 == 0 ? 1 : 0);
    }
    oracle ? m.run_oracle() : m.run();
    EXPECT_EQ(m.output(0, 0, 4), 3);
    EXPECT_EQ(m.output(0, 1, 4), -1);
    EXPECT_EQ(m.output(0, 0, 5), 0);
  }
}

TEST(Blocks, AreMaximalRunsBetweenFlowInstructions) {
  Builder b;
  b.op(Opcode::Mov, rd(0), {v(0)});
  b.loop(3);
  b.loop(5);
  b.op(Opcode::Mov, rd(0), {v(0)});
  b.flow(Opcode::EndLoop);
  b.loop();
  b.flow(Opcode::Break, {v(0, "x")});
  b.flow(Opcode::EndLoop);
  b.flow(Opcode::EndLoop);
  b.op(Opcode::Mov, o(0), {r(0)});
  const std::vector<Block> blocks = find_blocks(b.program);
  const std::uint32_t begins[] = {0, 2, 3, 5, 6, 7, 8, 9}, trips[] = {1, 3, 15, 3, 0, 0, 3, 1}, depths[] = {0, 1, 2, 1, 2, 2, 1, 0};
  ASSERT_EQ(blocks.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(blocks[i].begin, begins[i]) << i;
    EXPECT_EQ(blocks[i].static_trips, trips[i]) << i;
    EXPECT_EQ(blocks[i].loop_depth, depths[i]) << i;
  }
  EXPECT_EQ(blocks.back().end, b.program.code.size());
  EXPECT_FALSE(b.program.straight_line());
}

TEST(Trace, RecordsEveryInstructionOfOneLane) {
  Builder b;
  b.op(Opcode::Mul, rd(0, "x"), {v(0, "x"), v(0, "x")});
  b.flow(Opcode::If, {v(0, "y")});
  b.op(Opcode::Rcp, rd(0, "x"), {v(0, "y")});
  b.flow(Opcode::EndIf);
  b.op(Opcode::Mov, o(0, "x"), {r(0, "x")});
  Machine m(b.program, "fx31");
  m.set_input(0, 0, 2000);
  Trace trace;
  trace.lane = 7;
  m.run_oracle(kAllLanes, kAllLanes, &trace);
  ASSERT_EQ(trace.entries.size(), 3u);  // the branch is not taken
  EXPECT_EQ(trace.entries[0].instruction, 0u);
  EXPECT_EQ(trace.entries[0].saturated, 1);
  EXPECT_EQ(trace.entries[1].result[0], 0);
  EXPECT_EQ(trace.entries[2].instruction, 4u);
}

TEST(CountersSum, DoesNotDependOnTheOrder) {
  Builder b;
  b.op(Opcode::Mul, o(0, "x"), {v(0, "x"), v(0, "x")});
  Machine m(b.program, "fx31"), n(b.program, "fx31");
  m.set_input(0, 0, 3000);
  m.run();
  n.run(0xf, 0x3);
  Counters one = m.counters, other = n.counters;
  one += n.counters;
  other += m.counters;
  EXPECT_EQ(one, other);
  EXPECT_EQ(one.blocks[0], (BlockCount{2, 66, 2}));
  EXPECT_EQ(one.saturations[0], 64u);
}

}  // namespace
}  // namespace aluminate::vm::testing
