// The interpreter and the texture unit. Figures: ns per pixel and light for the lighting shader (52 component operations
// a light), ns per component operation, ns per fetch.
#include <benchmark/benchmark.h>

#include <memory>
#include <random>

#include "shading/vm/executable.hpp"
#include "shading/vm/jit/compiler.hpp"
#include "shading/vm/jit/slot.hpp"
#include "shading/vm/texture_unit.hpp"
#include "tests/vm/program_builder.hpp"

namespace {

using namespace aluminate;
using namespace aluminate::vm;
using namespace aluminate::vm::testing;

// Blinn-Phong with Schlick-Smith visibility and Schlick Fresnel, point lights with windowed inverse squares, unrolled.
// v0 position, v1 normal, v2 view vector, v3 albedo, v4 (1-a, a, lerp(n.v), m); c[2i] light position, c[2i+1] colour.
Program lighting(int lights) {
  Builder b;
  const int k = b.literal(1, 2, 0.125, 0.01), s = b.literal(0.04, 0.96, 0, 0);
  b.op(Opcode::Mov, rd(10, "xyz"), {l(s, "z")});
  b.op(Opcode::Add, rd(11, "x"), {v(4, "w"), l(k, "y")});
  b.op(Opcode::Mul, rd(11, "x"), {r(11, "x"), l(k, "z")});
  for (int i = 0; i < lights; ++i) {
    const int t = 20 + 8 * i;
    b.op(Opcode::Add, rd(t, "xyz"), {c(2 * i), -v(0)});
    b.op(Opcode::Dp3, rd(t, "w"), {r(t), r(t)});
    b.op(Opcode::Rsq, rd(t + 1, "w"), {r(t, "w")});
    b.op(Opcode::Mul, rd(t + 1, "xyz"), {r(t), r(t + 1, "w")});                    // l
    b.op(Opcode::Add, rd(t + 2, "xyz"), {r(t + 1), v(2)});
    b.op(Opcode::Dp3, rd(t + 2, "w"), {r(t + 2), r(t + 2)});
    b.op(Opcode::Rsq, rd(t + 2, "w"), {r(t + 2, "w")});
    b.op(Opcode::Mul, rd(t + 2, "xyz"), {r(t + 2), r(t + 2, "w")});                // h
    b.op(Opcode::Dp3, rd(t + 3, "x"), {v(1), r(t + 1)}).saturate = true;           // n.l
    b.op(Opcode::Dp3, rd(t + 3, "y"), {v(1), r(t + 2)}).saturate = true;           // n.h
    b.op(Opcode::Dp3, rd(t + 3, "z"), {v(2), r(t + 2)}).saturate = true;           // h.v
    b.op(Opcode::Mul, rd(t + 4, "x"), {r(t + 1, "w"), r(t + 1, "w")});             // 1/d^2
    b.op(Opcode::Mad, rd(t + 4, "y"), {-r(t, "w"), l(k, "w"), l(k, "x")}).saturate = true;
    b.op(Opcode::Mul, rd(t + 4, "y"), {r(t + 4, "y"), r(t + 4, "y")});
    b.op(Opcode::Mul, rd(t + 4, "x"), {r(t + 4, "x"), r(t + 4, "y")});
    b.op(Opcode::Log, rd(t + 5, "x"), {r(t + 3, "y")});
    b.op(Opcode::Mul, rd(t + 5, "x"), {r(t + 5, "x"), v(4, "w")});
    b.op(Opcode::Exp, rd(t + 5, "x"), {r(t + 5, "x")});
    b.op(Opcode::Mul, rd(t + 5, "x"), {r(t + 5, "x"), r(11, "x")});                // D
    b.op(Opcode::Add, rd(t + 5, "y"), {l(k, "x"), -r(t + 3, "z")});
    b.op(Opcode::Mul, rd(t + 5, "z"), {r(t + 5, "y"), r(t + 5, "y")});
    b.op(Opcode::Mul, rd(t + 5, "z"), {r(t + 5, "z"), r(t + 5, "z")});
    b.op(Opcode::Mul, rd(t + 5, "z"), {r(t + 5, "z"), r(t + 5, "y")});
    b.op(Opcode::Mad, rd(t + 5, "z"), {r(t + 5, "z"), l(s, "y"), l(s, "x")});      // F
    b.op(Opcode::Mad, rd(t + 6, "x"), {r(t + 3, "x"), v(4, "x"), v(4, "y")});
    b.op(Opcode::Mul, rd(t + 6, "x"), {r(t + 6, "x"), v(4, "z")});
    b.op(Opcode::Rcp, rd(t + 6, "x"), {r(t + 6, "x")});                            // V
    b.op(Opcode::Mul, rd(t + 6, "x"), {r(t + 6, "x"), r(t + 5, "x")});
    b.op(Opcode::Mul, rd(t + 6, "x"), {r(t + 6, "x"), r(t + 5, "z")});             // D F V
    b.op(Opcode::Mul, rd(t + 6, "y"), {r(t + 3, "x"), r(t + 4, "x")});
    b.op(Opcode::Add, rd(t + 7, "xyz"), {v(3), r(t + 6, "x")});
    b.op(Opcode::Mul, rd(t + 7, "xyz"), {r(t + 7), r(t + 6, "y")});
    b.op(Opcode::Mad, rd(10, "xyz"), {r(t + 7), c(2 * i + 1), r(10)});
  }
  b.op(Opcode::Mov, o(0, "xyz"), {r(10)});
  return b.program;
}

struct AlignedRows {
  explicit AlignedRows(std::size_t rows) : memory(new (std::align_val_t{64}) double[rows * kLanes]()) {}
  ~AlignedRows() { ::operator delete[](memory, std::align_val_t{64}); }
  AlignedRows(const AlignedRows&) = delete;
  AlignedRows& operator=(const AlignedRows&) = delete;
  double* memory;
};

// width 0: interpreted.
void run_lighting(benchmark::State& state, const char* format_name, int lights, std::uint32_t width = 0,
                  Assume assume = Assume::Typical, std::uint32_t stretch = jit::kStretch) {
  const Program program = lighting(lights);
  const number::NumberFormat format = *number::parse_number_format(format_name);
  const Executable executable = prepare(program, format);
  if (width != 0) {
    jit::CompileOptions options;
    options.width = width;
    options.assume = assume;
    options.stretch = stretch;
    const jit::Compiled made = jit::compile(executable.decoded(), options);
    if (made.code.empty()) return state.SkipWithError(made.problem.c_str());
    executable.slot().publish(assume, std::make_shared<jit::Native>(made.code, made.description));
    state.counters["code_bytes"] = static_cast<double>(made.code.size());
  }
  AlignedRows inputs(executable.inputs().size()), outputs(executable.outputs().size());
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.05, 0.55);
  for (std::size_t i = 0; i < executable.inputs().size() * kLanes; ++i) inputs.memory[i] = unit(random);
  std::vector<double> constants(static_cast<std::size_t>(program.uniform_count) * 4);
  for (double& x : constants) x = 1 + unit(random);
  const ConstantBank bank = quantise_constants(format, constants);
  Batch batch;
  batch.inputs = inputs.memory;
  batch.outputs = outputs.memory;
  batch.constants = bank.values.data();
  batch.active = batch.covered = ~std::uint64_t{0};
  Scratch scratch(executable);
  Counters counters(executable);
  for (auto _ : state) {
    run(executable, batch, scratch, counters);
    benchmark::ClobberMemory();
  }
  state.counters["operations"] = static_cast<double>(executable.operation_count());
  state.counters["rows"] = executable.row_count();
  using benchmark::Counter;
  const double pixels = static_cast<double>(state.iterations()) * kLanes;
  state.counters["s_per_pixel_light"] = Counter(pixels * lights, Counter::kIsRate | Counter::kInvert);
  state.counters["s_per_lane_op"] =
      Counter(pixels * static_cast<double>(executable.operation_count()), Counter::kIsRate | Counter::kInvert);
}
BENCHMARK_CAPTURE(run_lighting, fx31_4_lights, "fx31", 4);
BENCHMARK_CAPTURE(run_lighting, fx31_8_lights, "fx31", 8);
BENCHMARK_CAPTURE(run_lighting, jit_w8_s12_8_lights, "fx31", 8, 8, Assume::Typical, 12);
BENCHMARK_CAPTURE(run_lighting, jit_w8_s24_8_lights, "fx31", 8, 8, Assume::Typical, 24);
BENCHMARK_CAPTURE(run_lighting, jit_w8_s48_8_lights, "fx31", 8, 8, Assume::Typical, 48);
BENCHMARK_CAPTURE(run_lighting, jit_w8_s96_8_lights, "fx31", 8, 8, Assume::Typical, 96);
BENCHMARK_CAPTURE(run_lighting, jit_w8_s1000_8_lights, "fx31", 8, 8, Assume::Typical, 1000);
BENCHMARK_CAPTURE(run_lighting, jit_w16_s12_8_lights, "fx31", 8, 16, Assume::Typical, 12);
BENCHMARK_CAPTURE(run_lighting, jit_w16_s24_8_lights, "fx31", 8, 16, Assume::Typical, 24);
BENCHMARK_CAPTURE(run_lighting, jit_w16_s48_8_lights, "fx31", 8, 16, Assume::Typical, 48);
BENCHMARK_CAPTURE(run_lighting, jit_w16_s96_8_lights, "fx31", 8, 16, Assume::Typical, 96);
BENCHMARK_CAPTURE(run_lighting, jit_w16_s1000_8_lights, "fx31", 8, 16, Assume::Typical, 1000);
BENCHMARK_CAPTURE(run_lighting, jit_w32_s12_8_lights, "fx31", 8, 32, Assume::Typical, 12);
BENCHMARK_CAPTURE(run_lighting, jit_w32_s24_8_lights, "fx31", 8, 32, Assume::Typical, 24);
BENCHMARK_CAPTURE(run_lighting, jit_w32_s48_8_lights, "fx31", 8, 32, Assume::Typical, 48);
BENCHMARK_CAPTURE(run_lighting, jit_w32_s96_8_lights, "fx31", 8, 32, Assume::Typical, 96);
BENCHMARK_CAPTURE(run_lighting, jit_w32_s1000_8_lights, "fx31", 8, 32, Assume::Typical, 1000);
BENCHMARK_CAPTURE(run_lighting, jit_w8_8_lights_general, "fx31", 8, 8, Assume::Nothing);
BENCHMARK_CAPTURE(run_lighting, jit_q16_16, "q16.16", 8, 8);
BENCHMARK_CAPTURE(run_lighting, q16_16_8_lights, "q16.16", 8);
BENCHMARK_CAPTURE(run_lighting, ref64_8_lights, "ref64", 8);

