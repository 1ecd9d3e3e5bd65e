// Holds compiled code to the interpreter: the same random program, the same batch, the same bits, kills and counters.
#pragma once

#include <bit>
#include <cstring>

#include "platform/host/error.hpp"
#include "shading/vm/jit/compiler.hpp"
#include "shading/vm/jit/slot.hpp"
#include "tests/vm/random_batch.hpp"
#include "tests/vm/random_program.hpp"

namespace aluminate::vm::testing {

struct JitCase {
  std::uint64_t seed = 0;
  bool control_flow = false;
  const char* format = "fx31";
  jit::CompileOptions options;
  Numbers numbers = Numbers::Hostile;
};

struct JitCoverage {
  int compiled = 0, saturated = 0, killed = 0, fetched = 0, proven = 0, checked = 0, refused = 0;
};

inline std::string listing_of(const Program& program) {
  std::string listing;
  for (const Instruction& i : program.code) listing += disassemble(program, i) + "\n";
  return listing;
}

/// Empty when both agree, else what differs first. `program` may come from anywhere.
inline std::string compare_tiers(const Program& program, const JitCase& c, JitCoverage& coverage) {
  Machine interpreted(program, c.format), compiled(program, c.format);
  const jit::Compiled made = jit::compile(compiled.executable.decoded(), c.options);
  if (made.code.empty()) return "not compiled: " + made.problem;
  jit::Slot& slot = compiled.executable.slot();
  slot.publish(c.options.assume, std::make_shared<jit::Native>(made.code, made.description));
  std::mt19937_64 random(c.seed ^ 0x5eed);
  std::uint64_t active = 0, covered = 0;
  random_masks(random, active, covered);
  for (Machine* machine : {&interpreted, &compiled}) {
    fill(*machine, c.seed, c.numbers);
    std::fill(machine->outputs.bytes.begin(), machine->outputs.bytes.end(), 12345.0);
  }
  // Tells whether the typical code took the batch, which a test of agreement has to know.
  const auto untouched = std::make_shared<std::atomic<std::int64_t>>(1000);
  slot.watch(Assume::Nothing, untouched);
  interpreted.run(active, covered);
  compiled.run(active, covered);
  if (*untouched != 1000) ++coverage.refused;
  ++coverage.compiled;

  if (interpreted.batch.killed != compiled.batch.killed) return "killed lanes";
  for (std::size_t row = 0; row < interpreted.executable.outputs().size(); ++row)
    for (int lane = 0; lane < kLanes; ++lane) {
      const double a = interpreted.outputs.at(row, lane), b = compiled.outputs.at(row, lane);
      if (std::bit_cast<std::uint64_t>(a) != std::bit_cast<std::uint64_t>(b))
        return fmt::format("o{}.{} lane {}: {:a} interpreted, {:a} compiled", interpreted.executable.outputs()[row].index,
                           "xyzw"[interpreted.executable.outputs()[row].component], lane, a, b);
    }
  for (std::size_t i = 0; i < program.code.size(); ++i)
    if (interpreted.counters.saturations[i] != compiled.counters.saturations[i])
      return fmt::format("saturations of instruction {}: {} interpreted, {} compiled", i, interpreted.counters.saturations[i],
                         compiled.counters.saturations[i]);
  if (!(interpreted.counters == compiled.counters)) return "counters";
  if (interpreted.lane_blocks != compiled.lane_blocks) return "executions per lane";
  for (auto n : interpreted.counters.saturations) coverage.saturated += n != 0 ? 1 : 0;
  coverage.killed += interpreted.batch.killed != 0 ? 1 : 0;
  coverage.fetched += interpreted.counters.fetches != 0 ? 1 : 0;
  const RangePlan plan = plan_ranges(compiled.executable.decoded(), c.options.assume);
  for (std::size_t i = 0; i < plan.operations.size(); ++i)
    if (compiled.executable.decoded().operations[i].post == Post::Range)
      ++(plan.operations[i].in_range ? coverage.proven : coverage.checked);
  return {};
}

/// The nth case of a long series: every format, width, assumption and kind of program comes up.
inline JitCase nth_case(std::uint64_t n) {
  JitCase c;
  c.seed = n * 8 + 3;
  c.control_flow = n % 2 == 0;
  c.format = kFormats[n / 2 % std::size(kFormats)];
  c.options.width = 8u << (n / 2 / std::size(kFormats) % 4);
  c.options.assume = n % 3 == 0 ? Assume::Typical : Assume::Nothing;
  c.numbers = n % 3 == 0 ? Numbers::Tame : Numbers::Hostile;
  return c;
}

}  // namespace aluminate::vm::testing
