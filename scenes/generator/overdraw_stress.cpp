// A tunnel of cards in front of each other, in an order that is neither front to back nor back to front:
// opaque rings, rings cut out by an alpha mask, tinted glass. Every pixel is covered many times; no two
// counts of hidden work agree by luck.
#include "scenes/generator/paint.hpp"
#include "scenes/generator/sample_models.hpp"
#include "scenes/generator/shapes.hpp"
#include "scenes/trigonometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace aluminate::scenes::generator {
namespace {

constexpr int kLayers = 30;

/// A flat ring between two radii, facing +z; uv covers the disc twice.
Surface ring(double inner, double outer, int sides) {
  Surface surface = patch(
      sides, 2,
      [&](double u, double v) {
        const SinCos a = sin_cos(2 * kPi * u);
        const double r = inner + (outer - inner) * v;
        return glm::dvec3(-a.sin * r, a.cos * r, 0.12 * v * (1 - v));
      },
      glm::dvec2(1), true);
  for (std::size_t i = 0; i < surface.positions.size(); ++i)
    surface.uv[i] =
        glm::dvec2(surface.positions[i].x, -surface.positions[i].y) / outer + 0.5;  // twice around
  // The patch runs outwards as it turns: flip it to face the viewer.
  for (std::size_t i = 0; i < surface.indices.size(); i += 3)
    std::swap(surface.indices[i + 1], surface.indices[i + 2]);
  for (auto& n : surface.normals) n = n.z < 0 ? -n : n;
  return surface;
}

}  // namespace

Model make_overdraw_stress() {
  Model model("overdraw_stress");
  const int lace =
      model.add_texture("lace", paint_rgba(128, 128, [](double u, double v) {
                          const double x = u * 8, y = v * 8;
                          const double fx = x - std::floor(x) - 0.5, fy = y - std::floor(y) - 0.5;
                          const double d = std::sqrt(fx * fx + fy * fy);
                          const double thread = 0.85 + 0.15 * cloudy(u, v, 16, 16, 2, 3);
                          return glm::dvec4(glm::dvec3(0.95, 0.9, 0.82) * thread, smooth_step(0.28, 0.36, d));
                        }));
  const std::array<glm::dvec3, 5> tints{glm::dvec3(0.55, 0.035, 0.03), glm::dvec3(0.85, 0.33, 0.02),
                                        glm::dvec3(0.02, 0.26, 0.27), glm::dvec3(0.05, 0.06, 0.36),
                                        glm::dvec3(0.42, 0.03, 0.22)};
  std::array<int, 5> opaque{}, cut{}, glass{};
  for (std::size_t i = 0; i < tints.size(); ++i) {
    const double rough = 0.22 + 0.1 * static_cast<double>(i);
    opaque[i] =
        model.add_material(pbr_material(fmt::format("enamel {}", i), glm::dvec4(tints[i], 1), 0, rough));
    ordered_json masked =
        pbr_material(fmt::format("lace {}", i), glm::dvec4(glm::min(tints[i] * 1.3 + 0.06, glm::dvec3(1)), 1),
                     0, 0.6, lace);
    masked["alphaMode"] = "MASK";
    masked["doubleSided"] = true;
    cut[i] = model.add_material(masked);
    ordered_json clear = pbr_material(fmt::format("glass {}", i), glm::dvec4(tints[i], 0.22), 0, 0.15);
    clear["alphaMode"] = "BLEND";
    glass[i] = model.add_material(clear);
  }
  const ordered_json wide = model.add_surface(ring(0.74, 1.0, 48)),
                     thin = model.add_surface(ring(0.86, 0.97, 48));
  const ordered_json pane = model.add_surface(card(2.3, 2.3, glm::dvec2(1)));

  // Layers lie 0.55 apart; they are submitted in steps of 11 (coprime to 30), so the order jumps back and
  // forth.
  for (int step = 0; step < kLayers; ++step) {
    const int layer = step * 11 % kLayers;
    const auto tint = static_cast<std::size_t>(layer * 2 % 5);
    const double z = -0.55 * layer;
    const SinCos sway = sin_cos(0.42 * layer);
    const glm::dmat4 place = moved(glm::dvec3(0.42 * sway.sin, 0.3 * sway.cos - 0.3, z)) *
                             turned_z(9.0 * layer) * scaled(glm::dvec3(1.5, 1.5, 1));
    const std::string name = fmt::format("layer {}", layer);
    switch (layer % 3) {
      case 0:
        model.place(name, model.add_mesh(name, wide, opaque[tint]), place);
        break;
      case 1:
        model.place(name, model.add_mesh(name, wide, cut[tint]), place * scaled(glm::dvec3(1.12, 1.12, 1)));
        break;
      default:
        model.place(name, model.add_mesh(name, pane, glass[tint]), place * scaled(glm::dvec3(0.72, 0.72, 1)));
        model.place(name + " rim", model.add_mesh(name + " rim", thin, opaque[(tint + 1) % 5]), place);
        break;
    }
  }
  model.place(
      "heart",
      model.add_mesh("heart", sphere(0.8, 32, 18, glm::dvec2(1)),
                     model.add_material(pbr_material("gold", glm::dvec4(1, 0.766, 0.336, 1), 1, 0.42))),
      moved(glm::dvec3(0.1, -0.3, -0.55 * kLayers - 0.4)));
  model.add_camera("tunnel", glm::dvec3(0.3, 0.15, 4.4), glm::dvec3(0.05, -0.1, -4), 40, 0.2);
  model.add_light("key", "directional", glm::dvec3(1, 0.96, 0.9), 2.4, glm::dvec3(-5, 6, 5));
  model.add_light("rim", "directional", glm::dvec3(0.5, 0.7, 1), 0.9, glm::dvec3(6, -1, 2.5));
  model.add_light("depth", "point", glm::dvec3(1, 0.6, 0.3), 60, glm::dvec3(0.4, 0.6, -11));
  return model;
}

}  // namespace aluminate::scenes::generator
