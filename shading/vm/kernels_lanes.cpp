// Kernels that are not elementwise: they read across lanes, make masks or go to the texture unit. No SIMD of their own.
#include <algorithm>
#include <bit>
#include <cmath>

#include "platform/number/scalar.hpp"
#include "shading/vm/kernels.hpp"
#include "shading/vm/texture_unit.hpp"

namespace aluminate::vm {
namespace {

const double* at(const Frame& frame, const Operand& operand) {
  return frame.base[static_cast<int>(operand.space)] + operand.offset;
}

double lane(const Frame& frame, const Operand& operand, int i) {
  return at(frame, operand)[operand.is_row() ? i : 0];
}

template <class Predicate>
std::uint64_t lanes_where(Predicate predicate) {
  std::uint64_t mask = 0;
  for (int i = 0; i < kLanes; ++i) mask |= std::uint64_t{predicate(i)} << i;
  return mask;
}

template <class Compare>
void kill(const Operation& op, Frame& frame) noexcept {
  frame.killed |= frame.exec & lanes_where([&](int i) {
                    return Compare{}(lane(frame, op.src[0], i), lane(frame, op.src[1], i));
                  });
}

void not_zero(const Operation& op, Frame& frame) noexcept {
  frame.condition = lanes_where([&](int i) { return lane(frame, op.src[0], i) != 0.0; });
}

// One difference per quad: lane 1 - lane 0 along x, lane 2 - lane 0 along y, the same for all four lanes.
template <int kNeighbour>
void derivative(const Operation& op, Frame& frame) noexcept {
  const double* source = at(frame, op.src[0]);
  const bool row = op.src[0].is_row();
  double* dst = frame.rows + op.dst;
  for (int q = 0; q < kLanes; q += 4) {
    const double difference = row ? number::to_grid(*op.grid, source[q + kNeighbour] - source[q]) : 0.0;
    for (int i = q; i < q + 4; ++i)
      if (!op.masked || (frame.exec >> i & 1) != 0) dst[i] = difference;
  }
  enforce_range(op, frame);
}

void relative_uniform(const Operation& op, Frame& frame) noexcept {
  const double* values = at(frame, op.src[0]);
  const Relative& relative = op.relative;
  const double last = relative.limit - 1.0;
  const auto value_at = [&](double index) {
    const double scaled = index * relative.scale;
    const double clamped = scaled < 0.0 ? 0.0 : scaled < last ? scaled : last;
    return values[4 * static_cast<std::size_t>(clamped)];
  };
  double* dst = frame.rows + op.dst;
  if (relative.base == RelativeBase::LoopCounter) {
    std::fill_n(dst, kLanes, value_at(frame.iterations[op.loop_level]));
  } else {
    const double* index = at(frame, op.src[1]);
    for (int i = 0; i < kLanes; ++i) dst[i] = value_at(std::floor(index[i]));
  }
}

void texture(const Operation& op, Frame& frame) noexcept {
  FetchRequest request;
  request.op = op.texture_op;
  request.dimension = op.dimension;
  for (std::size_t i = 0; i < request.rows.size(); ++i) request.rows[i] = at(frame, op.src[i]);
  request.exec = frame.exec;
  request.covered = frame.covered;
  std::array<double*, 4> results{};
  for (std::size_t c = 0; c < 4; ++c)
    results[c] = (op.texture_mask >> c & 1) != 0 ? frame.rows + op.texture_dst[c] : nullptr;
  const FetchCost cost = fetch(frame.samplers[op.sampler], request, op.masked, *op.grid, results);
  frame.counters->fetches += cost.fetches;
  frame.counters->fetch_cycles += cost.cycles;
}

}  // namespace

void enforce_range(const Operation& op, Frame& frame) noexcept {
  double* row = frame.rows + op.dst;
  std::uint64_t clamped = 0;
  for (int i = 0; i < kLanes; ++i) {
    if (op.masked && (frame.exec >> i & 1) == 0) continue;
    const number::Ranged r = number::finish(*op.grid, false, row[i]);
    row[i] = r.value;
    clamped |= std::uint64_t{r.saturated} << i;
  }
  frame.saturations[op.instruction] +=
      static_cast<std::uint64_t>(std::popcount(clamped & frame.exec & frame.covered));
}

KernelFunction find_lane_kernel(Kernel kernel) {
  switch (kernel) {
    case Kernel::ClampRange: return enforce_range;
    case Kernel::RelativeUniform: return relative_uniform;
    case Kernel::DsX: return derivative<1>;
    case Kernel::DsY: return derivative<2>;
    case Kernel::Texture: return texture;
    case Kernel::KillGt: return kill<std::greater<>>;
    case Kernel::KillGe: return kill<std::greater_equal<>>;
    case Kernel::KillNe: return kill<std::not_equal_to<>>;
    case Kernel::KillEq: return kill<std::equal_to<>>;
    case Kernel::NotZero: return not_zero;
    default: return nullptr;
  }
}

}  // namespace aluminate::vm
