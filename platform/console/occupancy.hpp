// Threads in flight from registers: pure arithmetic on a GpuModel's figures.
#pragma once

#include "platform/console/gpu_model.hpp"

namespace aluminate::console {

/// Thread groups in flight for a program of `gprs` vec4 registers (>= 1; 0 counts as 1).
/// threads = min(cap, sets * floor(rows / gprs)); cap is 63 for pixels and 31 for vertices on Xenos, where
/// the formula reproduces every printed estimate [UNI, FXA]. Units differ by platform: 64-lane groups, or
/// quads on RSX.
int threads_in_flight(const GpuModel& gpu, int gprs, bool vertex_stage);

/// Threads over the cap, in (0, 1]: 1 = registers do not limit latency hiding.
double occupancy(const GpuModel& gpu, int gprs, bool vertex_stage);

}  // namespace aluminate::console
