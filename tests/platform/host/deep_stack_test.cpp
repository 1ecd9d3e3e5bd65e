#include "platform/host/deep_stack.hpp"

#include <gtest/gtest.h>

#include <array>

#include "platform/host/error.hpp"

namespace aluminate::host {
namespace {

// Each level keeps a kibibyte alive, and the call is no tail call.
std::int64_t nest(int depth) {
  std::array<volatile char, 1024> frame{};
  frame[static_cast<std::size_t>(depth) % frame.size()] = 1;
  return depth == 0 ? 0 : 1 + nest(depth - 1) + frame[static_cast<std::size_t>(depth + 1) % frame.size()];
}

TEST(DeepStack, HoldsMoreThanTheUsualEightMebibytes) {
  constexpr int kDepth = 32 * 1024;
  std::int64_t depth = 0;
  run_on_deep_stack(std::size_t{256} << 20, [&] { depth = nest(kDepth); });
  EXPECT_EQ(depth, kDepth);
}

TEST(DeepStack, ExceptionsReachTheCaller) {
  EXPECT_THROW(run_on_deep_stack(1 << 20, [] { throw UserError("nested too deep"); }), UserError);
}

TEST(DeepStack, RefusesAStackNoThreadCanHave) { EXPECT_THROW(run_on_deep_stack(1, [] {}), InternalError); }

}  // namespace
}  // namespace aluminate::host
