// The fast interpreter against its oracle: the same bits in outputs, kills and counters, for random programs in every
// number format on every instruction set this build has.
#include <gtest/gtest.h>

#include <bit>
#include <random>

#include "shading/vm/decoded.hpp"
#include "tests/vm/machine.hpp"
#include "tests/vm/random_batch.hpp"
#include "tests/vm/random_program.hpp"

namespace aluminate::vm::testing {
namespace {

struct Coverage {
  int saturated = 0, killed = 0, fetched = 0, diverged = 0, different_outputs = 0;
};

void expect_agreement(std::uint64_t seed, bool control_flow, const char* format_name, Coverage& coverage) {
  const Program program = RandomProgram(seed, control_flow).make();
  Machine fast(program, format_name), slow(program, format_name);
  fill(fast, seed);
  fill(slow, seed);
  std::mt19937_64 random(seed ^ 0x5eed);
  std::uint64_t active = 0, covered = 0;
  random_masks(random, active, covered);
  for (auto* machine : {&fast, &slow})
    std::fill(machine->outputs.bytes.begin(), machine->outputs.bytes.end(), 12345.0);
  fast.run(active, covered);
  slow.run_oracle(active, covered);

  const auto text = [&] {
    std::string listing;
    for (const Instruction& i : program.code) listing += disassemble(program, i) + "\n";
    return listing;
  };
  ASSERT_EQ(fast.batch.killed, slow.batch.killed) << text();
  for (std::size_t row = 0; row < fast.executable.outputs().size(); ++row)
    for (int lane = 0; lane < kLanes; ++lane) {
      const double a = fast.outputs.at(row, lane), b = slow.outputs.at(row, lane);
      ASSERT_EQ(std::bit_cast<std::uint64_t>(a), std::bit_cast<std::uint64_t>(b))
          << "seed " << seed << " " << format_name << " on " << kernel_target() << ": o" << fast.executable.outputs()[row].index
          << "." << "xyzw"[fast.executable.outputs()[row].component] << " lane " << lane << ": " << a << " and " << b << "\n"
          << text();
      coverage.different_outputs += lane > 0 && a != fast.outputs.at(row, 0) ? 1 : 0;
    }
  ASSERT_TRUE(fast.counters == slow.counters) << "seed " << seed << " " << format_name << "\n" << text();
  ASSERT_EQ(fast.lane_blocks, slow.lane_blocks) << "seed " << seed << "\n" << text();
  for (auto n : fast.counters.saturations) coverage.saturated += n != 0 ? 1 : 0;
  coverage.killed += fast.batch.killed != 0 ? 1 : 0;
  coverage.fetched += fast.counters.fetches != 0 ? 1 : 0;
  for (const BlockCount& b : fast.counters.blocks)
    coverage.diverged += b.executions != 0 && b.covered_lanes + b.helper_lanes < fast.counters.blocks[0].covered_lanes + fast.counters.blocks[0].helper_lanes ? 1 : 0;
}

class EveryTarget : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { force_kernel_target(GetParam()); }
  void TearDown() override { force_kernel_target(nullptr); }
};

constexpr std::uint64_t kProgramsPerFormat = 300;

TEST_P(EveryTarget, StraightLineProgramsGiveTheOraclesBits) {
  Coverage coverage;
  for (const char* name : kFormats)
    for (std::uint64_t seed = 0; seed < kProgramsPerFormat; ++seed) {
      expect_agreement(seed * 8 + 1, false, name, coverage);
      if (HasFatalFailure()) return;
    }
  // A run in which nothing saturates, nothing is fetched and all lanes agree would prove nothing.
  EXPECT_GT(coverage.saturated, 500);
  EXPECT_GT(coverage.killed, 100);
  EXPECT_GT(coverage.fetched, 200);
  EXPECT_GT(coverage.different_outputs, 10000);
}

TEST_P(EveryTarget, DivergentProgramsGiveTheOraclesBits) {
  Coverage coverage;
  for (const char* name : kFormats)
    for (std::uint64_t seed = 0; seed < kProgramsPerFormat; ++seed) {
      expect_agreement(seed * 8 + 2, true, name, coverage);
      if (HasFatalFailure()) return;
    }
  EXPECT_GT(coverage.diverged, 1000);
}

// FNV-1a over every output bit: the same number from every compiler, optimisation level and CPU, or the machine changed.
TEST(GoldenBits, OfRandomProgramsAreTheSameEverywhere) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char* name : kFormats)
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
      Machine machine(RandomProgram(seed, seed % 2 == 0).make(), name);
      fill(machine, seed);
      machine.run();
      for (double x : machine.outputs.values().first(machine.executable.outputs().size() * kLanes))
        hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x100000001b3;
    }
  EXPECT_EQ(hash, 0xa95bea9290f307baull);
}

INSTANTIATE_TEST_SUITE_P(Kernels, EveryTarget, ::testing::ValuesIn(kernel_targets()),
                         [](const auto& target) { return std::string(target.param); });

}  // namespace
}  // namespace aluminate::vm::testing
