// eDRAM arithmetic: how many tiles a set of render targets takes and how often the geometry must be sent.
#pragma once

#include "platform/console/gpu_model.hpp"

#include <span>

namespace aluminate::console {

/// One surface kept on chip while a pass draws: colour or depth. bits 32 or 64; samples 1, 2 (1x2) or 4
/// (2x2).
struct SurfaceShape {
  int width_px = 0, height_px = 0;
  int bits_per_pixel = 32;
  int samples = 1;
};

/// ceil(W*sx/80) * ceil(H*sy/16) * (2 when 64 bit) on Xenos [XEN-X]. Throws UserError for sizes below 1,
/// other bit counts or sample counts, and for platforms without eDRAM.
int edram_tiles(const GpuModel& gpu, const SurfaceShape& surface);

/// Tiles the platform has: 2048 of 80x16 32-bit samples on Xenos.
int edram_capacity_tiles(const GpuModel& gpu);

/// Predicated-tiling passes = ceil(total tiles / capacity) (console table in docs/cost_model.md). Each pass
/// repeats vertex work, not pixel work.
int tiling_passes(const GpuModel& gpu, std::span<const SurfaceShape> surfaces);

}  // namespace aluminate::console
