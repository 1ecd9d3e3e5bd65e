// jit_stress COUNT FIRST, both optional: random programs through the compiler and the interpreter until something differs.
// Prints one line; exit 1 names the case that differs.
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>

#include "tests/vm/jit_agreement.hpp"

int main(int argc, char** argv) {
  using namespace aluminate::vm::testing;
  const std::uint64_t count = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 10000;
  const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
  JitCoverage coverage;
  const auto started = std::chrono::steady_clock::now();
  for (std::uint64_t n = first; n < first + count; ++n) {
    const JitCase c = nth_case(n);
    const aluminate::vm::Program program = RandomProgram(c.seed, c.control_flow).make();
    const std::string difference = compare_tiers(program, c, coverage);
    if (difference.empty()) continue;
    fmt::print("case {} (seed {}, {}, width {}) differs: {}\n{}", n, c.seed, c.format, c.options.width, difference,
               listing_of(program));
    return 1;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  fmt::print("{} programs agree, {:.0f} s; {} with kills, {} with fetches, {} instructions saturated; {} range checks proven away, "
             "{} kept; {} batches refused\n",
             coverage.compiled, seconds, coverage.killed, coverage.fetched, coverage.saturated, coverage.proven,
             coverage.checked, coverage.refused);
  return 0;
}
