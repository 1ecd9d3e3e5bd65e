// A validated SPIR-V module, decoded: types, constants, names, decorations and the blocks of the entry
// function. Opcodes and enumerants are the numbers of the SPIR-V specification; spirv.hpp11 names them in the
// .cpp files. Never sees an invalid module: validate_spirv() runs first.
#pragma once

#include "shading/vm/program.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace aluminate::compiler {

struct SpirvInstruction {
  std::uint16_t op = 0;
  std::uint32_t type = 0, result = 0;       // ids, 0 = none
  std::span<const std::uint32_t> operands;  // words after type and result
  vm::SourceLine line{};
};

struct SpirvBlock {
  std::uint32_t label = 0;
  std::vector<SpirvInstruction> code;  // ends with the terminator; the merge instruction stands before it
  const SpirvInstruction& terminator() const { return code.back(); }
  const SpirvInstruction* merge() const;  // OpSelectionMerge or OpLoopMerge
};

struct SpirvType {
  enum class Kind : std::uint8_t {
    Void,
    Bool,
    Int,
    Float,
    Vector,
    Matrix,
    Array,
    Struct,
    Pointer,
    Image,
    Sampler,
    SampledImage,
    Other
  };
  Kind kind = Kind::Other;
  bool is_signed = false;
  std::uint32_t element = 0;           // vector, matrix (column), array, pointer, sampled image
  std::uint32_t count = 0;             // vector, matrix columns, array length
  std::vector<std::uint32_t> members;  // struct
  std::uint32_t storage = 0;           // pointer
  std::uint32_t dimension = 0;         // image: spv::Dim
  std::uint32_t scalars = 1;           // in a value of the type, at most kManyScalars
  bool arrayed = false, depth = false, multisampled = false;
};

struct Decorations {
  std::map<std::uint32_t, std::uint32_t> value;  // decoration -> first literal (0 when it has none)
  std::string semantic;                          // UserSemantic
  std::optional<std::uint32_t> get(std::uint32_t decoration) const {
    auto it = value.find(decoration);
    return it == value.end() ? std::nullopt : std::optional(it->second);
  }
};

class SpirvModule {
 public:
  /// Throws UserError when the entry point does not exist or is not of the stage.
  SpirvModule(std::vector<std::uint32_t> words, const std::string& entry, vm::Stage stage);

  /// Kind::Other for what is no type of a value.
  const SpirvType& type(std::uint32_t id) const;
  /// Scalars in a value of the type, in memory order; kManyScalars stands for that many and more.
  std::uint32_t scalar_count(std::uint32_t type_id) const { return type(type_id).scalars; }
  static constexpr std::uint32_t kManyScalars = 1u << 30;
  /// Index of the first scalar of member or element i.
  std::uint32_t scalar_offset(std::uint32_t type_id, std::uint32_t i) const;
  std::uint32_t member_type(std::uint32_t type_id, std::uint32_t i) const;

  const SpirvInstruction* definition(std::uint32_t id) const;
  std::string name(std::uint32_t id) const;
  std::string member_name(std::uint32_t type_id, std::uint32_t member) const;
  const Decorations& decorations(std::uint32_t id) const;
  const Decorations& member_decorations(std::uint32_t type_id, std::uint32_t member) const;

  /// Value of an integer constant.
  std::optional<std::int64_t> integer(std::uint32_t id) const;

  std::span<const std::uint32_t> interface() const { return interface_; }
  const std::vector<SpirvInstruction>& globals() const { return globals_; }  // OpVariable at module scope
  const std::vector<SpirvBlock>& blocks() const { return blocks_; }          // entry function, in order
  const SpirvBlock& block(std::uint32_t label) const { return blocks_[block_index_.at(label)]; }
  bool is_hlsl() const { return is_hlsl_; }  // OpSource says so
  const std::vector<std::string>& files() const { return files_; }
  /// True for a function whose only effect is OpKill or OpTerminateInvocation.
  bool kills(std::uint32_t function) const { return kill_functions_.contains(function); }
  /// Extended instruction set imported under the id ("GLSL.std.450").
  std::string import_name(std::uint32_t id) const;

 private:
  void decode(const std::string& entry, vm::Stage stage);
  void add_type(const SpirvInstruction& i);
  std::uint32_t scalars_of(const SpirvType& t) const;
  void add_decoration(const SpirvInstruction& i);

  std::vector<std::uint32_t> words_;
  std::unordered_map<std::uint32_t, SpirvType> types_;
  std::unordered_map<std::uint32_t, SpirvInstruction> definitions_;
  std::unordered_map<std::uint32_t, std::string> names_, strings_, imports_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::string> member_names_;
  std::unordered_map<std::uint32_t, Decorations> decorations_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Decorations> member_decorations_;
  std::vector<std::uint32_t> interface_;
  std::vector<SpirvInstruction> globals_;
  std::vector<SpirvBlock> blocks_;
  std::unordered_map<std::uint32_t, std::size_t> block_index_;
  std::unordered_map<std::uint32_t, bool> kill_functions_;
  std::vector<std::string> files_;
  bool is_hlsl_ = false;
};

/// "OpImageFetch", and "Determinant" for GLSL.std.450 instruction numbers.
std::string spirv_op_name(std::uint32_t op);
std::string glsl_std_name(std::uint32_t instruction);

}  // namespace aluminate::compiler
