#include "shading/compiler/spirv_module.hpp"

#include "platform/host/error.hpp"

#define SPV_ENABLE_UTILITY_CODE
#include <spirv/unified1/spirv.hpp11>

#include <glslang/SPIRV/doc.h>

#include <algorithm>
#include <array>

namespace aluminate::compiler {
namespace {

// A literal string: UTF-8, four bytes a word, little end first, zero terminated.
std::string literal_string(std::span<const std::uint32_t> words) {
  std::string text;
  for (std::uint32_t word : words)
    for (int byte = 0; byte < 4; ++byte) {
      const char c = static_cast<char>(word >> (8 * byte) & 0xff);
      if (c == 0) return text;
      text += c;
    }
  return text;
}

std::size_t string_words(std::span<const std::uint32_t> words) {
  return literal_string(words).size() / 4 + 1;
}

bool is_terminator(spv::Op op) {
  switch (op) {
    case spv::Op::OpBranch:
    case spv::Op::OpBranchConditional:
    case spv::Op::OpSwitch:
    case spv::Op::OpReturn:
    case spv::Op::OpReturnValue:
    case spv::Op::OpKill:
    case spv::Op::OpTerminateInvocation:
    case spv::Op::OpUnreachable:
      return true;
    default:
      return false;
  }
}

}  // namespace

const SpirvInstruction* SpirvBlock::merge() const {
  if (code.size() < 2) return nullptr;
  const SpirvInstruction& i = code[code.size() - 2];
  const auto op = static_cast<spv::Op>(i.op);
  return op == spv::Op::OpSelectionMerge || op == spv::Op::OpLoopMerge ? &i : nullptr;
}

SpirvModule::SpirvModule(std::vector<std::uint32_t> words, const std::string& entry, vm::Stage stage)
    : words_(std::move(words)) {
  decode(entry, stage);
}

void SpirvModule::decode(const std::string& entry, vm::Stage stage) {
  const auto model = stage == vm::Stage::Pixel ? spv::ExecutionModel::Fragment : spv::ExecutionModel::Vertex;
  std::uint32_t main = 0;
  std::string others;
  std::unordered_map<std::uint32_t, std::uint16_t> file_index;
  vm::SourceLine line{};
  std::uint32_t function = 0;
  bool only_kill = false;

  for (std::size_t at = 5; at < words_.size();) {
    const std::size_t size = words_[at] >> 16;
    const auto op = static_cast<spv::Op>(words_[at] & 0xffff);
    SpirvInstruction i;
    i.op = static_cast<std::uint16_t>(op);
    bool has_result = false, has_type = false;
    spv::HasResultAndType(op, &has_result, &has_type);
    std::size_t first = at + 1;
    if (has_type) i.type = words_[first++];
    if (has_result) i.result = words_[first++];
    i.operands = std::span(words_).subspan(first, at + size - first);
    i.line = line;
    at += size;

    switch (op) {
      case spv::Op::OpString:
        strings_[i.result] = literal_string(i.operands);
        break;
      case spv::Op::OpExtInstImport:
        imports_[i.result] = literal_string(i.operands);
        break;
      case spv::Op::OpSource:
        is_hlsl_ = i.operands[0] == static_cast<std::uint32_t>(spv::SourceLanguage::HLSL);
        break;
      case spv::Op::OpName:
        names_[i.operands[0]] = literal_string(i.operands.subspan(1));
        break;
      case spv::Op::OpMemberName:
        member_names_[{i.operands[0], i.operands[1]}] = literal_string(i.operands.subspan(2));
        break;
      case spv::Op::OpEntryPoint: {
        const std::string name = literal_string(i.operands.subspan(2));
        if (name == entry && i.operands[0] == static_cast<std::uint32_t>(model)) {
          main = i.operands[1];
          const auto ids = i.operands.subspan(2 + string_words(i.operands.subspan(2)));
          interface_.assign(ids.begin(), ids.end());
        } else {
          others += (others.empty() ? "" : ", ") + name;
        }
        break;
      }
      case spv::Op::OpLine: {
        const auto [it, fresh] =
            file_index.try_emplace(i.operands[0], static_cast<std::uint16_t>(files_.size()));
        if (fresh) files_.push_back(strings_[i.operands[0]]);
        line = {it->second, static_cast<std::uint16_t>(std::min<std::uint32_t>(i.operands[2], 0xffff)),
                i.operands[1]};
        break;
      }
      case spv::Op::OpFunction:
        function = i.result;
        only_kill = true;
        line = {};
        definitions_[i.result] = i;
        break;
      case spv::Op::OpFunctionEnd:
        kill_functions_.erase(function);
        if (only_kill) kill_functions_[function] = true;
        function = 0;
        break;
      default:
        if (i.result != 0) definitions_[i.result] = i;
        add_type(i);
        add_decoration(i);
        if (function == 0 && op == spv::Op::OpVariable) globals_.push_back(i);
        if (function != 0 && op != spv::Op::OpLabel && op != spv::Op::OpKill &&
            op != spv::Op::OpTerminateInvocation && op != spv::Op::OpNoLine)
          only_kill = false;
        if (function != main || function == 0) break;
        if (op == spv::Op::OpLabel) {
          block_index_[i.result] = blocks_.size();
          blocks_.push_back({i.result, {}});
        } else if (op != spv::Op::OpNoLine && op != spv::Op::OpNop && !blocks_.empty() &&
                   (blocks_.back().code.empty() ||
                    !is_terminator(static_cast<spv::Op>(blocks_.back().code.back().op)))) {
          blocks_.back().code.push_back(i);
        }
    }
  }
  if (main == 0 || blocks_.empty())
    throw UserError(fmt::format("no {} entry point '{}' in the module",
                                stage == vm::Stage::Pixel ? "fragment" : "vertex", entry),
                    others.empty() ? "" : "it has: " + others);
}

void SpirvModule::add_type(const SpirvInstruction& i) {
  using Kind = SpirvType::Kind;
  SpirvType t;
  const auto o = i.operands;
  switch (static_cast<spv::Op>(i.op)) {
    case spv::Op::OpTypeVoid:
      t.kind = Kind::Void;
      break;
    case spv::Op::OpTypeBool:
      t.kind = Kind::Bool;
      break;
    case spv::Op::OpTypeInt:
      t.kind = o[0] == 32 ? Kind::Int : Kind::Other;
      t.is_signed = o[1] != 0;
      break;
    case spv::Op::OpTypeFloat:
      t.kind = Kind::Float;
      break;  // 16, 32, 64 bits: one number system
    case spv::Op::OpTypeVector:
      t.kind = Kind::Vector;
      t.element = o[0];
      t.count = o[1];
      break;
    case spv::Op::OpTypeMatrix:
      t.kind = Kind::Matrix;
      t.element = o[0];
      t.count = o[1];
      break;
    case spv::Op::OpTypeArray:
      t.kind = Kind::Array;
      t.element = o[0];
      t.count = static_cast<std::uint32_t>(integer(o[1]).value_or(0));
      break;
    case spv::Op::OpTypeStruct:
      t.kind = Kind::Struct;
      t.members.assign(o.begin(), o.end());
      break;
    case spv::Op::OpTypePointer:
      t.kind = Kind::Pointer;
      t.element = o[1];
      t.storage = o[0];
      break;
    case spv::Op::OpTypeImage:
      t.kind = Kind::Image;
      t.dimension = o[1];
      t.depth = o[2] == 1;
      t.arrayed = o[3] != 0;
      t.multisampled = o[4] != 0;
      break;
    case spv::Op::OpTypeSampler:
      t.kind = Kind::Sampler;
      break;
    case spv::Op::OpTypeSampledImage:
      t.kind = Kind::SampledImage;
      t.element = o[0];
      break;
    case spv::Op::OpTypeRuntimeArray:
      t.element = o[0];
      break;
    default:
      return;
  }
  t.scalars = scalars_of(t);
  types_[i.result] = std::move(t);
}

void SpirvModule::add_decoration(const SpirvInstruction& i) {
  const auto o = i.operands;
  switch (static_cast<spv::Op>(i.op)) {
    case spv::Op::OpDecorate:
      decorations_[o[0]].value[o[1]] = o.size() > 2 ? o[2] : 0;
      break;
    case spv::Op::OpMemberDecorate:
      member_decorations_[{o[0], o[1]}].value[o[2]] = o.size() > 3 ? o[3] : 0;
      break;
    case spv::Op::OpDecorateString:
      if (static_cast<spv::Decoration>(o[1]) == spv::Decoration::UserSemantic)
        decorations_[o[0]].semantic = literal_string(o.subspan(2));
      break;
    case spv::Op::OpMemberDecorateString:
      if (static_cast<spv::Decoration>(o[2]) == spv::Decoration::UserSemantic)
        member_decorations_[{o[0], o[1]}].semantic = literal_string(o.subspan(3));
      break;
    default:
      break;
  }
}

const SpirvType& SpirvModule::type(std::uint32_t id) const {
  static const SpirvType other;
  const auto it = types_.find(id);
  return it == types_.end() ? other : it->second;
}

// Counted once, when the type is declared: types nest in each other, so counting on demand could take
// exponential time.
std::uint32_t SpirvModule::scalars_of(const SpirvType& t) const {
  std::uint64_t n = 1;
  switch (t.kind) {
    case SpirvType::Kind::Vector:
    case SpirvType::Kind::Matrix:
    case SpirvType::Kind::Array:
      n = std::uint64_t{t.count} * scalar_count(t.element);
      break;
    case SpirvType::Kind::Struct:
      n = 0;
      for (const std::uint32_t m : t.members) n += scalar_count(m);  // < 2^16 members of at most 2^30 each
      break;
    case SpirvType::Kind::Void:
      n = 0;
      break;
    default:
      break;
  }
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(n, kManyScalars));
}

