// program_bits FILE: runs every program of FILE, if given (write_shipped makes it), and 300 random ones in every number format on
// fixed batches, and prints a hash of all that comes out: outputs, kills and saturations. The same lines on every machine.
#include <bit>
#include <cstdio>
#include <fstream>

#include "shading/vm/jit/slot.hpp"
#include "tests/vm/machine.hpp"
#include "tests/vm/program_file.hpp"
#include "tests/vm/random_batch.hpp"
#include "tests/vm/random_program.hpp"

#ifndef __x86_64__
// Compiled code is for x86-64 only: a build for another machine interprets, and nobody asks it to do otherwise.
#include "shading/vm/jit/tier.hpp"
namespace aluminate {
host::MachineCode::~MachineCode() = default;
namespace vm::jit {
void compile_later(const Executable&, Assume) noexcept {}
Outcome run_native(const Native&, const Decoded&, const Batch&, Frame&, Counters&) noexcept { return Outcome::GaveUp; }
}  // namespace vm::jit
}  // namespace aluminate
#endif

namespace {

using namespace aluminate::vm;
using namespace aluminate::vm::testing;

std::uint64_t bits_of(const Program& program, const char* format_name) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](std::uint64_t x) { hash = (hash ^ x) * 0x100000001b3; };
  for (std::uint64_t seed : {1, 2}) {
    Machine machine(program, format_name);
    fill(machine, seed, seed == 1 ? Numbers::Tame : Numbers::Hostile);
    machine.run();
    for (double x : machine.outputs.values().first(machine.executable.outputs().size() * kLanes))
      add(std::bit_cast<std::uint64_t>(x));
    add(machine.batch.killed);
    for (std::uint64_t n : machine.counters.saturations) add(n);
  }
  return hash;
}

void report(const char* kind, std::uint64_t number, const Program& program) {
  std::printf("%s %llu", kind, static_cast<unsigned long long>(number));
  for (const char* name : kFormats)
    std::printf(" %s:%016llx", name, static_cast<unsigned long long>(bits_of(program, name)));
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) {
    std::ifstream file(argv[1], std::ios::binary);
    if (!file) {
      std::fprintf(stderr, "%s cannot be read\n", argv[1]);
      return 2;
    }
    Program program;
    std::uint64_t count = 0;
    while (read_program(file, program)) report("shipped", count++, program);
    if (count == 0) {
      std::fprintf(stderr, "%s holds no program for this machine\n", argv[1]);
      return 2;
    }
  }
  for (std::uint64_t n = 0; n < 300; ++n) report("random", n, RandomProgram(n, n % 2 == 0).make());
  std::fprintf(stderr, "kernels: %s\n", kernel_target());
}
