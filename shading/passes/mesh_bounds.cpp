#include "shading/passes/mesh_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "platform/host/parallel.hpp"

namespace aluminate::passes {
namespace {

struct Bounds {
  glm::dvec3 low, high;
};

// Of the positions in normalised space; none when one is not finite.
std::optional<Bounds> bounds_of(const scenes::Mesh& mesh, const scenes::NormalisedSpace& space) {
  Bounds bounds{glm::dvec3(INFINITY), glm::dvec3(-INFINITY)};
  for (const glm::dvec3& position : mesh.positions) {
    const glm::dvec3 p = space.point(position);
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return std::nullopt;
    bounds.low = glm::min(bounds.low, p);
    bounds.high = glm::max(bounds.high, p);
  }
  return bounds;
}

// A plane's distance is linear, so the corners of the bounds hold its maximum. Room for rounding: positions,
// matrix and sums lie on a grid of at least 20 fraction bits and a distance adds up at most 8 products of
// positions below 2 with coefficients below `largest`, so 2^-10 (1 + largest) is some hundred times what it
// can be off.
bool outside(const Bounds& bounds, const glm::dmat4& world_to_clip, double range) {
  double largest = 0;
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row) largest = std::max(largest, std::fabs(world_to_clip[column][row]));
  const double margin = 0x1p-10 * (1 + largest);
  bool beyond[6] = {true, true, true, true, true, true};
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec4 p((corner & 1) ? bounds.high.x : bounds.low.x,
                       (corner & 2) ? bounds.high.y : bounds.low.y,
                       (corner & 4) ? bounds.high.z : bounds.low.z, 1.0);
    const glm::dvec4 c = world_to_clip * p;
    for (int i = 0; i < 4; ++i)
      if (!(std::fabs(p[i]) < range) || !(std::fabs(c[i]) < range)) return false;
    const double distance[6] = {c.w + c.x, c.w - c.x, c.w + c.y, c.w - c.y, c.z, c.w - c.z};
    for (int plane = 0; plane < 6; ++plane) beyond[plane] = beyond[plane] && distance[plane] < -margin;
  }
  return std::any_of(std::begin(beyond), std::end(beyond), [](bool b) { return b; });
}

}  // namespace

void mark_draws_outside(DrawList& list) {
  if (list.format.kind == number::Kind::Saturating) return;
  const double range = list.format.default_grid().greatest / 16;
  const glm::dmat4 world_to_clip = list.view.world_to_clip();
  host::parallel_for(static_cast<std::int64_t>(list.draws.size()), [&](std::int64_t i) {
    const DrawState& draw = list.draws[static_cast<std::size_t>(i)];
    if (draw.pass == Pass::Dome) return;  // its vertices are not positions
    if (!list.vertex_programs[static_cast<std::size_t>(draw.vertex_program)].program.straight_line()) return;
    const std::optional<Bounds> bounds = bounds_of(*draw.mesh, list.space);
    list.raster_draws[static_cast<std::size_t>(i)].outside = bounds && outside(*bounds, world_to_clip, range);
  });
}

void count_unshaded_vertices(std::size_t vertices, vm::Counters& counters) {
  for (vm::BlockCount& block : counters.blocks) {
    block.executions += (vertices + vm::kLanes - 1) / vm::kLanes;
    block.covered_lanes += vertices;
  }
}

}  // namespace aluminate::passes
