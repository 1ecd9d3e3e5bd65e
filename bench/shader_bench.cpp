// The shipped forward shader on full batches of 64 lanes, without rasterizer and textures: what a pixel
// costs, and from two rows the slope that a light adds. Counters: ns per pixel; bytes of compiled code.
//   build/bench/shader_bench --benchmark_repetitions=9 --benchmark_report_aggregates_only=true
#include <benchmark/benchmark.h>

#include <memory>
#include <new>
#include <random>
#include <vector>

#include "shading/passes/programs.hpp"
#include "shading/vm/executable.hpp"
#include "shading/vm/jit/compiler.hpp"
#include "shading/vm/jit/slot.hpp"

namespace {

using namespace aluminate;

struct AlignedRows {
  explicit AlignedRows(std::size_t rows) : memory(new (std::align_val_t{64}) double[rows * vm::kLanes]()) {}
  ~AlignedRows() { ::operator delete[](memory, std::align_val_t{64}); }
  AlignedRows(const AlignedRows&) = delete;
  AlignedRows& operator=(const AlignedRows&) = delete;
  double* memory;
};

// width 0: interpreted; else lanes of a step of compiled code.
void forward_lit(benchmark::State& state, const char* format_name, int lights, std::uint32_t width) {
  const passes::FrameOptions frame;
  const vm::Program program = passes::compile_pixel(frame, {}, {lights, false}, false);
  const number::NumberFormat format = *number::parse_number_format(format_name);
  const vm::Executable executable = vm::prepare(program, format);
  if (width != 0) {
    vm::jit::CompileOptions options;
    options.width = width;
    const vm::jit::Compiled made = vm::jit::compile(executable.decoded(), options);
    if (made.code.empty()) return state.SkipWithError(made.problem.c_str());
    executable.slot().publish(options.assume, std::make_shared<vm::jit::Native>(made.code, made.description));
    state.counters["code_bytes"] = static_cast<double>(made.code.size());
  }
  AlignedRows inputs(executable.inputs().size()), outputs(executable.outputs().size());
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.05, 0.55);
  const number::Grid grid = format.default_grid();
  for (std::size_t i = 0; i < executable.inputs().size() * vm::kLanes; ++i)
    inputs.memory[i] = grid.magic == 0 ? unit(random) : (unit(random) + grid.magic) - grid.magic;
  std::vector<double> constants(static_cast<std::size_t>(program.uniform_count) * 4);
  for (double& x : constants) x = 0.5 + unit(random);
  const vm::ConstantBank bank = vm::quantise_constants(format, constants);
  vm::Batch batch;
  batch.inputs = inputs.memory;
  batch.outputs = outputs.memory;
  batch.constants = bank.values.data();
  batch.active = batch.covered = ~std::uint64_t{0};
  batch.inputs_on_grid = true;
  vm::Scratch scratch(executable);
  vm::Counters counters(executable);
  for (auto _ : state) {
    vm::run(executable, batch, scratch, counters);
    benchmark::ClobberMemory();
  }
  std::uint64_t saturations = 0;
  for (const std::uint64_t count : counters.saturations) saturations += count;
  if (saturations != 0) state.SkipWithError("values left their range: not the work of a picture");
  using benchmark::Counter;
  state.counters["operations"] = static_cast<double>(executable.operation_count());
  state.counters["s_per_pixel"] =
      Counter(static_cast<double>(state.iterations()) * vm::kLanes, Counter::kIsRate | Counter::kInvert);
}

void rows() {
  struct Row {
    const char* name;
    const char* format;
    std::uint32_t width;
  };
  static constexpr Row kRows[] = {{"interpreted", "fx31", 0}, {"jit_w8", "fx31", 8},
                                  {"jit_w16", "fx31", 16},    {"jit_w32", "fx31", 32},
                                  {"jit_w64", "fx31", 64},    {"jit_ref64", "ref64", 16}};
  for (const Row& row : kRows)
    for (const int lights : {1, 4, 8, 16})
      benchmark::RegisterBenchmark(
          (std::string("forward_lit/") + row.name + "/" + std::to_string(lights)).c_str(), forward_lit,
          row.format, lights, row.width);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  rows();
  benchmark::RunSpecifiedBenchmarks();
}
