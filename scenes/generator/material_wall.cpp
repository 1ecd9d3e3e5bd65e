// Spheres on the ledges of a plastered wall. Columns: gloss g = 0 .. 1, specular power m = 2^(13 g). Rows,
// top to bottom: lacquer (dielectric), hammered glaze (dielectric), bronze half way to metal, hammered
// copper, gold (metals). The picture to compare visibility terms with: every gloss meets every kind of
// reflectance under the same four lights.
#include "scenes/generator/paint.hpp"
#include "scenes/generator/sample_models.hpp"
#include "scenes/generator/shapes.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace aluminate::scenes::generator {
namespace {

constexpr int kColumns = 8;
constexpr double kSpacing = 1.14, kRadius = 0.45, kRowHeight = 1.18;

/// glTF roughness of gloss g, a multiple of 1/7: m = 2^(13 g) and m = 2 / roughness^4 - 2. 2^(k/7) is a
/// table, not a pow.
double roughness_of_gloss(double g) {
  constexpr std::array<double, 7> kSevenths{1.0,
                                            1.1040895136738123,
                                            1.2190136542044754,
                                            1.3459001926323563,
                                            1.4859942891369485,
                                            1.6406707120152757,
                                            1.8114473285278133};
  const int steps = static_cast<int>(std::lround(13 * g * 7));
  const double m = std::ldexp(kSevenths[static_cast<std::size_t>(steps % 7)], steps / 7);
  return std::sqrt(std::sqrt(2 / (m + 2)));
}

double dents(double u, double v) {
  // Overlapping shallow dents: distance to the nearest of one jittered centre per cell.
  constexpr int kCells = 5;
  double nearest = 9;
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      const double cx = std::floor(u * kCells) + i, cy = std::floor(v * kCells) + j;
      const double px = cx + 0.2 + 0.6 * noise(cx, cy, kCells, kCells, 11),
                   py = cy + 0.2 + 0.6 * noise(cx, cy, kCells, kCells, 12);
      const double dx = u * kCells - px, dy = v * kCells - py;
      nearest = std::min(nearest, dx * dx + dy * dy);
    }
  }
  return std::sqrt(nearest);
}

/// How much of the light a point of the wall keeps: less behind the balls and under the ledges, baked into
/// vertex colours.
double wall_light(double x, double y) {
  double light = 1;
  for (int row = 0; row < 5; ++row) {
    const double row_y = (2 - row) * kRowHeight, half_row = kColumns * kSpacing / 2;
    for (int c = 0; c < kColumns; ++c) {
      const double dx = x - (c - (kColumns - 1) / 2.0) * kSpacing - 0.05, dy = y - row_y + 0.06;
      light *= 1 - 0.62 * smooth_step(0.64, 0.25, std::sqrt(dx * dx + dy * dy));
    }
    const double below = row_y - kRadius - 0.08 - y;  // under this row's ledge
    if (std::fabs(x) < half_row + 0.15 && below > -0.1) light *= 1 - 0.55 * smooth_step(0.42, 0.0, below);
  }
  return light;
}

