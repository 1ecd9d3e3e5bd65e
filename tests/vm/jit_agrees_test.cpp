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

}  // namespace
}  // namespace aluminate::vm::testing
