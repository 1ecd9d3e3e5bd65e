// Compiles shader text and runs it on 64 lanes of the reference interpreter.
#pragma once

#include "platform/host/error.hpp"
#include "platform/number/format.hpp"
#include "shading/compiler/compile.hpp"
#include "shading/vm/executable.hpp"
#include "shading/vm/reference_interpreter.hpp"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace aluminate::compiler::testing {

using Float4 = std::array<double, 4>;

inline Options options_for(const std::string& text, Language language = Language::Hlsl,
                           LoopMode loops = LoopMode::AsWritten) {
  Options o;
  o.source_path = language == Language::Hlsl ? "test.hlsl" : "test.frag";
  o.source = text;
  o.language = language;
  o.loops = loops;
  return o;
}

/// Compiles and validates; the listing goes to the log when validation fails.
inline vm::Program compile_valid(const Options& options) {
  vm::Program p = compile(options);
  try {
    vm::validate(p);
  } catch (const std::exception& e) {
    std::string listing;
    for (const auto& i : p.code) listing += vm::disassemble(p, i) + "\n";
    ADD_FAILURE() << e.what() << "\n" << listing;
  }
  return p;
}

inline int slots(const vm::Program& p) {
  int sum = 0;
  for (const auto& i : p.code) sum += vm::info(i.op).ps3_slots;
  return sum;
}

/// Slots inside the loops, without Loop and EndLoop themselves.
inline int loop_slots(const vm::Program& p) {
  int sum = 0, depth = 0;
  for (const auto& i : p.code) {
    if (i.op == vm::Opcode::EndLoop) --depth;
    if (depth > 0 && i.op != vm::Opcode::Loop) sum += vm::info(i.op).ps3_slots;
    if (i.op == vm::Opcode::Loop) ++depth;
  }
  return sum;
}

inline int count(const vm::Program& p, vm::Opcode op) {
  int n = 0;
  for (const auto& i : p.code) n += i.op == op ? 1 : 0;
  return n;
}

inline std::string listing(const vm::Program& p) {
  std::string text;
  for (const auto& i : p.code) text += vm::disassemble(p, i) + "\n";
  return text;
}

struct Outcome {
  std::map<std::string, std::array<Float4, vm::kLanes>> outputs;  // by semantic
  std::uint64_t killed = 0;
  bool overran = false;
};

/// inputs by semantic, uniforms by name (register order).
inline Outcome run(const vm::Program& p,
                   const std::function<double(const std::string& semantic, int component, int lane)>& input,
                   const std::map<std::string, std::vector<double>>& uniforms = {},
                   const char* format_name = "ref64") {
  const auto format = *number::parse_number_format(format_name);
  const vm::Executable executable = vm::prepare(p, format);
  const auto rows = [](std::size_t n) { return std::vector<double>((n + 1) * vm::kLanes); };
  std::vector<double> in = rows(executable.inputs().size()), out = rows(executable.outputs().size());
  for (std::size_t r = 0; r < executable.inputs().size(); ++r)
    for (int lane = 0; lane < vm::kLanes; ++lane)
      in[r * vm::kLanes + static_cast<std::size_t>(lane)] =
          input(p.inputs[executable.inputs()[r].index].semantic, executable.inputs()[r].component, lane);
  std::vector<double> constants(static_cast<std::size_t>(p.uniform_count) * 4, 0.0);
  for (const auto& [name, values] : uniforms) {
    bool known = false;
    for (const auto& u : p.uniforms) {
      if (u.name != name) continue;
      known = true;
      for (std::size_t k = 0; k < values.size(); ++k) {
        const std::size_t reg = static_cast<std::size_t>(u.reg) + k / static_cast<std::size_t>(u.components);
        constants[reg * 4 + static_cast<std::size_t>(u.component) +
                  k % static_cast<std::size_t>(u.components)] = values[k];
      }
    }
    EXPECT_TRUE(known) << "no uniform " << name;
  }
  const vm::ConstantBank bank = vm::quantise_constants(format, constants);
  std::vector<vm::SamplerBinding> samplers(p.samplers.size());
  vm::Counters counters(executable);
  vm::Batch batch;
  batch.inputs = in.data();
  batch.outputs = out.data();
  batch.constants = bank.values.data();
  batch.samplers = samplers;
  batch.active = batch.covered = ~std::uint64_t{0};
  vm::run_reference(p, executable, batch, counters);
  Outcome result;
  result.killed = batch.killed;
  result.overran = counters.overrun_loop >= 0;
  for (std::size_t r = 0; r < executable.outputs().size(); ++r)
    for (std::size_t lane = 0; lane < vm::kLanes; ++lane)
      result.outputs[p.outputs[executable.outputs()[r].index].semantic][lane]
                    [executable.outputs()[r].component] = out[r * vm::kLanes + lane];
  return result;
}

/// Deterministic test values: signs, zero, ones and numbers of ordinary size, different in every lane and
/// component.
inline double test_value(const std::string& semantic, int component, int lane) {
  std::uint64_t x = 0x9e3779b97f4a7c15u *
                    (static_cast<std::uint64_t>(lane) * 64 + static_cast<std::uint64_t>(component) * 16 +
                     static_cast<std::uint64_t>(semantic.back()) + 1);
  x ^= x >> 29;
  x *= 0xbf58476d1ce4e5b9u;
  x ^= x >> 32;
  switch (x % 16) {
    case 0:
      return 0;
    case 1:
      return 1;
    case 2:
      return -1;
    default:
      return static_cast<double>(static_cast<std::int64_t>(x >> 40) - (1 << 23)) /
             (1 << 21);  // [-4, 4), exact in fp32
  }
}

}  // namespace aluminate::compiler::testing
