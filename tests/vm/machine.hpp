// Runs a program on 64 lanes with either interpreter, and keeps everything a test may want to look at.
#pragma once

#include <gtest/gtest.h>

#include <cstring>

#include "shading/vm/executable.hpp"
#include "shading/vm/reference_interpreter.hpp"

namespace aluminate::vm::testing {

inline constexpr std::uint64_t kAllLanes = ~std::uint64_t{0};

struct AlignedRows {
  explicit AlignedRows(std::size_t rows) : bytes(rows * kLanes + 8) {}
  std::span<double> values() { return {data(), bytes.size() - 8}; }
  double* data() {
    const auto address = reinterpret_cast<std::uintptr_t>(bytes.data());
    return bytes.data() + (kRowAlignment - address % kRowAlignment) % kRowAlignment / sizeof(double);
  }
  double& at(std::size_t row, int lane) { return data()[row * kLanes + static_cast<std::size_t>(lane)]; }
  std::vector<double> bytes;
};

inline number::NumberFormat format(std::string_view name) { return *number::parse_number_format(name); }

class Machine {
 public:
  Machine(const Program& p, std::string_view format_name)
      : program(p),
        executable(prepare(p, format(format_name))),
        inputs(executable.inputs().size()),
        outputs(executable.outputs().size()),
        counters(executable),
        lane_blocks(executable.block_count() * kLanes, 0),
        constants(static_cast<std::size_t>(p.uniform_count) * 4, 0.0) {}

  /// The same number in every lane.
  void set_input(int index, int component, double value) {
    for (int lane = 0; lane < kLanes; ++lane) set_input(index, component, lane, value);
  }
  void set_input(int index, int component, int lane, double value) {
    for (std::size_t r = 0; r < executable.inputs().size(); ++r)
      if (executable.inputs()[r] == RowBinding{static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(component)})
        inputs.at(r, lane) = value;
  }
  double output(int index, int component, int lane) {
    for (std::size_t r = 0; r < executable.outputs().size(); ++r)
      if (executable.outputs()[r] == RowBinding{static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(component)})
        return outputs.at(r, lane);
    ADD_FAILURE() << "no output o" << index << " component " << component;
    return 0;
  }

  void run(std::uint64_t active = kAllLanes, std::uint64_t covered = kAllLanes) { start(active, covered, false, nullptr); }
  void run_oracle(std::uint64_t active = kAllLanes, std::uint64_t covered = kAllLanes, Trace* trace = nullptr) {
    start(active, covered, true, trace);
  }

  Program program;
  Executable executable;
  AlignedRows inputs, outputs;
  Counters counters;
  std::vector<std::uint32_t> lane_blocks;
  std::vector<double> constants;
  std::vector<SamplerBinding> samplers;
  Batch batch;

 private:
  void start(std::uint64_t active, std::uint64_t covered, bool oracle, Trace* trace) {
    bank_ = quantise_constants(executable.format(), constants);
    samplers.resize(program.samplers.size());
    batch.inputs = inputs.data();
    batch.outputs = outputs.data();
    batch.constants = bank_.values.data();
    batch.samplers = samplers;
    batch.active = active;
    batch.covered = covered;
    batch.lane_blocks = lane_blocks.data();
    if (oracle) {
      run_reference(program, executable, batch, counters, trace);
    } else {
      Scratch scratch(executable);
      aluminate::vm::run(executable, batch, scratch, counters);
    }
  }
  ConstantBank bank_;
};

}  // namespace aluminate::vm::testing
