#include "shading/compiler/spirv_passes.hpp"

#include "platform/host/error.hpp"

#include <spirv-tools/libspirv.hpp>
#include <spirv-tools/optimizer.hpp>
#define SPV_ENABLE_UTILITY_CODE
#include <spirv/unified1/spirv.hpp11>

#include <algorithm>
#include <unordered_map>

namespace aluminate::compiler {
namespace {

constexpr spv_target_env kEnvironment =
    SPV_ENV_UNIVERSAL_1_6;  // whatever version the module declares, without API rules

// Calls f(opcode, words of the instruction) for each instruction of a module.
template <class Words, class Function>
void for_each_instruction(Words& words, Function f) {
  for (std::size_t at = 5; at < words.size();) {
    const std::size_t size = words[at] >> 16;
    if (size == 0 || at + size > words.size()) return;
    f(static_cast<spv::Op>(words[at] & 0xffff), &words[at], size);
    at += size;
  }
}

spvtools::ValidatorOptions& relax(spvtools::ValidatorOptions& options) {
  options.SetScalarBlockLayout(true);  // HLSL packs more tightly than std140
  options.SetSkipBlockLayout(true);
  return options;
}

}  // namespace

void validate_spirv(const std::vector<std::uint32_t>& words, const std::string& file) {
  spvtools::SpirvTools tools(kEnvironment);
  std::string message;
  tools.SetMessageConsumer(
      [&](spv_message_level_t level, const char*, const spv_position_t&, const char* text) {
        if (level <= SPV_MSG_ERROR && message.empty()) message = text;
      });
  spvtools::ValidatorOptions options;
  if (words.size() >= 5 && tools.Validate(words.data(), words.size(), relax(options))) return;
  if (words.size() < 5) message = "shorter than a module header";
  if (const auto end = message.find('\n'); end != std::string::npos) message.resize(end);
  throw UserError(SourcePlace{file, 0, 0}, "not a valid SPIR-V module: " + message,
                  "spirv-val gives the full report");
}

std::vector<std::uint32_t> specialise(const std::vector<std::uint32_t>& words,
                                      const std::map<std::string, double>& values, const std::string& file) {
  struct Constant {
    std::uint32_t spec_id = 0;
    std::string name;
    bool is_float = false, is_bool = false;
  };
  std::unordered_map<std::uint32_t, std::uint32_t> spec_ids;
  std::unordered_map<std::uint32_t, std::string> names;
  std::unordered_map<std::uint32_t, bool> float_types;
  std::vector<Constant> constants;
  bool any = false;
  for_each_instruction(words, [&](spv::Op op, const std::uint32_t* w, std::size_t size) {
    switch (op) {
      case spv::Op::OpName:
        names[w[1]] = std::string(reinterpret_cast<const char*>(w + 2),
                                  strnlen(reinterpret_cast<const char*>(w + 2), 4 * (size - 2)));
        break;
      case spv::Op::OpDecorate:
        if (static_cast<spv::Decoration>(w[2]) == spv::Decoration::SpecId) spec_ids[w[1]] = w[3];
        break;
      case spv::Op::OpTypeFloat:
        float_types[w[1]] = true;
        break;
      case spv::Op::OpSpecConstant:
      case spv::Op::OpSpecConstantTrue:
      case spv::Op::OpSpecConstantFalse:
        any = true;
        if (spec_ids.contains(w[2]))
          constants.push_back(
              {spec_ids[w[2]], names[w[2]], float_types.contains(w[1]), op != spv::Op::OpSpecConstant});
        break;
      case spv::Op::OpSpecConstantOp:
      case spv::Op::OpSpecConstantComposite:
        any = true;
        break;
      default:
        break;
    }
  });
  std::unordered_map<std::uint32_t, std::string> defaults;
  for (const auto& entry : values) {
    const std::string& key = entry.first;
    const double number = entry.second;
    const auto c = std::find_if(constants.begin(), constants.end(), [&](const Constant& k) {
      return k.name == key || std::to_string(k.spec_id) == key;
    });
    if (c == constants.end()) {
      std::string known;
      for (const Constant& k : constants)
        known += fmt::format("{}{} ({})", known.empty() ? "" : ", ", k.name, k.spec_id);
      throw UserError(SourcePlace{file, 0, 0}, fmt::format("no specialisation constant '{}'", key),
                      known.empty() ? "the shader declares none" : "it declares: " + known);
    }
    defaults[c->spec_id] = c->is_bool    ? (number != 0 ? "true" : "false")
                           : c->is_float ? fmt::format("{:.9g}", number)
                                         : fmt::format("{}", static_cast<long long>(number));
  }
  if (!any) return words;

  spvtools::Optimizer optimizer(kEnvironment);
  std::string message;
  optimizer.SetMessageConsumer(
      [&](spv_message_level_t level, const char*, const spv_position_t&, const char* text) {
        if (level <= SPV_MSG_ERROR && message.empty()) message = text;
      });
  if (!defaults.empty()) optimizer.RegisterPass(spvtools::CreateSetSpecConstantDefaultValuePass(defaults));
  optimizer.RegisterPass(spvtools::CreateFreezeSpecConstantValuePass())
      .RegisterPass(spvtools::CreateFoldSpecConstantOpAndCompositePass())
      .RegisterPass(spvtools::CreateUnifyConstantPass());
  std::vector<std::uint32_t> result;
  if (!optimizer.Run(words.data(), words.size(), &result, spvtools::ValidatorOptions(), true))
    throw UserError(SourcePlace{file, 0, 0}, "the specialisation constants cannot be set: " + message);
  return result;
}

std::vector<std::uint32_t> optimise_spirv(std::vector<std::uint32_t> words, bool full,
                                          const std::string& file) {
  // Unrolling is the lowering's; the optimizer sees no request for it.
  for_each_instruction(words, [](spv::Op op, std::uint32_t* w, std::size_t size) {
    if (op != spv::Op::OpLoopMerge || size != 4) return;
    const bool asked = (w[3] & static_cast<std::uint32_t>(spv::LoopControlMask::Unroll)) != 0;
    w[3] = asked ? kUnrollRequested : static_cast<std::uint32_t>(spv::LoopControlMask::DontUnroll);
  });
  spvtools::Optimizer optimizer(kEnvironment);
  std::string message;
  optimizer.SetMessageConsumer(
      [&](spv_message_level_t level, const char*, const spv_position_t&, const char* text) {
        if (level <= SPV_MSG_ERROR && message.empty()) message = text;
      });
  if (full) {
    optimizer.RegisterPerformancePasses();
    optimizer.RegisterPass(spvtools::CreateCCPPass())
        .RegisterPass(spvtools::CreateDeadBranchElimPass())
        .RegisterPerformancePasses();
  } else {
    optimizer.RegisterPass(spvtools::CreateWrapOpKillPass())
        .RegisterPass(spvtools::CreateMergeReturnPass())
        .RegisterPass(spvtools::CreateInlineExhaustivePass())
        .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass())
        .RegisterPass(spvtools::CreatePrivateToLocalPass())
        .RegisterPass(spvtools::CreateScalarReplacementPass(0))
        .RegisterPass(spvtools::CreateLocalAccessChainConvertPass())
        .RegisterPass(spvtools::CreateSSARewritePass())
        .RegisterPass(spvtools::CreateAggressiveDCEPass());
  }
  std::vector<std::uint32_t> result;
  if (!optimizer.Run(words.data(), words.size(), &result, spvtools::ValidatorOptions(), true))
    throw UserError(SourcePlace{file, 0, 0},
                    "the optimizer refuses the module: " + (message.empty() ? "no reason given" : message));
  return result;
}

}  // namespace aluminate::compiler
