// Known values, modifiers, grids, counters and borders, one property each.
#include <gtest/gtest.h>

#include <cmath>

#include "platform/host/error.hpp"
#include "platform/number/scalar.hpp"
#include "tests/vm/machine.hpp"
#include "tests/vm/program_builder.hpp"

namespace aluminate::vm::testing {
namespace {

TEST(Instructions, DotMadSaturateOnKnownValues) {
  Builder b;
  const int k = b.literal(0.5, 2, -3, 0.25);
  b.op(Opcode::Dp3, rd(0, "x"), {v(0), l(k)});                       // 0.5 + 4 - 9 = -4.5
  b.op(Opcode::Mad, rd(1, "xy"), {v(0, "xy"), l(k, "yx"), -r(0, "x")});  // 2 + 4.5, 1 + 4.5
  b.op(Opcode::Mul, rd(2, "x"), {r(1, "x"), l(k, "w")}).saturate = true; // 1.625 -> 1
  b.op(Opcode::Dp2Add, o(0, "w"), {v(0, "yz"), l(k, "xy"), r(0, "x")});  // 1 + 6 - 4.5
  b.op(Opcode::Mov, o(0, "x"), {r(0, "x")});
  b.op(Opcode::Mov, o(0, "yz"), {r(1, "xxy")});
  b.op(Opcode::Mov, o(1, "x"), {r(2, "x")});
  for (const char* name : {"fx31", "q16.16", "ref64"}) {
    Machine m(b.program, name);
    m.set_input(0, 0, 1);
    m.set_input(0, 1, 2);
    m.set_input(0, 2, 3);
    m.run();
    EXPECT_EQ(m.output(0, 0, 5), -4.5) << name;
    EXPECT_EQ(m.output(0, 1, 5), 6.5) << name;
    EXPECT_EQ(m.output(0, 2, 5), 5.5) << name;
    EXPECT_EQ(m.output(0, 3, 5), 2.5) << name;
    EXPECT_EQ(m.output(1, 0, 63), 1.0) << name;
  }
}

TEST(Instructions, SwizzlesThatOverlapTheDestinationReadOldValues) {
  Builder b;
  b.op(Opcode::Mov, rd(0), {v(0)});
  b.op(Opcode::Mov, rd(0), {r(0, "yzwx")});   // a cycle of four
  b.op(Opcode::Add, rd(0, "xy"), {r(0, "yx"), r(0, "xy")});
  b.op(Opcode::Mov, o(0), {r(0)});
  Machine m(b.program, "fx31");
  for (int c = 0; c < 4; ++c) m.set_input(0, c, c + 1);
  m.run();
  EXPECT_EQ(m.output(0, 0, 0), 5);
  EXPECT_EQ(m.output(0, 1, 0), 5);
  EXPECT_EQ(m.output(0, 2, 0), 4);
  EXPECT_EQ(m.output(0, 3, 0), 1);
}

TEST(Instructions, DeadComponentsCostNoOperation) {
  Builder b;
  b.op(Opcode::Mul, rd(0), {v(0), v(0)});
  b.op(Opcode::Rsq, rd(1, "x"), {r(0, "w")});
  b.op(Opcode::Mov, o(0, "x"), {r(0, "y")});
  const Executable e = prepare(b.program, format("fx31"));
  EXPECT_EQ(e.operation_count(), 2u);  // one product, one copy
  ASSERT_EQ(e.inputs().size(), 1u);
  EXPECT_EQ(e.inputs()[0], (RowBinding{0, 1}));
}

TEST(Instructions, RowsAreSharedByComponentsThatDoNotOverlap) {
  Builder b;
  b.op(Opcode::Mul, rd(0, "x"), {v(0, "x"), v(0, "x")});
  for (int i = 1; i < 20; ++i) b.op(Opcode::Mul, rd(i, "x"), {r(i - 1, "x"), v(0, "x")});
  b.op(Opcode::Mov, o(0, "x"), {r(19, "x")});
  EXPECT_LE(prepare(b.program, format("fx31")).row_count(), 4);
}

TEST(Instructions, SaturationsAreCountedPerInstructionForCoveredLanesOnly) {
  Builder b;
  b.op(Opcode::Mul, rd(0, "xy"), {v(0, "xy"), v(0, "xy")});
  b.op(Opcode::Add, rd(0, "x"), {r(0, "x"), r(0, "y")});
  b.op(Opcode::Mov, o(0, "xy"), {r(0, "xy")});
  Machine m(b.program, "fx31");
  m.set_input(0, 0, 1);
  m.set_input(0, 1, 1);
  for (int lane = 8; lane < 16; ++lane) m.set_input(0, 0, lane, 2000);  // 4e6 is beyond 2^20
  m.run(kAllLanes, 0x00000000000003ff);                                  // lanes 8 and 9 of those are covered
  EXPECT_EQ(m.counters.saturations[0], 2u);
  EXPECT_EQ(m.counters.saturations[1], 2u);
  EXPECT_EQ(m.counters.saturations[2], 0u);
  EXPECT_EQ(m.output(0, 0, 8), 0x1p20 - 0x1p-31);
  EXPECT_EQ(m.output(0, 0, 0), 2);
}

TEST(Instructions, InputsAndUniformsAreSanitisedAtTheBorder) {
  Builder b;
  b.op(Opcode::Add, o(0), {v(0), c(0)});
  Machine m(b.program, "q8.24");
  m.set_input(0, 0, std::nan(""));
  m.set_input(0, 1, 1e9);
  m.set_input(0, 2, -INFINITY);
  m.set_input(0, 3, 0x1p-26);
  m.constants = {1, 0, 0, INFINITY};
  m.run(kAllLanes, 0xf);
  EXPECT_EQ(m.output(0, 0, 0), 1);
  EXPECT_EQ(m.output(0, 1, 0), 128 - 0x1p-24);
  EXPECT_EQ(m.output(0, 2, 0), -128);
  EXPECT_EQ(m.output(0, 3, 0), 128 - 0x1p-24);
  EXPECT_EQ(m.counters.sanitised_inputs, 12u);
}

TEST(Instructions, InactiveLanesOfTheOutputRowsAreNotWritten) {
  Builder b;
  b.op(Opcode::Add, o(0, "x"), {v(0, "x"), v(0, "x")});
  Machine m(b.program, "fx31");
  m.set_input(0, 0, 3);
  for (int lane = 0; lane < kLanes; ++lane) m.outputs.at(0, lane) = -7;
  m.run(0x0ff0, 0x0f00);
  for (int lane = 0; lane < kLanes; ++lane) EXPECT_EQ(m.output(0, 0, lane), lane >= 4 && lane < 12 ? 6 : -7) << lane;
  EXPECT_EQ(m.counters.blocks[0], (BlockCount{1, 4, 4}));
}

TEST(Instructions, DiscardedLanesKeepFeedingDerivatives) {
  Builder b;
  const int zero = b.literal(0);
  b.op(Opcode::KillGt, {}, {v(0, "y"), l(zero)});
  b.op(Opcode::Mul, rd(0, "x"), {v(0, "x"), v(0, "x")});  // computed after the kill
  b.op(Opcode::DsX, o(0, "x"), {r(0, "x")});
  b.op(Opcode::DsY, o(0, "y"), {r(0, "x")});
  Machine m(b.program, "fx31");
  for (int lane = 0; lane < kLanes; ++lane) m.set_input(0, 0, lane, lane % 4 + 1);
  m.set_input(0, 1, 1, 1.0);  // lanes 1 and 5 are discarded
  m.set_input(0, 1, 5, 1.0);
  for (int lane = 0; lane < kLanes; ++lane) m.outputs.at(0, lane) = m.outputs.at(1, lane) = -7;
  m.run();
  EXPECT_EQ(m.batch.killed, 0x22u);
  for (int lane : {0, 2, 3, 4, 6, 7}) {
    EXPECT_EQ(m.output(0, 0, lane), 3) << lane;  // 2^2 - 1^2
    EXPECT_EQ(m.output(0, 1, lane), 8) << lane;  // 3^2 - 1^2
  }
  EXPECT_EQ(m.output(0, 0, 1), -7);
}

TEST(Instructions, RelativeAddressingIsClampedToItsArray) {
  Builder b;
  Source element = c(1, "x");
  element.relative = {RelativeBase::Temp, 0, 0, 2, 5};  // c1, c3, c5 are elements 0, 1, 2
  b.op(Opcode::Mov, rd(0, "x"), {v(0, "x")});
  b.op(Opcode::Mov, o(0, "x"), {element});
  Machine m(b.program, "fx31");
  for (std::size_t i = 0; i < m.constants.size(); ++i) m.constants[i] = static_cast<double>(i / 4);
  const double index[] = {0, 1, 2, 3, 100, -1, 1.75, -0.25};
  const double expected[] = {1, 3, 5, 5, 5, 1, 3, 1};
  for (int lane = 0; lane < 8; ++lane) m.set_input(0, 0, lane, index[lane]);
  m.run();
  for (int lane = 0; lane < 8; ++lane) EXPECT_EQ(m.output(0, 0, lane), expected[lane]) << index[lane];
}

TEST(Instructions, UninitialisedTempsAreZero) {
  Builder b;
  b.op(Opcode::Add, o(0, "x"), {r(0, "x"), v(0, "x")});
  Builder dirty;  // leaves large numbers in the scratch rows
  dirty.op(Opcode::Mul, o(0), {v(0), v(0)});
  Machine m(b.program, "fx31"), d(dirty.program, "fx31");
  for (int c = 0; c < 4; ++c) d.set_input(0, c, 900);
  m.set_input(0, 0, 2);
  Scratch scratch(d.executable);
  scratch.fit(m.executable);
  d.run();
  d.batch.outputs = d.outputs.data();
  run(d.executable, d.batch, scratch, d.counters);
  m.run();
  run(m.executable, m.batch, scratch, m.counters);
  EXPECT_EQ(m.output(0, 0, 17), 2);
}

// One light of the project's subject: D * F * V * n.l with pow by log and exp, rsq and rcp.
Builder light_program() {
  Builder b;
  const int k = b.literal(2, 0.125, 1, -1);       // 2, 1/8, 1, -1
  const int a = b.literal(0.785398163397448, 1.5707963267949, 0.04, 0.96);
  // v0 = (n.l, n.v, n.h, h.v), v1.x = m
  b.op(Opcode::Log, rd(0, "x"), {v(0, "z")});
  b.op(Opcode::Mul, rd(0, "x"), {r(0, "x"), v(1, "x")});
  b.op(Opcode::Exp, rd(0, "x"), {r(0, "x")}).saturate = true;
  b.op(Opcode::Add, rd(0, "y"), {v(1, "x"), l(k, "x")});
  b.op(Opcode::Mul, rd(0, "y"), {r(0, "y"), l(k, "y")});
  b.op(Opcode::Mul, rd(0, "x"), {r(0, "x"), r(0, "y")});            // D
  b.op(Opcode::Mad, rd(1, "x"), {v(1, "x"), l(a, "x"), l(a, "y")});
  b.op(Opcode::Rsq, rd(1, "x"), {r(1, "x")});
  b.op(Opcode::Add, rd(1, "y"), {l(k, "z"), -r(1, "x")});
  b.op(Opcode::Mad, rd(1, "zw"), {v(0, "xxxy"), r(1, "y"), r(1, "x")});
  b.op(Opcode::Mul, rd(1, "z"), {r(1, "z"), r(1, "w")});
  b.op(Opcode::Rcp, rd(1, "z"), {r(1, "z")});                        // V
  b.op(Opcode::Add, rd(2, "x"), {l(k, "z"), -v(0, "w")}).saturate = true;
  b.op(Opcode::Mul, rd(2, "y"), {r(2, "x"), r(2, "x")}).saturate = true;
  b.op(Opcode::Mul, rd(2, "y"), {r(2, "y"), r(2, "y")}).saturate = true;
  b.op(Opcode::Mul, rd(2, "x"), {r(2, "x"), r(2, "y")}).saturate = true;
  b.op(Opcode::Mad, rd(2, "x"), {r(2, "x"), l(a, "w"), l(a, "z")});  // F
  b.op(Opcode::Mul, rd(0, "x"), {r(0, "x"), r(2, "x")});
  b.op(Opcode::Mul, rd(0, "x"), {r(0, "x"), r(1, "z")});
  b.op(Opcode::Mul, o(0, "x"), {r(0, "x"), v(0, "x")});
  return b;
}

double worst_light_error(const char* name, double m_exponent_scale) {
  Machine m(light_program().program, name);
  double worst = 0;
  for (int batch = 0; batch < 40; ++batch) {
    long double expected[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) {
      const double t = (batch * kLanes + lane + 0.5) / (40 * kLanes);
      const number::Grid g = m.executable.format().default_grid();
      const auto on_grid = [&](double x) { return number::sanitise(g, x).value; };
      const double nl = on_grid(0.05 + 0.95 * std::fmod(t * 7.13, 1.0)), nv = on_grid(0.05 + 0.95 * std::fmod(t * 3.71, 1.0));
      const double exponent = on_grid(std::exp2(m_exponent_scale * std::fmod(t * 11.9, 1.0)));
      // Inside the highlight, down to values around e^-20.
      const double nh = on_grid(1 - 20.0 * std::fmod(t * 5.3, 1.0) / exponent * 0.5), hv = on_grid(0.1 + 0.9 * std::fmod(t * 2.9, 1.0));
      const double clamped_nh = nh < 0.01 ? 0.01 : nh;
      m.set_input(0, 0, lane, nl);
      m.set_input(0, 1, lane, nv);
      m.set_input(0, 2, lane, clamped_nh);
      m.set_input(0, 3, lane, hv);
      m.set_input(1, 0, lane, exponent);
      const long double e = exponent, a = 1 / std::sqrt(e * 0.785398163397448L + 1.5707963267949L);
      const long double gridded = number::sanitise(g, clamped_nh).value;
      const long double d = std::exp2(e * std::log2(gridded)) * (e + 2) / 8;
      const long double visibility = 1 / ((nl * (1 - a) + a) * (nv * (1 - a) + a));
      const long double f = std::pow(1 - static_cast<long double>(hv), 5.0L) * 0.96L + 0.04L;
      expected[lane] = d * f * visibility * nl;
    }
    m.run();
    for (int lane = 0; lane < kLanes; ++lane) {
      const double error = std::fabs(static_cast<double>((m.output(0, 0, lane) - expected[lane]) /
                                                         std::max<long double>(expected[lane], name[0] == 'r' ? 0.0L : 1e-3L)));
      worst = std::max(worst, error);
    }
  }
  return worst;
}

TEST(Accuracy, BlinnPhongSchlickSmithAgreesWithLongDouble) {
  // ref64: m log2(n.h) errs by 2^-50 of at most 30, times ln 2: 2e-14; the other functions by a few 2^-52; the constants
  // 0.785.. and 0.96 by 2^-53. 1e-11 is the contract and leaves room.
  EXPECT_LT(worst_light_error("ref64", 13), 1e-11);
  // fx31: log2 rounds to 2^-32, times m ln 2 = 5678 at m = 8192: 1.3e-6 relative; the value itself >= 1e-3 in steps of 2^-31.
  const double fx31 = worst_light_error("fx31", 13);
  EXPECT_LT(fx31, 4e-6);
  EXPECT_GT(fx31, 1e-9) << "fx31 cannot be that good: is the grid in use?";
}

TEST(Validate, NamesTheInstructionThatIsWrong) {
  const auto expect_refused = [](Builder b, const char* what) {
    try {
      validate(b.program);
      ADD_FAILURE() << "accepted: " << what;
    } catch (const InternalError& e) {
      EXPECT_NE(std::string(e.what()).find(what), std::string::npos) << e.what();
    }
  };
  Builder b;
  b.op(Opcode::Mov, o(0), {v(0)});
  EXPECT_NO_THROW(validate(b.program));
  Builder bad = b;
  bad.program.inputs.clear();
  expect_refused(bad, "instruction 0 mov: source register out of range");
  bad = b;
  bad.program.code[0].dst.mask = 0;
  expect_refused(bad, "empty write mask");
  bad = b;
  bad.flow(Opcode::EndIf);
  expect_refused(bad, "EndIf without If");
  bad = b;
  bad.flow(Opcode::If, {v(0)});
  expect_refused(bad, "If or Loop without its end");
  bad = b;
  bad.flow(Opcode::Break, {v(0)});
  expect_refused(bad, "outside a loop");
  bad = b;
  bad.program.code[0].src[0].swizzle[2] = 4;
  expect_refused(bad, "swizzle");
}

TEST(Disassembly, ReadsLikeShaderAssembly) {
  Builder b;
  b.op(Opcode::Mad, rd(3, "xyz"), {r(1, "x"), c(4), -r(2)});
  Instruction& sat = b.op(Opcode::Add, o(0, "w"), {magnitude(v(1, "y")), -magnitude(l(0, "z"))});
  sat.saturate = true;
  b.loop(4);
  Source light = c(8);
  light.relative = {RelativeBase::LoopCounter, 0, 0, 3, 12};
  b.op(Opcode::Mov, rd(0), {light});
  const auto line = [&](std::size_t i) { return disassemble(b.program, b.program.code[i]); };
  EXPECT_EQ(line(0), "mad r3.xyz, r1.xxxx, c4.xyzw, -r2.xyzw");
  EXPECT_EQ(line(1), "add_sat o0.w, |v1.yyyy|, -|l0.zzzz|");
  EXPECT_EQ(line(2), "loop 4");
  EXPECT_EQ(line(3), "mov r0.xyzw, c8[3*aL0].xyzw");
}

}  // namespace
}  // namespace aluminate::vm::testing
