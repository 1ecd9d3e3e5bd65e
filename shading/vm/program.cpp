#include "shading/vm/program.hpp"

#include <algorithm>

namespace aluminate::vm {

bool Program::straight_line() const {
  return std::none_of(code.begin(), code.end(), [](const Instruction& i) {
    return i.op == Opcode::If || i.op == Opcode::Break || i.op == Opcode::Continue ||
           (i.op == Opcode::Loop && i.trip_count < 0);
  });
}

std::vector<Block> find_blocks(const Program& program) {
  const auto& code = program.code;
  const auto size = static_cast<std::uint32_t>(code.size());

  // Iterations of each loop, by the index of its Loop instruction: unknown (0) when open or left early. A Continue
  // leaves the number of iterations alone.
  std::vector<std::uint32_t> trips(size, 0);
  std::vector<std::uint32_t> open;
  for (std::uint32_t i = 0; i < size; ++i) {
    if (code[i].op == Opcode::Loop) {
      trips[i] = code[i].trip_count < 0 ? 0 : static_cast<std::uint32_t>(code[i].trip_count);
      open.push_back(i);
    }
    if (code[i].op == Opcode::Break && !open.empty()) trips[open.back()] = 0;
    if (code[i].op == Opcode::EndLoop && !open.empty()) open.pop_back();
  }

  std::vector<Block> blocks;
  std::vector<std::uint32_t> products = {1};
  std::uint32_t begin = 0;
  for (std::uint32_t i = 0; i < size; ++i) {
    if (info(code[i].op).pipe != Pipe::Flow) continue;
    blocks.push_back({begin, i + 1, products.back(), static_cast<std::uint8_t>(products.size() - 1)});
    begin = i + 1;
    if (code[i].op == Opcode::Loop) {
      const std::uint64_t product = std::uint64_t{products.back()} * trips[i];
      products.push_back(product <= UINT32_MAX ? static_cast<std::uint32_t>(product) : 0);
    }
    if (code[i].op == Opcode::EndLoop && products.size() > 1) products.pop_back();
  }
  if (begin < size) blocks.push_back({begin, size, products.back(), static_cast<std::uint8_t>(products.size() - 1)});
  return blocks;
}

}  // namespace aluminate::vm
