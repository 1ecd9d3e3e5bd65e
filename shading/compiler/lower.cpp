#include "shading/compiler/lowerer.hpp"

#include <spirv/unified1/spirv.hpp11>

#include <bit>

namespace aluminate::compiler {

Lowerer::Lowerer(const SpirvModule& module, vm::Stage stage, LoopMode loops,
                 std::set<std::string> explicit_registers)
    : m_(module),
      stage_(stage),
      loops_(loops),
      explicit_registers_(std::move(explicit_registers)),
      b_(out_.ir) {}

Lowered Lowerer::run() {
  out_.symbols.stage = stage_;
  out_.symbols.files = m_.files();
  map_interface();
  walk(0, m_.blocks().front().label, 0);
  write_outputs();
  return std::move(out_);
}

Lowered lower(const SpirvModule& module, vm::Stage stage, LoopMode loops,
              std::set<std::string> explicit_registers) {
  return Lowerer(module, stage, loops, std::move(explicit_registers)).run();
}

SourcePlace Lowerer::place(const vm::SourceLine& line) const {
  SourcePlace p;
  if (line.line == 0 || line.file >= m_.files().size()) return p;
  p.file = m_.files()[line.file];
  p.line = static_cast<int>(line.line);
  p.column = line.column;
  return p;
}

void Lowerer::refuse(const SpirvInstruction& i, const std::string& what, const std::string& hint) const {
  throw UserError(place(i.line.line != 0 ? i.line : b_.line()), "unsupported: " + what, hint);
}

Tuple Lowerer::constant(SpvId id, const SpirvInstruction& d) {
  switch (static_cast<spv::Op>(d.op)) {
    case spv::Op::OpConstantTrue:
    case spv::Op::OpSpecConstantTrue:
      return {num(1)};
    case spv::Op::OpConstantFalse:
    case spv::Op::OpSpecConstantFalse:
      return {num(0)};
    case spv::Op::OpConstantNull:
    case spv::Op::OpUndef:
      hold(d, m_.scalar_count(d.type));
      return Tuple(m_.scalar_count(d.type), num(0));
    case spv::Op::OpConstant:
    case spv::Op::OpSpecConstant: {
      const SpirvType& t = m_.type(d.type);
      if (t.kind == SpirvType::Kind::Int) return {num(static_cast<double>(*m_.integer(id)))};
      if (t.kind != SpirvType::Kind::Float) refuse(d, "a constant of this type", "use float, int or bool");
      // HLSL's 1.5L: a register holds more than a binary32, so constants may be written with full precision.
      const double f = d.operands.size() > 1
                           ? std::bit_cast<double>(std::uint64_t{d.operands[1]} << 32 | d.operands[0])
                           : double{std::bit_cast<float>(d.operands[0])};
      if (!(f - f == 0))
        refuse(d, "a constant that is not a finite number", "the number formats have no infinity");
      return {num(f)};
    }
    case spv::Op::OpConstantComposite:
    case spv::Op::OpSpecConstantComposite: {
      Tuple t;
      for (SpvId part : d.operands) {
        const Tuple v = value(part);
        hold(d, v.size());
        t.insert(t.end(), v.begin(), v.end());
      }
      return t;
    }
    default:
      refuse(d, spirv_op_name(d.op) + " as a value");
  }
}

const Tuple& Lowerer::value(SpvId id) {
  if (auto it = values_.find(id); it != values_.end()) return it->second;
  const SpirvInstruction* d = m_.definition(id);
  if (d == nullptr) throw UserError(place(b_.line()), fmt::format("value %{} has no definition", id));
  Tuple t = constant(id, *d);
  return values_[id] = std::move(t);
}

Lanes Lowerer::vec(SpvId id) {
  const Tuple& t = value(id);
  if (t.size() > 4)
    throw UserError(place(b_.line()), fmt::format("unsupported: a vector of {} components", t.size()),
                    "vectors have up to 4");
  Lanes v;
  for (Ref r : t) v.push(r);
  return v;
}

std::vector<Lanes> Lowerer::columns(SpvId id) {
  const Tuple t = value(id);
  const SpirvInstruction* d = m_.definition(id);
  const std::uint32_t rows = m_.type(m_.type(d->type).element).count;
  std::vector<Lanes> result;
  for (std::size_t first = 0; first < t.size(); first += rows) {
    Lanes column;
    for (std::size_t k = first; k < first + rows; ++k) column.push(t[k]);
    result.push_back(column);
  }
  return result;
}

// Values are never dropped; this bounds what they take together.
void Lowerer::hold(const SpirvInstruction& i, std::size_t scalars) {
  held_ += scalars;
  if (held_ > kMaxHeldScalars)
    throw UserError(place(i.line.line != 0 ? i.line : b_.line()),
                    fmt::format("the shader handles more than {} numbers in arrays and structs", kMaxHeldScalars),
                    "pass large tables in uniforms, and index them");
}

void Lowerer::define(const SpirvInstruction& i, Tuple v) {
  hold(i, v.size());
  values_[i.result] = std::move(v);
}

void Lowerer::instruction(const SpirvInstruction& i) {
  if (i.line.line != 0) b_.set_line(i.line);
  spend(kStepsPerInstruction);
  switch (static_cast<spv::Op>(i.op)) {
    case spv::Op::OpVariable:
      declare(i);
      return;
    case spv::Op::OpAccessChain:
    case spv::Op::OpInBoundsAccessChain:
      access_chain(i);
      return;
    case spv::Op::OpLoad:
      load(i);
      return;
    case spv::Op::OpStore:
      store(i);
      return;
    case spv::Op::OpUndef:
      hold(i, m_.scalar_count(i.type));
      define(i, Tuple(m_.scalar_count(i.type), num(0)));
      return;
    case spv::Op::OpCopyObject:
    case spv::Op::OpCopyLogical:
      if (pointers_.contains(i.operands[0]))
        pointers_[i.result] = pointers_[i.operands[0]];
      else if (images_.contains(i.operands[0]))
        images_[i.result] = images_[i.operands[0]];
      else
        define(i, value(i.operands[0]));
      return;
    case spv::Op::OpCopyMemory:
      refuse(i, "OpCopyMemory");
    case spv::Op::OpDemoteToHelperInvocation:
      b_.kill_if(num(1));
      return;
    case spv::Op::OpFunctionCall:
      if (m_.kills(i.operands[0])) {
        b_.kill_if(num(1));
        return;
      }
      refuse(i, fmt::format("a call of '{}' that cannot be inlined", m_.name(i.operands[0])),
             "recursion has no stack here");
    case spv::Op::OpExtInst:
      if (m_.import_name(i.operands[0]) != "GLSL.std.450") {
        if (m_.import_name(i.operands[0]).starts_with("NonSemantic.")) return;
        refuse(i, "instruction set " + m_.import_name(i.operands[0]));
      }
      glsl_std(i);
      return;
    default:
      break;
  }
  if (arithmetic(i) || comparison(i) || composite(i) || integer_arithmetic(i) || matrix(i) || texture(i))
    return;
  refuse(i, spirv_op_name(i.op));
}

}  // namespace aluminate::compiler
