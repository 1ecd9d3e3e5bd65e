#include "shading/compiler/lowerer.hpp"

#include <spirv/unified1/spirv.hpp11>

#include <algorithm>
#include <cctype>

namespace aluminate::compiler {
namespace {

constexpr auto kLocation = static_cast<std::uint32_t>(spv::Decoration::Location);
constexpr auto kComponent = static_cast<std::uint32_t>(spv::Decoration::Component);
constexpr auto kBuiltIn = static_cast<std::uint32_t>(spv::Decoration::BuiltIn);
constexpr auto kBinding = static_cast<std::uint32_t>(spv::Decoration::Binding);
constexpr auto kOffset = static_cast<std::uint32_t>(spv::Decoration::Offset);
constexpr auto kArrayStride = static_cast<std::uint32_t>(spv::Decoration::ArrayStride);
constexpr auto kMatrixStride = static_cast<std::uint32_t>(spv::Decoration::MatrixStride);
constexpr auto kRowMajor = static_cast<std::uint32_t>(spv::Decoration::RowMajor);

struct Semantic {
  std::string name;
  int index = 0;
};

Semantic split_semantic(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  std::size_t end = text.size();
  while (end > 0 && std::isdigit(static_cast<unsigned char>(text[end - 1])) != 0) --end;
  int index = 0;
  for (std::size_t i = end; i < text.size() && index < 1000; ++i) index = index * 10 + (text[i] - '0');
  return {text.substr(0, end), index};
}

std::string builtin_semantic(std::uint32_t builtin) {
  switch (static_cast<spv::BuiltIn>(builtin)) {
    case spv::BuiltIn::Position:
      return "POSITION0";
    case spv::BuiltIn::FragCoord:
      return "VPOS0";
    case spv::BuiltIn::FrontFacing:
      return "VFACE0";
    case spv::BuiltIn::FragDepth:
      return "DEPTH0";
    default:
      return "";
  }
}

}  // namespace

std::string Lowerer::semantic_of(SpvId variable, bool input) const {
  const Decorations& d = m_.decorations(variable);
  if (auto builtin = d.get(kBuiltIn)) return builtin_semantic(*builtin);
  if (!d.semantic.empty()) {
    Semantic s = split_semantic(d.semantic);
    if (s.name == "SV_TARGET") s.name = "COLOR";
    if (s.name == "SV_POSITION") s.name = input && stage_ == vm::Stage::Pixel ? "VPOS" : "POSITION";
    if (s.name == "SV_DEPTH") s.name = "DEPTH";
    return fmt::format("{}{}", s.name, s.index);
  }
  const bool render_target = !input && stage_ == vm::Stage::Pixel;
  return fmt::format("{}{}", render_target ? "COLOR" : "TEXCOORD", d.get(kLocation).value_or(0));
}

void Lowerer::map_interface() {
  for (const SpirvInstruction& i : m_.globals()) {
    const SpirvType& pointer = m_.type(i.type);
    const bool used =
        std::find(m_.interface().begin(), m_.interface().end(), i.result) != m_.interface().end();
    switch (static_cast<spv::StorageClass>(pointer.storage)) {
      case spv::StorageClass::Input:
        if (used) map_input(i.result);
        break;
      case spv::StorageClass::Output:
        if (used) map_output(i.result);
        declare(i);
        break;
      case spv::StorageClass::Private:
        declare(i);
        break;
      default:
        break;
    }
  }
  // $Global owns c0, so that register(cN) means what it says; further blocks follow by binding.
  std::vector<SpirvInstruction> blocks, textures;
  for (const SpirvInstruction& i : m_.globals()) {
    const SpirvType& pointer = m_.type(i.type);
    const auto storage = static_cast<spv::StorageClass>(pointer.storage);
    if (storage == spv::StorageClass::UniformConstant) textures.push_back(i);
    if ((storage == spv::StorageClass::Uniform || storage == spv::StorageClass::PushConstant) &&
        m_.type(pointer.element).kind == SpirvType::Kind::Struct)
      blocks.push_back(i);
  }
  const auto rank = [&](const SpirvInstruction& i) {
    const SpvId type = m_.type(i.type).element;
    const bool global =
        m_.name(type).starts_with("$Global") || m_.name(type).starts_with("gl_DefaultUniformBlock");
    return std::pair(!global, m_.decorations(i.result).get(kBinding).value_or(0));
  };
  std::stable_sort(blocks.begin(), blocks.end(),
                   [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  for (const SpirvInstruction& i : blocks) map_uniform_block(i.result);

  std::stable_sort(textures.begin(), textures.end(), [&](const auto& a, const auto& b) {
    return m_.decorations(a.result).get(kBinding).value_or(0) <
           m_.decorations(b.result).get(kBinding).value_or(0);
  });
  for (const SpirvInstruction& i : textures) map_sampler(i.result);
}

void Lowerer::check_interface_size(SpvId variable, SpvId type) const {
  if (m_.scalar_count(type) > kMaxInterfaceScalars)
    throw UserError(fmt::format("'{}' is larger than any file of inputs or outputs", m_.name(variable)),
                    fmt::format("the limit is {} numbers", kMaxInterfaceScalars));
}

void Lowerer::map_input(SpvId variable) {
  const SpvId type = m_.type(m_.definition(variable)->type).element;
  check_interface_size(variable, type);
  std::vector<InterfaceSlot> slots;
  const std::string first = semantic_of(variable, true);
  Semantic s = split_semantic(first);
  const std::uint8_t lane0 = static_cast<std::uint8_t>(m_.decorations(variable).get(kComponent).value_or(0));
  const std::function<void(SpvId)> add = [&](SpvId t) {
    const SpirvType& ty = m_.type(t);
    switch (ty.kind) {
      case SpirvType::Kind::Struct:
        for (SpvId member : ty.members) add(member);
        return;
      case SpirvType::Kind::Array:
      case SpirvType::Kind::Matrix:
        for (std::uint32_t k = 0; k < ty.count; ++k) add(ty.element);
        return;
      default:
        break;
    }
    if (first.empty()) {
      for (std::uint32_t k = 0; k < m_.scalar_count(t); ++k) slots.push_back({});
      return;
    }
    const std::string semantic = fmt::format("{}{}", s.name, s.index++);
    auto& inputs = out_.symbols.inputs;
    auto it =
        std::find_if(inputs.begin(), inputs.end(), [&](const auto& in) { return in.semantic == semantic; });
    if (it == inputs.end()) it = inputs.insert(inputs.end(), {semantic, 0});
    for (std::uint32_t k = 0; k < m_.scalar_count(t); ++k)
      slots.push_back({static_cast<int>(it - inputs.begin()), static_cast<std::uint8_t>((lane0 + k) & 3)});
  };
  add(type);
  inputs_[variable] = std::move(slots);
}

void Lowerer::map_output(SpvId variable) {
  const SpvId type = m_.type(m_.definition(variable)->type).element;
  check_interface_size(variable, type);
  std::vector<InterfaceSlot> slots;
  const std::uint8_t lane0 = static_cast<std::uint8_t>(m_.decorations(variable).get(kComponent).value_or(0));
  const auto add = [&](SpvId t, const std::string& semantic) {
    if (semantic.empty()) {
      for (std::uint32_t k = 0; k < m_.scalar_count(t); ++k) slots.push_back({});
      return;
    }
    auto& outputs = out_.symbols.outputs;
    auto it =
        std::find_if(outputs.begin(), outputs.end(), [&](const auto& o) { return o.semantic == semantic; });
    if (it == outputs.end()) it = outputs.insert(outputs.end(), {semantic, 0});
    for (std::uint32_t k = 0; k < m_.scalar_count(t); ++k)
      slots.push_back({static_cast<int>(it - outputs.begin()), static_cast<std::uint8_t>((lane0 + k) & 3)});
  };
  const SpirvType& ty = m_.type(type);
  if (ty.kind == SpirvType::Kind::Struct) {  // gl_PerVertex and interface blocks
    int location = static_cast<int>(m_.decorations(variable).get(kLocation).value_or(0));
    for (std::uint32_t k = 0; k < ty.members.size(); ++k) {
      const Decorations& d = m_.member_decorations(type, k);
      std::string semantic = fmt::format("{}{}", stage_ == vm::Stage::Pixel ? "COLOR" : "TEXCOORD",
                                         d.get(kLocation).value_or(static_cast<std::uint32_t>(location)));
      if (auto builtin = d.get(kBuiltIn))
        semantic = builtin_semantic(*builtin);
      else
        ++location;
      add(ty.members[k], semantic);
    }
  } else {
    Semantic s = split_semantic(semantic_of(variable, false));
    const bool repeated = ty.kind == SpirvType::Kind::Array || ty.kind == SpirvType::Kind::Matrix;
    const std::uint32_t count = repeated ? std::min(ty.count, 64u) : 1;
    for (std::uint32_t k = 0; k < count; ++k)
      add(repeated ? ty.element : type, s.name.empty() ? "" : fmt::format("{}{}", s.name, s.index++));
  }
  slots.resize(m_.scalar_count(type));
  outputs_[variable] = std::move(slots);
}

std::uint32_t Lowerer::bytes_of(SpvId type, std::uint32_t matrix_stride, bool row_major) const {
  const SpirvType& t = m_.type(type);
  const auto at_most = [](std::uint64_t bytes) {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(bytes, 1u << 30));
  };
  spend(1);
  switch (t.kind) {
    case SpirvType::Kind::Vector:
      return 4 * t.count;
    case SpirvType::Kind::Matrix: {
      const std::uint64_t rows = m_.type(t.element).count;
      return at_most(row_major ? (rows - 1) * matrix_stride + 4 * t.count
                               : (std::uint64_t{t.count} - 1) * matrix_stride + 4 * rows);
    }
    case SpirvType::Kind::Array: {
      const std::uint32_t stride = m_.decorations(type).get(kArrayStride).value_or(16);
      const std::uint64_t bytes =
          (std::max(t.count, 1u) - 1) * std::uint64_t{stride} + bytes_of(t.element, matrix_stride, row_major);
      return at_most(bytes);
    }
    case SpirvType::Kind::Struct: {
      std::uint64_t end = 0;
      for (std::uint32_t k = 0; k < t.members.size(); ++k) {
        const Decorations& d = m_.member_decorations(type, k);
        end = std::max<std::uint64_t>(
            end, std::uint64_t{d.get(kOffset).value_or(0)} +
                     bytes_of(t.members[k], d.get(kMatrixStride).value_or(16), d.get(kRowMajor).has_value()));
      }
      return at_most(end);
    }
    default:
      return 4;
  }
}

void Lowerer::map_uniform_block(SpvId variable) {
  const SpvId type = m_.type(m_.definition(variable)->type).element;
  const SpirvType& block = m_.type(type);
  if (block.scalars > 4 * static_cast<std::uint32_t>(kMaxUniformRegisters))
    throw UserError(fmt::format("the uniform block '{}' holds {} numbers", m_.name(type), block.scalars),
                    fmt::format("the limit is c{}", kMaxUniformRegisters - 1));
  int& next = out_.symbols.uniform_count;
  const int base = next;

  // Every member starts in a register of its own. A member whose offset is not where packing would have put
  // it was placed by register(cN) and stays there; the others fill up in declaration order around those.
  struct Member {
    std::uint32_t index, offset, bytes;
    bool placed;
    int registers;
  };
  std::vector<Member> members;
  std::uint32_t packed_end = 0;
  for (std::uint32_t k = 0; k < block.members.size(); ++k) {
    const Decorations& d = m_.member_decorations(type, k);
    const std::uint32_t offset = d.get(kOffset).value_or(0);
    const std::uint32_t bytes =
        bytes_of(block.members[k], d.get(kMatrixStride).value_or(16), d.get(kRowMajor).has_value());
    const bool placed = offset % 16 == 0 && (offset > (packed_end + 15) / 16 * 16 || offset < packed_end);
    members.push_back({k, offset, bytes, placed, static_cast<int>((bytes + 15) / 16)});
    if (offset + std::uint64_t{bytes} > 16 * std::uint64_t{kMaxUniformRegisters})
      throw UserError(fmt::format("uniform '{}' needs registers up to c{}", m_.member_name(type, k),
                                  (offset + std::uint64_t{bytes} - 1) / 16),
                      fmt::format("the limit is c{}", kMaxUniformRegisters - 1));
    packed_end = offset + bytes;
  }
  std::vector<std::pair<int, int>> taken;  // [begin, end)
  for (const Member& m : members)
    if (m.placed || (m.offset % 16 == 0 && explicit_registers_.contains(m_.member_name(type, m.index))))
      taken.emplace_back(base + static_cast<int>(m.offset / 16),
                         base + static_cast<int>(m.offset / 16) + m.registers);
  int cursor = base;
  for (Member& m : members) {
    const bool fixed =
        m.placed || (m.offset % 16 == 0 && explicit_registers_.contains(m_.member_name(type, m.index)));
    int reg = base + static_cast<int>(m.offset / 16);
    if (!fixed) {
      reg = cursor;
      for (bool moved = true; moved;) {
        moved = false;
        for (auto [begin, end] : taken)
          if (reg < end && reg + m.registers > begin) {
            reg = end;
            moved = true;
          }
      }
      cursor = reg + m.registers;
    }
    next = std::max(next, reg + m.registers);
    if (next > kMaxUniformRegisters)
      throw UserError(
          fmt::format("uniform '{}' needs registers up to c{}", m_.member_name(type, m.index), next - 1),
          fmt::format("the limit is c{}", kMaxUniformRegisters - 1));
    member_register_[{variable, m.index}] = reg;
    const Decorations& d = m_.member_decorations(type, m.index);
    name_uniform(m_.member_name(type, m.index), block.members[m.index], reg, 0,
                 d.get(kMatrixStride).value_or(16), d.get(kRowMajor).has_value());
  }
}

void Lowerer::name_uniform(const std::string& name, SpvId type, int reg, std::uint32_t byte,
                           std::uint32_t matrix_stride, bool row_major) {
  const SpirvType& t = m_.type(type);
  if (t.kind == SpirvType::Kind::Struct) {
    for (std::uint32_t k = 0; k < t.members.size(); ++k) {
      const Decorations& d = m_.member_decorations(type, k);
      name_uniform(name + "." + m_.member_name(type, k), t.members[k], reg, byte + d.get(kOffset).value_or(0),
                   d.get(kMatrixStride).value_or(16), d.get(kRowMajor).has_value());
    }
    return;
  }
  SpvId leaf = type;
  while (m_.type(leaf).kind == SpirvType::Kind::Array) leaf = m_.type(leaf).element;
  if (t.kind == SpirvType::Kind::Array && m_.type(leaf).kind == SpirvType::Kind::Struct) {
    const std::uint32_t stride = m_.decorations(type).get(kArrayStride).value_or(16);
    for (std::uint32_t k = 0; k < t.count; ++k)
      name_uniform(fmt::format("{}[{}]", name, k), t.element, reg, byte + k * stride, matrix_stride,
                   row_major);
    return;
  }
  const SpirvType& l = m_.type(leaf);
  vm::UniformSymbol symbol;
  symbol.name = name;
  symbol.reg = reg + static_cast<int>(byte / 16);
  symbol.component = static_cast<int>(byte % 16 / 4);
  symbol.registers = static_cast<int>((bytes_of(type, matrix_stride, row_major) + 15) / 16);
  symbol.components = 1;
  if (l.kind == SpirvType::Kind::Vector) symbol.components = static_cast<int>(l.count);
  if (l.kind == SpirvType::Kind::Matrix)
    symbol.components = static_cast<int>(row_major ? l.count : m_.type(l.element).count);
  out_.symbols.uniforms.push_back(std::move(symbol));
}

void Lowerer::map_sampler(SpvId variable) {
  const SpirvInstruction& definition = *m_.definition(variable);
  SpvId type = m_.type(definition.type).element;
  if (m_.type(type).kind == SpirvType::Kind::Sampler) return;  // the texture carries the name
  if (m_.type(type).kind == SpirvType::Kind::SampledImage) type = m_.type(type).element;
  const SpirvType& image = m_.type(type);
  if (image.kind != SpirvType::Kind::Image) return;  // arrays of textures: refused where they are used
  vm::SamplerSymbol symbol;
  symbol.name = m_.name(variable);
  switch (static_cast<spv::Dim>(image.dimension)) {
    case spv::Dim::Dim1D:
    case spv::Dim::Dim2D:
      symbol.dimension = vm::SamplerDimension::Tex2D;
      break;
    case spv::Dim::Dim3D:
      symbol.dimension = vm::SamplerDimension::Tex3D;
      break;
    case spv::Dim::Cube:
      symbol.dimension = vm::SamplerDimension::TexCube;
      break;
    default:
      return;
  }
  if (image.arrayed || image.multisampled) return;
  if (out_.symbols.samplers.size() >= 256) throw UserError("the shader declares more than 256 textures");
  samplers_[variable] = static_cast<std::uint32_t>(out_.symbols.samplers.size());
  out_.symbols.samplers.push_back(std::move(symbol));
}

}  // namespace aluminate::compiler