std::uint32_t SpirvModule::scalar_offset(std::uint32_t type_id, std::uint32_t i) const {
  const SpirvType& t = type(type_id);
  if (t.kind != SpirvType::Kind::Struct) return i * scalar_count(t.element);
  std::uint32_t n = 0;
  for (std::uint32_t m = 0; m < i; ++m) n += scalar_count(t.members[m]);
  return n;
}

std::uint32_t SpirvModule::member_type(std::uint32_t type_id, std::uint32_t i) const {
  const SpirvType& t = type(type_id);
  return t.kind == SpirvType::Kind::Struct ? t.members[i] : t.element;
}

const SpirvInstruction* SpirvModule::definition(std::uint32_t id) const {
  auto it = definitions_.find(id);
  return it == definitions_.end() ? nullptr : &it->second;
}

std::string SpirvModule::name(std::uint32_t id) const {
  auto it = names_.find(id);
  return it == names_.end() ? "" : it->second;
}

std::string SpirvModule::member_name(std::uint32_t type_id, std::uint32_t member) const {
  auto it = member_names_.find({type_id, member});
  return it == member_names_.end() || it->second.empty() ? fmt::format("member{}", member) : it->second;
}

const Decorations& SpirvModule::decorations(std::uint32_t id) const {
  static const Decorations none;
  auto it = decorations_.find(id);
  return it == decorations_.end() ? none : it->second;
}

