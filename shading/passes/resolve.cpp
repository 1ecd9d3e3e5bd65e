#include "shading/passes/resolve.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "platform/host/parallel.hpp"
#include "platform/host/workers.hpp"
#include "shading/passes/tile_pixels.hpp"

namespace aluminate::passes {
namespace {

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

void resolve(const FrameOptions& options, const DrawList& list, Frame& frame) {
  if (options.tonemap == Tonemap::None) return;
  std::vector<float> untouched = frame.linear;
  tone_map(list, options.tonemap, options.vm, frame.linear, frame);
  const Background background(options.background);
  host::parallel_for(frame.height, [&](std::int64_t y) {
    encode_pixels(background, {0, static_cast<int>(y), frame.width, 1}, frame);
  });
  frame.linear = std::move(untouched);
}

}  // namespace aluminate::passes
