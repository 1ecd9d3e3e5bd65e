#include "shading/vm/isa_doc.hpp"

#include <fmt/format.h>

#include "shading/vm/program.hpp"

namespace aluminate::vm {
namespace {

std::string_view pipe_name(Pipe pipe) {
  switch (pipe) {
    case Pipe::Vector: return "vector";
    case Pipe::Scalar: return "scalar";
    case Pipe::Either: return "either";
    case Pipe::Fetch: return "fetch";
    case Pipe::Flow: return "flow";
  }
  return "";
}

// A bar would end the table cell.
std::string cell(std::string_view text) {
  std::string out;
  for (char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

}  // namespace

std::string isa_markdown() {
  std::string page = R"(# Instruction set

Generated from `shading/vm/isa.def` by `isa_doc`; a test fails when this page is stale. Rounding words refer to
[number_formats.md](number_formats.md).

- Registers are vec4; an instruction writes the components of its write mask. A *scalar* instruction and a dot product
  write one number to all of them.
- Sources take a swizzle, then absolute value, then negation; a result may be saturated to [0, 1]. All of these are free.
- Pipe: *vector* and *scalar* are the two halves of an instruction word; *either* goes to the scalar half when one
  component wide; *fetch* is the texture unit; *flow* is the sequencer.
- Slots are those of Direct3D 9 ps_3_0 [MSD]; texture instructions are counted as fetches instead.

| instruction | sources | pipe | slots | result | rounding |
|---|---|---|---|---|---|
)";
  for (const OpcodeInfo& op : kOpcodes)
    page += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", op.mnemonic, op.sources, pipe_name(op.pipe),
                        op.ps3_slots == 0 ? "fetch" : fmt::format("{}", op.ps3_slots), cell(op.meaning), cell(op.rounding));
  return page;
}

}  // namespace aluminate::vm
