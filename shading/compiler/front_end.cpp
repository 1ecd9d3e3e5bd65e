#include "shading/compiler/front_end.hpp"

#include "platform/host/error.hpp"
#include "shading/compiler/diagnostics.hpp"
#include "shading/compiler/include_search.hpp"
#include "shading/compiler/limits.hpp"
#include "shading/compiler/macro_size.hpp"
#include "shading/compiler/module_size.hpp"
#include "shading/compiler/source_scan.hpp"

#define ENABLE_HLSL   // as Debian builds the library: declares the HLSL half of the interface
#define ENABLE_OPT 1  // and what makes HLSL's output legal
#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>
#include <glslang/SPIRV/SpvTools.h>

#include <map>
#include <memory>
#include <mutex>

namespace aluminate::compiler {
namespace {

constexpr std::size_t kMaxIncludeDepth = 32;

void initialise_glslang() {
  static std::once_flag once;
  std::call_once(once, [] { glslang::InitializeProcess(); });
}

// Hands glslang what find_include() finds, and keeps the texts for the error messages.
class Includer final : public glslang::TShader::Includer {
 public:
  Includer(const Options& options, std::set<std::string>& registers, MacroSize& macros, std::size_t bytes)
      : options_(options), registers_(registers), macros_(macros), bytes_(bytes) {}

  IncludeResult* includeLocal(const char* name, const char* includer, std::size_t depth) override {
    return resolve(name, includer, depth, true);
  }
  IncludeResult* includeSystem(const char* name, const char* includer, std::size_t depth) override {
    return resolve(name, includer, depth, false);
  }
  void releaseInclude(IncludeResult* result) override { delete result; }

  const std::map<std::string, std::string>& texts() const { return texts_; }

 private:
  IncludeResult* failure(const std::string& why) {
    messages_.push_back(std::make_unique<std::string>(why));
    return new IncludeResult("", messages_.back()->data(), messages_.back()->size(), nullptr);
  }

  IncludeResult* found(const std::string& name, std::string content) {
    bytes_ += content.size();
    if (bytes_ > kMaxTotalBytes)
      return failure(fmt::format("the source and its includes are larger than {} bytes", kMaxTotalBytes));
    scan_source(content, name);
    find_explicit_registers(content, registers_);
    macros_.add(content, name);
    const std::string& text = texts_.try_emplace(name, std::move(content)).first->second;
    return new IncludeResult(name, text.data(), text.size(), nullptr);
  }

  IncludeResult* resolve(const std::string& name, const std::string& includer, std::size_t depth,
                         bool local) {
    if (depth > kMaxIncludeDepth)
      return failure(fmt::format("#include nested deeper than {}", kMaxIncludeDepth));
    if (auto file = find_include(options_, name, includer, local))
      return found(file->name, std::move(file->text));
    return local ? nullptr : failure(fmt::format("cannot find include file '{}'", name));
  }

