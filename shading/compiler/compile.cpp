#include "shading/compiler/compile.hpp"

#include "platform/host/error.hpp"
#include "shading/compiler/emit.hpp"
#include "shading/compiler/front_end.hpp"
#include "shading/compiler/lower.hpp"
#include "shading/compiler/simplify.hpp"
#include "shading/compiler/spirv_passes.hpp"

#include <pthread.h>

#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

namespace aluminate::compiler {
namespace {

// The parsers recurse once per nested construct; front_end.hpp bounds the nesting so that this is enough.
constexpr std::size_t kStackBytes = std::size_t{512} << 20;

// Runs f on a thread with a large stack and hands on what it throws.
void on_large_stack(const std::function<void()>& f) {
  struct Call {
    const std::function<void()>& f;
    std::exception_ptr error;
  } call{f, nullptr};
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStackBytes);
  pthread_t thread{};
  const auto start = [](void* p) -> void* {
    Call& c = *static_cast<Call*>(p);
    try {
      c.f();
    } catch (...) {
      c.error = std::current_exception();
    }
    return nullptr;
  };
  const int failed = pthread_create(&thread, &attributes, start, &call);
  pthread_attr_destroy(&attributes);
  ALU_CHECK(failed == 0, "no thread for the compiler: {}", std::strerror(failed));
  pthread_join(thread, nullptr);
  if (call.error) std::rethrow_exception(call.error);
}

Language language_of(const Options& options) {
  if (options.language != Language::Auto) return options.language;
  const std::string extension = std::filesystem::path(options.source_path).extension().string();
  if (extension == ".hlsl" || extension == ".fx" || extension == ".fxh") return Language::Hlsl;
  if (extension == ".glsl" || extension == ".frag" || extension == ".vert") return Language::Glsl;
  if (extension == ".spv") return Language::Spirv;
  throw UserError(SourcePlace{options.source_path, 0, 0}, fmt::format("cannot tell the shading language from '{}'", extension),
                  "name the file .hlsl, .glsl, .frag, .vert or .spv");
}

std::string read_source(const Options& options) {
  if (options.source) return *options.source;
  std::error_code ignored;
  if (std::filesystem::is_directory(options.source_path, ignored)) throw UserError(SourcePlace{options.source_path, 0, 0}, "is a directory, not a shader");
  std::ifstream in(options.source_path, std::ios::binary);
  if (!in) throw UserError(SourcePlace{options.source_path, 0, 0}, "cannot open the shader", std::strerror(errno));
  std::ostringstream text;
  text << in.rdbuf();
  return std::move(text).str();
}

std::vector<std::uint32_t> words_of(const std::string& bytes, const std::string& file) {
  if (bytes.size() % 4 != 0) throw UserError(SourcePlace{file, 0, 0}, "not a SPIR-V module: its size is no multiple of 4 bytes");
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
  if (language == Language::Spirv) front.spirv = words_of(source, file);
  else front = run_front_end(options, language, source);

  validate_spirv(front.spirv, file);
  std::vector<std::uint32_t> words = specialise(front.spirv, options.spec_constants, file);
  words = optimise_spirv(std::move(words), options.optimise, file);
  validate_spirv(words, file);

  // GLSL entry points are always called main.
  const SpirvModule module(std::move(words), language == Language::Glsl ? "main" : options.entry, options.stage);
  Lowered lowered = lower(module, options.stage, options.loops, std::move(front.explicit_registers));
  if (lowered.symbols.files.empty()) lowered.symbols.files.push_back(file);
  simplify(lowered.ir);
  vm::Program program = emit(std::move(lowered));
  program.name = options.name.empty() ? std::filesystem::path(file).filename().string() : options.name;
  return program;
}

}  // namespace

vm::Program compile(const Options& options) {
  vm::Program program;
  on_large_stack([&] {
    try {
      program = compile_here(options);
    } catch (const UserError& e) {
      rethrow_with_file(e, options.source_path.empty() ? "shader" : options.source_path);
    }
  });
  return program;
}

}  // namespace aluminate::compiler
