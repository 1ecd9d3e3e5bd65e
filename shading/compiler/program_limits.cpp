#include "shading/compiler/program_limits.hpp"

#include "platform/host/error.hpp"
#include "shading/compiler/limits.hpp"

#include <algorithm>

namespace aluminate::compiler {
namespace {

SourcePlace place(const vm::Program& program, const vm::Instruction& i) {
  if (i.line.line == 0 || i.line.file >= program.files.size()) return {};
  return {program.files[i.line.file], static_cast<int>(i.line.line), i.line.column};
}

}  // namespace

void check_limits(const vm::Program& program) {
  // Runs of each open block by one lane; an open loop counts once, vm::kLoopLimit ends it.
  std::vector<std::uint64_t> runs{1};
  std::uint64_t work = 0;
  for (const vm::Instruction& i : program.code) {
    if (i.op == vm::Opcode::EndIf || i.op == vm::Opcode::EndLoop) runs.pop_back();
    work += runs.back();
    if (work > kMaxCountedInstructions)
      throw UserError(place(program, i),
                      fmt::format("one pixel would run more than {} instructions", kMaxCountedInstructions),
                      "the loops around this line multiply; shorten them");
    if (i.op == vm::Opcode::If) runs.push_back(runs.back());
    // runs <= kMaxCountedInstructions < 2^25 and trips < 2^16: the product is below 2^41
    if (i.op == vm::Opcode::Loop)
      runs.push_back(runs.back() * static_cast<std::uint64_t>(std::max(i.trip_count, 1)));
    if (static_cast<int>(runs.size()) - 1 > kMaxNesting)
      throw UserError(place(program, i),
                      fmt::format("ifs and loops are nested deeper than {}", kMaxNesting),
                      "a switch is a chain of ifs here: index a table instead, or split it");
  }
}

}  // namespace aluminate::compiler
