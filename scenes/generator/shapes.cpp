#include "scenes/generator/shapes.hpp"

#include "scenes/trigonometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace aluminate::scenes::generator {
namespace {

glm::dvec3 unit_or_up(const glm::dvec3& v) {
  const double length = std::sqrt(glm::dot(v, v));
  return length > 1e-12 ? v / length : glm::dvec3(0, 1, 0);
}

void add_quad(Surface& surface, const std::array<glm::dvec3, 4>& corners, const glm::dvec3& normal,
              const glm::dvec2& uv_size) {
  const auto base = static_cast<std::uint32_t>(surface.positions.size());
  constexpr std::array<glm::dvec2, 4> kUnit{glm::dvec2(0, 1), glm::dvec2(1, 1), glm::dvec2(1, 0),
                                            glm::dvec2(0, 0)};
  for (std::size_t i = 0; i < 4; ++i) {
    surface.positions.push_back(corners[i]);
    surface.normals.push_back(normal);
    surface.uv.push_back(kUnit[i] * uv_size);
  }
  for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) surface.indices.push_back(base + i);
}

}  // namespace

Surface patch(int nu, int nv, const std::function<glm::dvec3(double, double)>& position,
              const glm::dvec2& uv_size, bool wraps_u) {
  Surface surface;
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * (nu + 1) + i); };
  for (int j = 0; j <= nv; ++j) {
    for (int i = 0; i <= nu; ++i) {
      const double u = static_cast<double>(i) / nu, v = static_cast<double>(j) / nv;
      surface.positions.push_back(position(wraps_u && i == nu ? 0 : u, v));
      surface.uv.push_back(glm::dvec2(u, v) * uv_size);
    }
  }
  surface.normals.assign(surface.positions.size(), glm::dvec3(0));
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const glm::dvec3 face =
        glm::cross(surface.positions[b] - surface.positions[a], surface.positions[c] - surface.positions[a]);
    if (glm::dot(face, face) < 1e-20) return;  // a pole
    for (const std::uint32_t k : {a, b, c}) {
      surface.normals[k] += face;
      surface.indices.push_back(k);
    }
  };
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nu; ++i) {
      add(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      add(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  if (wraps_u) {
    for (int j = 0; j <= nv; ++j) {
      const glm::dvec3 sum = surface.normals[at(0, j)] + surface.normals[at(nu, j)];
      surface.normals[at(0, j)] = surface.normals[at(nu, j)] = sum;
    }
  }
  for (auto& n : surface.normals) n = unit_or_up(n);
  return surface;
}

Surface sphere(double radius, int slices, int stacks, const glm::dvec2& uv_size) {
  // u runs east, v north to south, so that v grows downwards like the rows of an image.
  const auto direction = [](double u, double v) {
    const SinCos east = sin_cos(2 * kPi * u), south = sin_cos(kPi * v);
    return glm::dvec3(south.sin * east.sin, south.cos, south.sin * east.cos);
  };
  Surface surface = patch(
      slices, stacks, [&](double u, double v) { return radius * direction(u, 1 - v); }, uv_size, true);
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    surface.normals[i] = unit_or_up(surface.positions[i]);
    surface.uv[i].y = uv_size.y - surface.uv[i].y;
  }
  return surface;
}

Surface box(const glm::dvec3& half, double uv_per_metre) {
  Surface surface;
  const int longest = half.x >= half.y && half.x >= half.z ? 0 : half.y >= half.z ? 1 : 2;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      glm::dvec3 normal(0), across(0), along(0);
      normal[axis] = side;
      // `along` carries v: the longest edge if it lies in this face.
      const int b = axis != longest ? longest : (axis + 2) % 3;
      const int a = 3 - axis - b;
      along[b] = half[b];
      across[a] = half[a];
      if (glm::dot(glm::cross(across, along), normal) < 0) across = -across;
      const glm::dvec3 centre = normal * half[axis];
      add_quad(surface,
               {centre - across - along, centre + across - along, centre + across + along,
                centre - across + along},
               normal, glm::dvec2(2 * half[a], 2 * half[b]) * uv_per_metre);
    }
  }
  return surface;
}

Surface tapered_cylinder(double bottom_radius, double top_radius, double height, int sides, int rings,
                         const glm::dvec2& uv_size, bool capped) {
  Surface surface = patch(
      sides, rings,
      [&](double u, double v) {
        const SinCos a = sin_cos(2 * kPi * u);
        const double r = bottom_radius + (top_radius - bottom_radius) * v;
        return glm::dvec3(a.sin * r, height * v, a.cos * r);
      },
      uv_size, true);
  if (!capped) return surface;
  const auto base = static_cast<std::uint32_t>(surface.positions.size());
  for (int i = 0; i <= sides; ++i) {  // the last one is the centre
    const SinCos a = sin_cos(2 * kPi * i / sides);
    const double r = i < sides ? top_radius : 0;
    surface.positions.push_back(glm::dvec3(a.sin * r, height, a.cos * r));
    surface.normals.push_back(glm::dvec3(0, 1, 0));
    surface.uv.push_back(glm::dvec2(a.sin, a.cos) * (i < sides ? 0.5 : 0.0) + 0.5);
  }
  for (int i = 0; i < sides; ++i)
    for (const int k : {i, (i + 1) % sides, sides})
      surface.indices.push_back(base + static_cast<std::uint32_t>(k));
  return surface;
}

Surface lathe(const std::vector<glm::dvec2>& profile, int sides, const glm::dvec2& uv_size) {
  const int rings = static_cast<int>(profile.size()) - 1;
  return patch(
      sides, rings,
      [&](double u, double v) {
        const SinCos a = sin_cos(2 * kPi * u);
        const glm::dvec2 p = profile[static_cast<std::size_t>(std::lround(v * rings))];
        return glm::dvec3(a.sin * p.x, p.y, a.cos * p.x);
      },
      uv_size, true);
}

Surface card(double width, double height, const glm::dvec2& uv_size) {
  Surface surface;
  const double x = width / 2, y = height / 2;
  add_quad(surface, {glm::dvec3(-x, -y, 0), glm::dvec3(x, -y, 0), glm::dvec3(x, y, 0), glm::dvec3(-x, y, 0)},
           glm::dvec3(0, 0, 1), uv_size);
  return surface;
}

}  // namespace aluminate::scenes::generator
