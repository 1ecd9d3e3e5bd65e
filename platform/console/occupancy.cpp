#include "platform/console/occupancy.hpp"

#include <algorithm>
#include <cmath>

namespace aluminate::console {

int threads_in_flight(const GpuModel& gpu, int gprs, bool vertex_stage) {
  const double rows_each = std::floor(gpu.registers.rows.value / std::max(1, gprs));
  const double cap = (vertex_stage ? gpu.registers.threads_max_vertex : gpu.registers.threads_max).value;
  return static_cast<int>(std::min(cap, gpu.registers.sets.value * rows_each));
}

double occupancy(const GpuModel& gpu, int gprs, bool vertex_stage) {
  const double cap = (vertex_stage ? gpu.registers.threads_max_vertex : gpu.registers.threads_max).value;
  return threads_in_flight(gpu, gprs, vertex_stage) / cap;
}

}  // namespace aluminate::console
