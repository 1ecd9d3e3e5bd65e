#include "platform/console/edram.hpp"

#include "platform/host/error.hpp"

namespace aluminate::console {
namespace {

std::int64_t divide_up(std::int64_t a, std::int64_t b) { return (a + b - 1) / b; }

void require_edram(const GpuModel& gpu) {
  if (!gpu.has_edram()) {
    throw UserError(fmt::format("platform '{}' has no eDRAM", gpu.id),
                    "render targets there live in memory: no tiling passes");
  }
}

}  // namespace

int edram_tiles(const GpuModel& gpu, const SurfaceShape& surface) {
  require_edram(gpu);
  if (surface.width_px < 1 || surface.height_px < 1 || surface.width_px > 16384 ||
      surface.height_px > 16384) {
    throw UserError(
        fmt::format("surface of {} x {} px: sizes are 1 to 16384", surface.width_px, surface.height_px));
  }
  if (surface.bits_per_pixel != 32 && surface.bits_per_pixel != 64) {
    throw UserError(fmt::format("surface of {} bits a pixel: eDRAM holds 32 or 64", surface.bits_per_pixel));
  }
  if (surface.samples != 1 && surface.samples != 2 && surface.samples != 4) {
    throw UserError(fmt::format("surface of {} samples: eDRAM holds 1, 2 or 4", surface.samples));
  }
  const std::int64_t samples_x = surface.width_px * (surface.samples == 4 ? 2 : 1);
  const std::int64_t samples_y = surface.height_px * (surface.samples >= 2 ? 2 : 1);
  const std::int64_t tiles =
      divide_up(samples_x, static_cast<std::int64_t>(gpu.edram.tile_width_samples.value)) *
      divide_up(samples_y, static_cast<std::int64_t>(gpu.edram.tile_height_samples.value));
  return static_cast<int>(tiles * (surface.bits_per_pixel / 32));
}

int edram_capacity_tiles(const GpuModel& gpu) {
  require_edram(gpu);
  constexpr double kSampleBytes = 4;
  return static_cast<int>(gpu.edram.bytes.value / (gpu.edram.tile_width_samples.value *
                                                   gpu.edram.tile_height_samples.value * kSampleBytes));
}

int tiling_passes(const GpuModel& gpu, std::span<const SurfaceShape> surfaces) {
  std::int64_t tiles = 0;
  for (const SurfaceShape& surface : surfaces) tiles += edram_tiles(gpu, surface);
  return static_cast<int>(divide_up(tiles, edram_capacity_tiles(gpu)));
}

}  // namespace aluminate::console
