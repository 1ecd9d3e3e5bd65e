#include "shading/passes/resolve.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "platform/host/parallel.hpp"
#include "platform/host/workers.hpp"
#include "shading/vm/srgb.hpp"

namespace aluminate::passes {
namespace {

std::uint8_t stored_code(double display) { return static_cast<std::uint8_t>(display * 255.0 + 0.5); }

// Where nothing was drawn the background is what the user asked to have stored.
void encode_row(const std::array<std::uint8_t, 4>& background, Frame& frame, int y) {
  const std::size_t width = static_cast<std::size_t>(frame.width),
                    first = static_cast<std::size_t>(y) * width;
  for (std::size_t i = first; i < first + width; ++i) {
    std::array<std::uint8_t, 4> stored = background;
    if (frame.covered[i])
      for (std::size_t c = 0; c < 3; ++c) stored[c] = vm::srgb_encode8(frame.linear[i * 4 + c]);
    std::copy(stored.begin(), stored.end(), &frame.rgba8[i * 4]);
  }
}

// Runs the tone map over rows of 64 pixels, in place on `mapped`.
void tone_map(const DrawList& list, Tonemap tonemap, VmTier tier, std::vector<float>& mapped, Frame& frame) {
  const vm::Program program = compile_tonemap(tonemap);
  const vm::Executable executable = vm::prepare(program, list.format);
  choose_tier(executable, tier);
  const cost::StaticCost price = cost::price(program, list.gpu);
  struct Worker {
    vm::Scratch scratch;
    vm::Counters counters;
    host::AlignedRows inputs, outputs;
  };
  host::PerWorker<Worker> workers([&] {
    return Worker{vm::Scratch(executable), vm::Counters(executable),
                  host::AlignedRows(executable.inputs().size()),
                  host::AlignedRows(executable.outputs().size())};
  });
  const std::vector<double> no_constants(static_cast<std::size_t>(program.uniform_count) * 4);
  const std::size_t pixels = frame.pixel_count();
  constexpr std::size_t kChunk = 4096;
  host::parallel_for_workers(
      static_cast<std::int64_t>((pixels + kChunk - 1) / kChunk), [&](std::int64_t chunk, int slot) {
        Worker& worker = workers[slot];
        const std::size_t begin = static_cast<std::size_t>(chunk) * kChunk,
                          end = std::min(pixels, begin + kChunk);
        for (std::size_t base = begin; base < end; base += vm::kLanes) {
          const std::size_t lanes = std::min<std::size_t>(vm::kLanes, end - base);
          for (std::size_t row = 0; row < executable.inputs().size(); ++row)
            for (std::size_t lane = 0; lane < lanes; ++lane)
              worker.inputs.row(row)[lane] = mapped[(base + lane) * 4 + executable.inputs()[row].component];
          vm::Batch batch;
          batch.inputs = worker.inputs.data();
          batch.outputs = worker.outputs.data();
          batch.constants = no_constants.data();
          batch.active = batch.covered = lanes == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << lanes) - 1;
          vm::run(executable, batch, worker.scratch, worker.counters);
          for (std::size_t row = 0; row < executable.outputs().size(); ++row)
            for (std::size_t lane = 0; lane < lanes; ++lane)
              mapped[(base + lane) * 4 + executable.outputs()[row].component] =
                  static_cast<float>(worker.outputs.row(row)[lane]);
        }
      });
  PassTotals pass;
  pass.name = "resolve";
  pass.pixels = pass.rop_pixels = pixels;
  pass.quads = (static_cast<std::uint64_t>(frame.width) + 1) / 2 *
               ((static_cast<std::uint64_t>(frame.height) + 1) / 2);
  pass.helper_lanes = pass.quads * 4 - pixels;
  // A screen-filling draw: helper lanes exist only beyond an odd edge, and are charged to the edge's pixels.
  const auto words = static_cast<std::uint32_t>(std::ceil(price.alu_words)),
             slots = static_cast<std::uint32_t>(price.alu_slots);
  pass.alu_words = pass.quads * 4 * words;
  pass.alu_slots = pass.quads * 4 * slots;
  pass.fetches = pass.fetch_cyc = pass.quads * 4;  // the HDR target, read once
  pass.streamed_cyc = pass.fetch_cyc;
  pass.bytes = pixels * 8;
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      const std::uint32_t across = x == frame.width - 1 && frame.width % 2 ? 2 : 1,
                          down = y == frame.height - 1 && frame.height % 2 ? 2 : 1;
      const std::uint32_t lanes = across * down;
      const std::size_t at =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(frame.width) + static_cast<std::size_t>(x);
      frame.cost.alu_words[at] += lanes * words;
      frame.cost.alu_slots[at] += lanes * slots;
      frame.cost.fetches[at] += lanes;
      frame.cost.fetch_cyc[at] += lanes;
      frame.cost.overdraw[at] += 1;
      frame.cost.helpers[at] += lanes - 1;
    }
  frame.passes.push_back(std::move(pass));
}

}  // namespace

std::array<float, 3> linear_background(const glm::dvec3& stored) {
  std::array<float, 3> linear{};
  for (std::size_t c = 0; c < 3; ++c)
    linear[c] = static_cast<float>(vm::srgb_decode16(stored_code(stored[static_cast<int>(c)])) / 65535.0);
  return linear;
}

void clear_to_background(const glm::dvec3& stored, Frame& frame) {
  const std::array<float, 3> rgb = linear_background(stored);
  const std::array<float, 4> linear{rgb[0], rgb[1], rgb[2], 1};
  for (std::size_t i = 0; i < frame.linear.size(); ++i) frame.linear[i] = linear[i % 4];
}

void resolve(const FrameOptions& options, const DrawList& list, Frame& frame) {
  frame.rgba8.resize(frame.pixel_count() * 4);
  std::vector<float> untouched;
  if (options.tonemap != Tonemap::None) {
    untouched = frame.linear;
    tone_map(list, options.tonemap, options.vm, frame.linear, frame);
  }
  std::array<std::uint8_t, 4> background{0, 0, 0, 255};
  for (std::size_t c = 0; c < 3; ++c) background[c] = stored_code(options.background[static_cast<int>(c)]);
  host::parallel_for(frame.height,
                     [&](std::int64_t y) { encode_row(background, frame, static_cast<int>(y)); });
  if (!untouched.empty()) frame.linear = std::move(untouched);
}

}  // namespace aluminate::passes