// Time from a decoded program to code.
void compile_lighting(benchmark::State& state, std::uint32_t width, int level, std::uint32_t stretch = jit::kStretch) {
  const Executable executable = prepare(lighting(4), *number::parse_number_format("fx31"));
  jit::CompileOptions options;
  options.width = width;
  options.level = level;
  options.stretch = stretch;
  for (auto _ : state) benchmark::DoNotOptimize(jit::compile(executable.decoded(), options));
}
BENCHMARK_CAPTURE(compile_lighting, w8, 8, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(compile_lighting, w16, 16, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(compile_lighting, w32, 32, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(compile_lighting, w64, 64, 1)->Unit(benchmark::kMillisecond);

// One instruction, 64 lanes, repeated 32 times on independent registers.
void run_opcode(benchmark::State& state, Opcode op) {
  Builder b;
  for (int i = 0; i < 32; ++i) b.op(op, o(i, "x"), {v(0, "x"), v(0, "y"), v(0, "z")});
  const Executable executable = prepare(b.program, *number::parse_number_format("fx31"));
  AlignedRows inputs(executable.inputs().size()), outputs(executable.outputs().size());
  for (std::size_t i = 0; i < executable.inputs().size() * kLanes; ++i) inputs.memory[i] = 0.25 + 0.01 * static_cast<double>(i % 64);
  Batch batch;
  batch.inputs = inputs.memory;
  batch.outputs = outputs.memory;
  batch.active = batch.covered = ~std::uint64_t{0};
  Scratch scratch(executable);
  Counters counters(executable);
  for (auto _ : state) {
    run(executable, batch, scratch, counters);
    benchmark::ClobberMemory();
  }
  state.counters["s_per_lane_op"] = benchmark::Counter(static_cast<double>(state.iterations()) * kLanes * 32,
                                                       benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(run_opcode, add, Opcode::Add);
BENCHMARK_CAPTURE(run_opcode, mul, Opcode::Mul);
BENCHMARK_CAPTURE(run_opcode, mad, Opcode::Mad);
BENCHMARK_CAPTURE(run_opcode, max, Opcode::Max);
BENCHMARK_CAPTURE(run_opcode, rcp, Opcode::Rcp);
BENCHMARK_CAPTURE(run_opcode, rsq, Opcode::Rsq);
BENCHMARK_CAPTURE(run_opcode, exp, Opcode::Exp);
BENCHMARK_CAPTURE(run_opcode, log, Opcode::Log);

enum class Pattern { OneToOne, Rotated, Minified, Random };

// 64 lanes = 16 quads of an 8x8 block walking over a 1024^2 texture.
void run_fetch(benchmark::State& state, Pattern pattern, bool srgb) {
  constexpr int kSize = 1024;
  std::mt19937 random(3);
  std::vector<std::uint8_t> rgba(std::size_t{kSize} * kSize * 4);
  for (auto& byte : rgba) byte = static_cast<std::uint8_t>(random());
  const Texture texture = Texture::from_rgba8(kSize, kSize, rgba, srgb, true);
  const SamplerBinding binding{&texture, {}};
  AlignedRows coordinates(2 * 256), texels(4);
  std::uniform_real_distribution<double> unit(0, 1);
  const double step = pattern == Pattern::Minified ? 11.3 : pattern == Pattern::Rotated ? 2.8 : 1.3;
  const double angle = pattern == Pattern::Rotated ? 0.6457718 : 0;
  for (int block = 0; block < 256; ++block)
    for (int lane = 0; lane < kLanes; ++lane) {
      const int q = lane / 4;
      const double x = block % 16 * 8 + q % 4 * 2 + lane % 2, y = block / 16 * 8 + q / 4 * 2 + lane / 2 % 2;
      double u = (x * std::cos(angle) - y * std::sin(angle)) * step / kSize, v = (x * std::sin(angle) + y * std::cos(angle)) * step / kSize;
      if (pattern == Pattern::Random && lane % 4 == 0) u = unit(random), v = unit(random);
      if (pattern == Pattern::Random && lane % 4 != 0) {
        u = coordinates.memory[(2 * block) * kLanes + (lane & ~3)] + lane % 2 * step / kSize;
        v = coordinates.memory[(2 * block + 1) * kLanes + (lane & ~3)] + lane / 2 % 2 * step / kSize;
      }
      coordinates.memory[(2 * block) * kLanes + lane] = u;
      coordinates.memory[(2 * block + 1) * kLanes + lane] = v;
    }
  FetchRequest request;
  request.exec = request.covered = ~std::uint64_t{0};
  const number::Grid grid = number::parse_number_format("fx31")->unit_grid();
  int block = 0;
  for (auto _ : state) {
    request.rows[0] = coordinates.memory + 2 * block * kLanes;
    request.rows[1] = request.rows[0] + kLanes;
    
    benchmark::DoNotOptimize(fetch(binding, request, false, grid,
                                   {texels.memory, texels.memory + 64, texels.memory + 128, texels.memory + 192}));
    block = (block + 1) % 256;
  }
  state.counters["s_per_fetch"] = benchmark::Counter(static_cast<double>(state.iterations()) * kLanes,
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(run_fetch, trilinear_1to1, Pattern::OneToOne, false);
BENCHMARK_CAPTURE(run_fetch, trilinear_1to1_srgb, Pattern::OneToOne, true);
BENCHMARK_CAPTURE(run_fetch, trilinear_rotated, Pattern::Rotated, true);
BENCHMARK_CAPTURE(run_fetch, trilinear_minified, Pattern::Minified, true);
BENCHMARK_CAPTURE(run_fetch, trilinear_random, Pattern::Random, true);

}  // namespace

BENCHMARK_MAIN();
