#include "tests/fuzz/shader_input.hpp"

#include "platform/console/platform_file.hpp"
#include "platform/host/error.hpp"
#include "platform/host/input_file.hpp"
#include "platform/number/format.hpp"
#include "shading/cost/static_cost.hpp"
#include "shading/vm/executable.hpp"

#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <vector>

namespace aluminate::fuzz {

void run_batch(const vm::Program& program) {
  const auto format = *number::parse_number_format("fx31");
  const vm::Executable executable = vm::prepare(program, format);
  const auto rows = [](std::size_t n) { return std::vector<double>((n + 1) * vm::kLanes); };
  std::vector<double> in = rows(executable.inputs().size()), out = rows(executable.outputs().size());
  for (std::size_t k = 0; k < in.size(); ++k) in[k] = static_cast<double>(k % 29) * 0.375 - 4;
  std::vector<double> constants(static_cast<std::size_t>(program.uniform_count) * 4);
  for (std::size_t k = 0; k < constants.size(); ++k) constants[k] = static_cast<double>(k % 17) * 0.5 - 3;
  const vm::ConstantBank bank = vm::quantise_constants(format, constants);
  const std::vector<vm::SamplerBinding> samplers(program.samplers.size());
  vm::Counters counters(executable);
  vm::Scratch scratch;
  scratch.fit(executable);
  vm::Batch batch;
  batch.inputs = in.data();
  batch.outputs = out.data();
  batch.constants = bank.values.data();
  batch.samplers = samplers;
  batch.active = batch.covered = ~std::uint64_t{0};
  vm::run(executable, batch, scratch, counters);
  const double greatest = format.default_grid().greatest;
  for (const double v : out)
    if (!(std::fabs(v) <= greatest)) throw std::logic_error("an output outside the number format");
  vm::raise_loop_overrun(program, counters);
}

std::string run_shader(compiler::Language language, vm::Stage stage, std::string_view bytes) {
  compiler::Options options;
  options.source_path = "input";
  options.source = std::string(bytes);
  options.language = language;
  options.stage = stage;
  try {
    const vm::Program program = compiler::compile(options);
    vm::validate(program);
    static const console::GpuModel gpu = console::load_platform("xenos");
    (void)cost::price(program, gpu, {});
    run_batch(program);
  } catch (const UserError& e) {
    if (std::string(e.what()).empty()) throw std::logic_error("an error without a message");
    return e.what();
  }
  return "";
}

std::string run_corpus_file(const std::string& path) {
  using compiler::Language;
  const std::filesystem::path file(path);
  const std::string folder = file.parent_path().filename().string();
  const Language language = folder == "spirv"  ? Language::Spirv
                            : folder == "hlsl" ? Language::Hlsl
                            : folder == "glsl" ? Language::Glsl
                                               : throw std::logic_error("no language for folder " + folder);
  const bool vertex = file.filename().string().starts_with("vertex");
  return run_shader(language, vertex ? vm::Stage::Vertex : vm::Stage::Pixel, host::read_text(path));
}

}  // namespace aluminate::fuzz