void add_wall(Model& model) {
  const int plaster = model.add_texture("plaster", paint_rgb(128, 128, [](double u, double v) {
                                          const double n = cloudy(u, v, 4, 4, 4, 1);
                                          return glm::dvec3(0.50, 0.475, 0.46) * (0.84 + 0.24 * n);
                                        }));
  const int bumps = model.add_texture(
      "plaster_normal",
      paint_normals(128, 128, 0.012, [](double u, double v) { return cloudy(u, v, 6, 6, 3, 5); }));
  const double width = kColumns * kSpacing + 5, height = 5 * kRowHeight + 4;
  Surface wall = patch(
      50, 36,
      [&](double u, double v) { return glm::dvec3((u - 0.5) * width, (v - 0.5) * height, -kRadius - 0.06); },
      glm::dvec2(width, height) * 0.5);
  for (const glm::dvec3& p : wall.positions)
    wall.colors.push_back(glm::dvec4(glm::dvec3(wall_light(p.x, p.y)), 1));
  wall.add_tangents();
  model.place(
      "wall",
      model.add_mesh("wall", wall,
                     model.add_material(pbr_material("plaster", glm::dvec4(1), 0, 0.8, plaster, bumps))));

  const int grain =
      model.add_texture("walnut", paint_rgb(64, 128, [](double u, double v) {
                          const double rings = cloudy(u, v, 14, 2, 3, 21), fine = cloudy(u, v, 32, 4, 2, 22);
                          return glm::dvec3(0.36, 0.22, 0.13) * (0.7 + 0.45 * rings + 0.15 * fine);
                        }));
  const int walnut = model.add_material(pbr_material("walnut", glm::dvec4(1), 0, 0.45, grain));
  const int ledge =
      model.add_mesh("ledge", box(glm::dvec3(kColumns * kSpacing / 2 + 0.12, 0.04, 0.36), 0.7), walnut);
  for (int row = 0; row < 5; ++row)
    model.place("ledge", ledge,
                moved(glm::dvec3(0, (1.5 - row) * kRowHeight + kRowHeight * 0.5 - kRadius - 0.04, -0.15)));
}

}  // namespace

Model make_material_wall() {
  Model model("material_wall");
  add_wall(model);

  const int hammered = model.add_texture("hammered_normal", paint_normals(128, 128, 0.05, dents));
  Surface ball = sphere(kRadius, 28, 16, glm::dvec2(6, 3));
  ball.add_tangents();
  const ordered_json ball_surface = model.add_surface(ball);

  struct Row {
    const char* name;
    glm::dvec3 color;
    double metallic;
    bool is_hammered;
  };
  const std::array<Row, 5> rows{Row{"lacquer", glm::dvec3(0.42, 0.028, 0.02), 0, false},
                                Row{"glaze", glm::dvec3(0.03, 0.19, 0.2), 0, true},
                                Row{"bronze", glm::dvec3(0.55, 0.36, 0.2), 0.5, false},
                                Row{"copper", glm::dvec3(0.955, 0.638, 0.538), 1, true},
                                Row{"gold", glm::dvec3(1.0, 0.766, 0.336), 1, false}};
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const double gloss = static_cast<double>(c) / (kColumns - 1);
      const std::string name = fmt::format("{} g{}/{}", rows[r].name, c, kColumns - 1);
      const int material = model.add_material(pbr_material(name, glm::dvec4(rows[r].color, 1),
                                                           rows[r].metallic, roughness_of_gloss(gloss), -1,
                                                           rows[r].is_hammered ? hammered : -1));
      const glm::dvec3 place((c - (kColumns - 1) / 2.0) * kSpacing, (2 - static_cast<double>(r)) * kRowHeight,
                             0);
      // Each ball turned another way, so that the dents do not repeat along the row.
      model.place(name, model.add_mesh(name, ball_surface, material),
                  moved(place) * turned_y(47.0 * c + 90.0 * static_cast<double>(r)));
    }
  }

  model.add_camera("front", glm::dvec3(-1.6, 0.9, 13.2), glm::dvec3(0, -0.05, 0), 29, 0.5);
  model.add_light("key", "directional", glm::dvec3(1, 0.95, 0.88), 3.0, glm::dvec3(-4, 6, 7));
  model.add_light("window", "point", glm::dvec3(0.55, 0.75, 1), 60, glm::dvec3(5.6, 2.6, 3.4));
  model.add_light("lamp", "point", glm::dvec3(1, 0.68, 0.35), 42, glm::dvec3(-5.2, -2.4, 2.6));
  model.add_light("crown", "point", glm::dvec3(1, 0.9, 0.8), 36, glm::dvec3(0.6, 4.6, 2.0));
  return model;
}

}  // namespace aluminate::scenes::generator