  const Options& options_;
  std::map<std::string, std::string> texts_;
  std::vector<std::unique_ptr<std::string>> messages_;
  std::set<std::string>& registers_;
  MacroSize& macros_;
  std::size_t bytes_;
};

std::string preamble_of(const Options& options) {
  std::string text;
  for (const auto& [name, value] : options.defines) {
    const bool word =
        !name.empty() &&
        name.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_") ==
            std::string::npos &&
        (name[0] < '0' || name[0] > '9');
    if (!word) throw UserError(fmt::format("'{}' is not a name that can be defined", name), "-D NAME=VALUE");
    if (value.find_first_of("\n\r") != std::string::npos)
      throw UserError(fmt::format("the definition of {} spans lines", name));
    text += fmt::format("#define {} {}\n", name, value.empty() ? "1" : value);
  }
  return text;
}

}  // namespace

FrontEndResult run_front_end(const Options& options, Language language, const std::string& text) {
  initialise_glslang();
  const bool hlsl = language == Language::Hlsl;
  const EShLanguage stage = options.stage == vm::Stage::Pixel ? EShLangFragment : EShLangVertex;
  const std::string file = options.source_path.empty() ? "shader" : options.source_path;

  FrontEndResult result;
  scan_source(text, file);
  if (hlsl) {
    refuse_effect_syntax(text, file);
    find_explicit_registers(text, result.explicit_registers);
  }
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw UserError(SourcePlace{file, 0, 0}, "the shader source is empty");

  int messages = EShMsgSpvRules | EShMsgVulkanRules | EShMsgDebugInfo;
  if (hlsl) messages |= EShMsgReadHlsl | EShMsgHlslDX9Compatible | EShMsgHlslOffsets | EShMsgHlslLegalization;

  glslang::TShader shader(stage);
  const char* strings[] = {text.c_str()};
  const int lengths[] = {static_cast<int>(text.size())};
  const char* names[] = {file.c_str()};
  shader.setStringsWithLengthsAndNames(strings, lengths, names, 1);
  const std::string preamble =
      preamble_of(options) + (hlsl ? ""
                                   : "#extension GL_GOOGLE_include_directive : enable\n#extension "
                                     "GL_EXT_control_flow_attributes : enable\n");
  if (!preamble.empty()) shader.setPreamble(preamble.c_str());
  shader.setEntryPoint(hlsl ? options.entry.c_str() : "main");
  shader.setSourceEntryPoint(hlsl ? options.entry.c_str() : "main");
  shader.setEnvInput(hlsl ? glslang::EShSourceHlsl : glslang::EShSourceGlsl, stage, glslang::EShClientVulkan,
                     100);
  shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_1);
  shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_3);
  shader.setAutoMapBindings(true);
  shader.setAutoMapLocations(true);
  shader.setDxPositionW(true);
  if (hlsl) {
    shader.setEnvTargetHlslFunctionality1();
  } else {
    shader.setEnvInputVulkanRulesRelaxed();
    shader.setGlobalUniformBlockName("gl_DefaultUniformBlock");
    shader.setGlobalUniformSet(0);
    shader.setGlobalUniformBinding(0);
  }

  MacroSize macros;
  macros.add(preamble, file);
  macros.add(text, file);
  Includer includer(options, result.explicit_registers, macros, text.size());
  const auto texts = [&](const std::string& name) -> const std::string* {
    if (name == file) return &text;
    const auto it = includer.texts().find(name);
    return it == includer.texts().end() ? nullptr : &it->second;
  };
  const auto limits = *GetDefaultResources();
  if (!shader.parse(&limits, hlsl ? 500 : 450, hlsl ? ENoProfile : ECoreProfile, false, false,
                    static_cast<EShMessages>(messages), includer))
    throw front_end_error(shader.getInfoLog(), file, texts, hlsl);

  glslang::TProgram program;
  program.addShader(&shader);
  if (!program.link(static_cast<EShMessages>(messages)))
    throw front_end_error(program.getInfoLog(), file, texts, hlsl);
  if (!program.mapIO()) throw front_end_error(program.getInfoLog(), file, texts, hlsl);

  glslang::SpvOptions spv_options;
  spv_options.generateDebugInfo = true;
  spv_options.disableOptimizer = true;
  spv::SpvBuildLogger logger;
  glslang::GlslangToSpv(*program.getIntermediate(stage), result.spirv, &logger, &spv_options);
  if (const std::string log = logger.getAllMessages();
      result.spirv.empty() || log.find("ERROR") != std::string::npos)
    throw front_end_error(log, file, texts, hlsl);
  check_module_size(result.spirv, file);
  if (hlsl) {  // needs the legalisation passes
    spv_options.disableOptimizer = false;
    glslang::SpirvToolsTransform(*program.getIntermediate(stage), result.spirv, &logger, &spv_options);
  }
  return result;
}

}  // namespace aluminate::compiler
