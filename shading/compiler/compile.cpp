#include "shading/compiler/compile.hpp"

#include "platform/host/deep_stack.hpp"
#include "platform/host/error.hpp"
#include "platform/host/input_file.hpp"
#include "shading/compiler/emit.hpp"
#include "shading/compiler/front_end.hpp"
#include "shading/compiler/limits.hpp"
#include "shading/compiler/lower.hpp"
#include "shading/compiler/module_size.hpp"
#include "shading/compiler/program_limits.hpp"
#include "shading/compiler/simplify.hpp"
#include "shading/compiler/spirv_passes.hpp"

#include <cstring>
#include <filesystem>

namespace aluminate::compiler {
namespace {

// The parsers recurse once per nested construct; limits.hpp bounds the nesting so that this is enough.
constexpr std::size_t kStackBytes = std::size_t{512} << 20;

Language language_of(const Options& options) {
  if (options.language != Language::Auto) return options.language;
  const std::string extension = std::filesystem::path(options.source_path).extension().string();
  if (extension == ".hlsl" || extension == ".fx" || extension == ".fxh") return Language::Hlsl;
  if (extension == ".glsl" || extension == ".frag" || extension == ".vert") return Language::Glsl;
  if (extension == ".spv") return Language::Spirv;
  throw UserError(SourcePlace{options.source_path, 0, 0},
                  fmt::format("cannot tell the shading language from '{}'", extension),
                  "name the file .hlsl, .glsl, .frag, .vert or .spv");
}

std::string read_source(const Options& options) {
  return options.source ? *options.source : host::read_text(options.source_path);
}

std::vector<std::uint32_t> words_of(const std::string& bytes, const std::string& file) {
  if (bytes.size() % 4 != 0)
    throw UserError(SourcePlace{file, 0, 0}, "not a SPIR-V module: its size is no multiple of 4 bytes");
  std::vector<std::uint32_t> words(bytes.size() / 4);
  std::memcpy(words.data(), bytes.data(), bytes.size());
  return words;
}

// Places without a file are about the whole shader.
[[noreturn]] void rethrow_with_file(const UserError& e, const std::string& file) {
  if (!e.place().file.empty()) throw e;
  throw UserError(SourcePlace{file, 0, 0}, e.what(), e.hint());
}

vm::Program compile_here(const Options& options) {
  const std::string file = options.source_path.empty() ? "shader" : options.source_path;
  const Language language = language_of(options);
  const std::string source = read_source(options);
  FrontEndResult front;
  if (language == Language::Spirv) {
    front.spirv = words_of(source, file);
    check_module_size(front.spirv, file);
  } else {
    front = run_front_end(options, language, source);
  }
  validate_spirv(front.spirv, file);
  std::vector<std::uint32_t> words = specialise(front.spirv, options.spec_constants, file);
  words = optimise_spirv(std::move(words), options.optimise, file);
  validate_spirv(words, file);

  // GLSL entry points are always called main.
  const SpirvModule module(std::move(words), language == Language::Glsl ? "main" : options.entry,
                           options.stage);
  Lowered lowered = lower(module, options.stage, options.loops, std::move(front.explicit_registers));
  if (lowered.symbols.files.empty()) lowered.symbols.files.push_back(file);
  simplify(lowered.ir);
  vm::Program program = emit(std::move(lowered));
  check_limits(program);
  program.name = options.name.empty() ? std::filesystem::path(file).filename().string() : options.name;
  return program;
}

}  // namespace

vm::Program compile(const Options& options) {
  vm::Program program;
  host::run_on_deep_stack(kStackBytes, [&] {
    try {
      program = compile_here(options);
    } catch (const UserError& e) {
      rethrow_with_file(e, options.source_path.empty() ? "shader" : options.source_path);
    }
  });
  return program;
}

}  // namespace aluminate::compiler
