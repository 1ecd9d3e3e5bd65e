// SPIR-V module in, Ir and the symbol tables of the future Program out. Walks the structured control flow
// once, in source order; loops are unrolled here by walking their body again. Anything without an exact
// counterpart is a UserError that names the operation and its source line.
#pragma once

#include "shading/compiler/compile.hpp"
#include "shading/compiler/ir.hpp"
#include "shading/compiler/spirv_module.hpp"

#include <set>

namespace aluminate::compiler {

struct Lowered {
  Ir ir;
  vm::Program symbols;  // inputs, outputs, uniforms, samplers, files; no code
};

/// explicit_registers: uniforms declared with register(cN); the others are numbered around them.
Lowered lower(const SpirvModule& module, vm::Stage stage, LoopMode loops,
              std::set<std::string> explicit_registers);

}  // namespace aluminate::compiler