const Decorations& SpirvModule::member_decorations(std::uint32_t type_id, std::uint32_t member) const {
  static const Decorations none;
  auto it = member_decorations_.find({type_id, member});
  return it == member_decorations_.end() ? none : it->second;
}

std::optional<std::int64_t> SpirvModule::integer(std::uint32_t id) const {
  const SpirvInstruction* i = definition(id);
  if (i == nullptr) return std::nullopt;
  switch (static_cast<spv::Op>(i->op)) {
    case spv::Op::OpConstant:
    case spv::Op::OpSpecConstant: {
      auto t = types_.find(i->type);
      if (t == types_.end() || t->second.kind != SpirvType::Kind::Int) return std::nullopt;
      return t->second.is_signed ? std::int64_t{static_cast<std::int32_t>(i->operands[0])}
                                 : std::int64_t{i->operands[0]};
    }
    case spv::Op::OpConstantNull:
      return 0;
    default:
      return std::nullopt;
  }
}

std::string SpirvModule::import_name(std::uint32_t id) const {
  auto it = imports_.find(id);
  return it == imports_.end() ? "" : it->second;
}

std::string spirv_op_name(std::uint32_t op) {
  const std::string name = spv::OpcodeString(static_cast<int>(op));
  return name.starts_with("Op") && name.find('?') == std::string::npos ? name : fmt::format("opcode {}", op);
}

std::string glsl_std_name(std::uint32_t instruction) {
  static constexpr std::array kNames = {"Bad",
                                        "Round",
                                        "RoundEven",
                                        "Trunc",
                                        "FAbs",
                                        "SAbs",
                                        "FSign",
                                        "SSign",
                                        "Floor",
                                        "Ceil",
                                        "Fract",
                                        "Radians",
                                        "Degrees",
                                        "Sin",
                                        "Cos",
                                        "Tan",
                                        "Asin",
                                        "Acos",
                                        "Atan",
                                        "Sinh",
                                        "Cosh",
                                        "Tanh",
                                        "Asinh",
                                        "Acosh",
                                        "Atanh",
                                        "Atan2",
                                        "Pow",
                                        "Exp",
                                        "Log",
                                        "Exp2",
                                        "Log2",
                                        "Sqrt",
                                        "InverseSqrt",
                                        "Determinant",
                                        "MatrixInverse",
                                        "Modf",
                                        "ModfStruct",
                                        "FMin",
                                        "UMin",
                                        "SMin",
                                        "FMax",
                                        "UMax",
                                        "SMax",
                                        "FClamp",
                                        "UClamp",
                                        "SClamp",
                                        "FMix",
                                        "IMix",
                                        "Step",
                                        "SmoothStep",
                                        "Fma",
                                        "Frexp",
                                        "FrexpStruct",
                                        "Ldexp",
                                        "PackSnorm4x8",
                                        "PackUnorm4x8",
                                        "PackSnorm2x16",
                                        "PackUnorm2x16",
                                        "PackHalf2x16",
                                        "PackDouble2x32",
                                        "UnpackSnorm2x16",
                                        "UnpackUnorm2x16",
                                        "UnpackHalf2x16",
                                        "UnpackSnorm4x8",
                                        "UnpackUnorm4x8",
                                        "UnpackDouble2x32",
                                        "Length",
                                        "Distance",
                                        "Cross",
                                        "Normalize",
                                        "FaceForward",
                                        "Reflect",
                                        "Refract",
                                        "FindILsb",
                                        "FindSMsb",
                                        "FindUMsb",
                                        "InterpolateAtCentroid",
                                        "InterpolateAtSample",
                                        "InterpolateAtOffset",
                                        "NMin",
                                        "NMax",
                                        "NClamp"};
  return instruction < kNames.size() ? kNames[instruction]
                                     : fmt::format("GLSL.std.450 instruction {}", instruction);
}

}  // namespace aluminate::compiler
