// Surfaces with normals and uv: the building blocks of the sample scenes. All are counter-clockwise from
// outside.
#pragma once

#include "scenes/generator/model.hpp"

#include <functional>

namespace aluminate::scenes::generator {

/// (nu x nv) quads over position(u, v), u and v in [0, 1]; outside is cross(d/du, d/dv). uv = (u, v) *
/// uv_size. Normals are summed over the faces around a vertex, across the seam too when `wraps_u`.
Surface patch(int nu, int nv, const std::function<glm::dvec3(double, double)>& position,
              const glm::dvec2& uv_size, bool wraps_u = false);

/// Unit direction normals; no degenerate triangles at the poles.
Surface sphere(double radius, int slices, int stacks, const glm::dvec2& uv_size);

/// Half extents; each face's uv measures metres times uv_per_metre, grain (v) along the box's longest edge.
Surface box(const glm::dvec3& half, double uv_per_metre);

/// Upright, from y = 0 to height, closed at the top when top_radius > 0 and `capped`.
Surface tapered_cylinder(double bottom_radius, double top_radius, double height, int sides, int rings,
                         const glm::dvec2& uv_size, bool capped);

/// Body of revolution about y through the profile points (radius, y), bottom to top.
Surface lathe(const std::vector<glm::dvec2>& profile, int sides, const glm::dvec2& uv_size);

/// Rectangle in the plane z = 0 facing +z, centred.
Surface card(double width, double height, const glm::dvec2& uv_size);

}  // namespace aluminate::scenes::generator
