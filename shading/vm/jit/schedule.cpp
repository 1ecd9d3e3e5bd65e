#include "shading/vm/jit/schedule.hpp"

#include <algorithm>
#include <map>

#include "shading/vm/jit/row_liveness.hpp"

namespace aluminate::vm::jit {
namespace {

// Cycles until a result may be used and cycles of the vector units it takes, roughly, on any processor with two fused
// multiply-adds of four cycles a clock. Only the order depends on them, no result does.
struct Cost {
  int latency, units;
};
Cost cost_of(Kernel kernel) {
  switch (kernel) {
    case Kernel::Rcp: return {40, 8};
    case Kernel::Rsq: return {60, 12};
    case Kernel::RcpReference:
    case Kernel::RsqReference:
    case Kernel::Sqrt: return {40, 16};
    case Kernel::Exp:
    case Kernel::ExpReference: return {60, 9};
    case Kernel::Log:
    case Kernel::LogReference: return {75, 16};
    case Kernel::Sin:
    case Kernel::Cos: return {70, 14};
    case Kernel::Dot2:
    case Kernel::NegDot2: return {12, 2};
    case Kernel::Dot3:
    case Kernel::NegDot3: return {16, 2};
    case Kernel::Dot4:
    case Kernel::NegDot4: return {20, 3};
    case Kernel::RelativeUniform: return {30, 8};
    case Kernel::Add:
    case Kernel::Sub:
    case Kernel::Copy:
    case Kernel::Min:
    case Kernel::Max: return {4, 1};
    default: return {8, 1};
  }
}

}  // namespace

Stretch schedule(const Decoded& d, std::uint32_t first, std::uint32_t last, std::uint32_t window) {
  const std::size_t count = last - first;
  std::vector<ScheduledOperation> nodes(count);
  std::map<std::uint32_t, std::int32_t> writer;
  const auto writer_of = [&](std::uint32_t row) {
    const auto known = writer.find(row);
    return known == writer.end() ? kFromMemory : known->second;
  };
  for (std::size_t n = 0; n < count; ++n) {
    const Operation& op = d.operations[first + n];
    nodes[n].index = first + static_cast<std::uint32_t>(n);
    for (int s = 0; s < source_count(op); ++s) {
      const Operand& operand = op.src[static_cast<std::size_t>(s)];
      if (operand.space == Space::Row) nodes[n].rows.emplace_back(operand.offset, writer_of(operand.offset));
    }
    if (op.kernel >= Kernel::KillGt) continue;
    if (op.masked) nodes[n].rows.emplace_back(op.dst, writer_of(op.dst));
    writer[op.dst] = static_cast<std::int32_t>(first + n);
  }

  Stretch result;
  for (const auto& [row, by] : writer) result.written.emplace_back(row, static_cast<std::uint32_t>(by));

  // In order of when the operands are there, as a simple in-order processor would meet them.
  std::vector<int> ready_at(count, 0);  // when the result is there
  std::vector<bool> done(count, false);
  std::size_t oldest = 0;
  int now = 0;
  while (oldest < count) {
    std::size_t best = count;
    int best_time = 0;
    for (std::size_t n = oldest; n < std::min(count, oldest + window); ++n) {
      if (done[n]) continue;
      int time = 0;
      bool possible = true;
      for (const auto& [row, by] : nodes[n].rows) {
        if (by == kFromMemory) continue;
        const auto producer = static_cast<std::size_t>(by) - first;
        possible &= static_cast<bool>(done[producer]);
        time = std::max(time, ready_at[producer]);
      }
      if (!possible) continue;
      time = std::max(time, now);
      if (best != count && time >= best_time) continue;
      best = n;
      best_time = time;
    }
    const Cost cost = cost_of(d.operations[first + best].kernel);
    now = best_time + cost.units;
    ready_at[best] = now + cost.latency;
    done[best] = true;
    result.operations.push_back(std::move(nodes[best]));
    while (oldest < count && done[oldest]) ++oldest;
  }
  return result;
}

}  // namespace aluminate::vm::jit
