#include "shading/cost/slots.hpp"

#include "shading/cost/xenos_lowering.hpp"
#include "shading/cost/xenos_rewrite.hpp"

namespace aluminate::cost {
namespace {

using vm::Opcode;

bool is_compare(Opcode op) {
  return op == Opcode::Sge || op == Opcode::Sgt || op == Opcode::Seq || op == Opcode::Sne;
}

/// Whether an instruction reads component c of a temp register through one of its sources.
bool reads(const vm::Program& program, const vm::Instruction& instruction, std::uint16_t temp, int c) {
  for (int s = 0; s < vm::info(instruction.op).sources; ++s) {
    const vm::Source& source = instruction.src[static_cast<std::size_t>(s)];
    if (source.relative.base == vm::RelativeBase::Temp && source.relative.index == temp &&
        source.relative.component == c)
      return true;
    if (source.file != vm::RegisterFile::Temp || source.index != temp) continue;
    for (int lane = 0; lane < 4; ++lane)
      if (source.swizzle[static_cast<std::size_t>(lane)] == c && reads_lane(program, instruction, s, lane))
        return true;
  }
  return false;
}

}  // namespace

std::vector<int> instruction_slots(const vm::Program& program) {
  std::vector<int> slots;
  slots.reserve(program.code.size());
  for (const vm::Instruction& instruction : program.code) slots.push_back(vm::info(instruction.op).ps3_slots);

  const std::vector<vm::Block> blocks = vm::find_blocks(program);
  const std::vector<std::uint8_t> across = components_across_blocks(program, blocks);
  for (const vm::Block& block : blocks) {
    if (block.end == block.begin) continue;
    // A flow instruction ends its block.
    const std::uint32_t last = block.end - 1;
    const vm::Instruction& flow = program.code[last];
    if (vm::info(flow.op).pipe != vm::Pipe::Flow || vm::info(flow.op).sources == 0) continue;
    const vm::Source& condition = flow.src[0];
    if (condition.file != vm::RegisterFile::Temp || condition.absolute ||
        condition.relative.base != vm::RelativeBase::None)
      continue;
    const std::uint16_t temp = condition.index;
    const int component = condition.swizzle[0];
    if (across[temp] >> component & 1) continue;  // read again in another block
    for (std::uint32_t i = last; i-- > block.begin;) {
      const vm::Instruction& writer = program.code[i];
      const bool writes = writer.dst.file == vm::RegisterFile::Temp && writer.dst.index == temp &&
                          (writer.dst.mask >> component & 1);
      if (writes) {
        if (is_compare(writer.op) && writer.dst.mask == 1 << component && !writer.saturate) slots[i] = 0;
        break;
      }
      if (reads(program, writer, temp, component)) break;
    }
  }
  return slots;
}

}  // namespace aluminate::cost
