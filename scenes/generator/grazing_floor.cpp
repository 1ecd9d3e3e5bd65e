// A long hall of stone tiles between two rows of columns, seen from low down: normal and gloss maps at
// grazing angles, where minification, highlight shape and the visibility term matter most.
#include "scenes/generator/paint.hpp"
#include "scenes/generator/sample_models.hpp"
#include "scenes/generator/shapes.hpp"

#include "scenes/trigonometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace aluminate::scenes::generator {
namespace {

constexpr double kHallLength = 44, kHallWidth = 9, kBay = 4;
constexpr int kBays = 10;

struct Tile {
  double edge;  // distance to the nearest joint, in tiles
  int i, j;
};

/// Four by four tiles across the texture, every second row shifted by half a tile.
Tile tile_at(double u, double v) {
  const int j = static_cast<int>(std::floor(v * 4));
  const double x = u * 4 + (j % 2 == 0 ? 0 : 0.5), y = v * 4;
  const double fx = x - std::floor(x), fy = y - std::floor(y);
  return {std::min({fx, 1 - fx, fy, 1 - fy}), (static_cast<int>(std::floor(x)) % 4 + 4) % 4, (j % 4 + 4) % 4};
}

double tile_height(double u, double v) {
  const Tile tile = tile_at(u, v);
  return smooth_step(0.0, 0.07, tile.edge) + 0.05 * cloudy(u, v, 8, 8, 3, 31);
}

int add_floor_material(Model& model) {
  const int color = model.add_texture(
      "stone", paint_rgb(128, 128, [](double u, double v) {
        const Tile tile = tile_at(u, v);
        const bool is_dark = (tile.i + tile.j) % 3 == 0;
        const glm::dvec3 stone = is_dark ? glm::dvec3(0.33, 0.29, 0.28) : glm::dvec3(0.68, 0.60, 0.50);
        const double vein = 0.86 + 0.28 * cloudy(u, v, 6, 6, 3, static_cast<std::uint32_t>(40 + tile.i));
        return stone * vein * (0.45 + 0.55 * smooth_step(0.01, 0.05, tile.edge));
      }));
  const int normal = model.add_texture("stone_normal", paint_normals(128, 128, 0.009, tile_height));
  const int gloss = model.add_texture(
      "stone_gloss", paint_rgb(128, 128, [](double u, double v) {
        const Tile tile = tile_at(u, v);
        const double polish = noise(tile.i, tile.j, 4, 4, 77);
        const double worn = cloudy(u, v, 4, 4, 2, 55);
        const double rough = 0.24 + 0.16 * polish + 0.16 * worn;
        return glm::dvec3(0, rough + (0.85 - rough) * (1 - smooth_step(0.02, 0.05, tile.edge)), 0);
      }));
  return model.add_material(pbr_material("tiles", glm::dvec4(1), 0, 1, color, normal, gloss));
}

}  // namespace

Model make_grazing_floor() {
  Model model("grazing_floor");
  const int tiles = add_floor_material(model);
  Surface floor = patch(
      18, 88,
      [](double u, double v) { return glm::dvec3((u - 0.5) * kHallWidth, 0, 4 - v * (kHallLength + 4)); },
      glm::dvec2(kHallWidth, kHallLength + 4) * 0.4);
  floor.add_tangents();
  model.place("floor", model.add_mesh("floor", floor, tiles));

  const int limestone =
      model.add_material(pbr_material("limestone", glm::dvec4(0.55, 0.47, 0.38, 1), 0, 0.6));
  const int dark = model.add_material(pbr_material("basalt", glm::dvec4(0.05, 0.05, 0.055, 1), 0, 0.35));
  const int bronze = model.add_material(pbr_material("bronze", glm::dvec4(0.8, 0.5, 0.25, 1), 1, 0.35));
  ordered_json glow = pbr_material("lamp glass", glm::dvec4(1, 1, 1, 1), 0, 0.5);
  glow["emissiveFactor"] = {1.0, 0.72, 0.4};
  glow["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 2;
  const int lamp_glass = model.add_material(glow);

  // Fluted shaft on a round base, square plinth and capital.
  Surface shaft = patch(
      48, 10,
      [](double u, double v) {
        const SinCos a = sin_cos(2 * kPi * u), flute = sin_cos(2 * kPi * u * 16);
        const double r = (0.34 - 0.05 * v) * (1 + 0.035 * flute.cos);
        return glm::dvec3(a.sin * r, 0.42 + 3.4 * v, a.cos * r);
      },
      glm::dvec2(1), true);
  const std::vector<glm::dvec2> base_profile{{0.50, 0.20}, {0.54, 0.24}, {0.53, 0.30},
                                             {0.46, 0.34}, {0.41, 0.37}, {0.37, 0.42}};
  shaft.append(lathe(base_profile, 32, glm::dvec2(1)));
  const std::vector<glm::dvec2> top_profile{{0.30, 3.80}, {0.34, 3.84}, {0.34, 3.90}, {0.50, 4.05}};
  shaft.append(lathe(top_profile, 32, glm::dvec2(1)));
  shaft.append(box(glm::dvec3(0.52, 0.10, 0.52), 1), moved(glm::dvec3(0, 4.15, 0)));
  const int column = model.add_mesh("column", shaft, limestone);
  const int plinth = model.add_mesh("plinth", box(glm::dvec3(0.58, 0.1, 0.58), 1), dark);

  const int lintel =
      model.add_mesh("lintel", box(glm::dvec3(0.45, 0.35, kBay * kBays / 2.0 + 1.5), 1), limestone);
  const int wall =
      model.add_mesh("wall", box(glm::dvec3(0.2, 2.6, kBay * kBays / 2.0 + 3), 1),
                     model.add_material(pbr_material("wall", glm::dvec4(0.22, 0.16, 0.13, 1), 0, 0.9)));
  const int globe = model.add_mesh("globe", sphere(0.16, 20, 12, glm::dvec2(1)), lamp_glass);
  Surface stand_surface = tapered_cylinder(0.05, 0.03, 1.5, 10, 1, glm::dvec2(1), false);
  const std::vector<glm::dvec2> foot{{0.24, 0.0}, {0.22, 0.05}, {0.08, 0.09}, {0.05, 0.2}};
  stand_surface.append(lathe(foot, 16, glm::dvec2(1)));
  const int stand = model.add_mesh("stand", stand_surface, bronze);
  const int ball = model.add_mesh("ball", sphere(0.42, 32, 18, glm::dvec2(1)), dark);

  for (const double side : {-1.0, 1.0}) {
    const std::string name = side < 0 ? "left" : "right";
    for (int i = 0; i < kBays; ++i) {
      const double z = -2.0 - kBay * i;
      model.place(name + " column", column, moved(glm::dvec3(side * 3.1, 0, z)));
      model.place(name + " plinth", plinth, moved(glm::dvec3(side * 3.1, 0.1, z)));
    }
    model.place(name + " lintel", lintel, moved(glm::dvec3(side * 3.1, 4.6, -kBay * kBays / 2.0)));
    model.place(name + " wall", wall,
                moved(glm::dvec3(side * (kHallWidth / 2 + 0.2), 2.6, -kBay * kBays / 2.0)));
  }
  model.place("end wall",
              model.add_mesh("end wall", box(glm::dvec3(kHallWidth / 2 + 0.4, 2.6, 0.2), 1),
                             model.add_material(pbr_material("apse", glm::dvec4(0.3, 0.2, 0.14, 1), 0, 0.8))),
              moved(glm::dvec3(0, 2.6, -kHallLength)));
  model.place("ball", ball, moved(glm::dvec3(0.9, 0.42, -6.2)));

  struct Lamp {
    glm::dvec3 foot, color;
    double candela;
  };
  const std::array<Lamp, 4> lamps{
      Lamp{{-1.9, 0, -7.5}, {1, 0.72, 0.42}, 16}, Lamp{{1.9, 0, -14}, {1, 0.66, 0.36}, 20},
      Lamp{{-1.9, 0, -22}, {1, 0.72, 0.42}, 24}, Lamp{{1.9, 0, -32}, {1, 0.6, 0.3}, 30}};
  for (const Lamp& lamp : lamps) {
    model.place("stand", stand, moved(lamp.foot));
    model.place("globe", globe, moved(lamp.foot + glm::dvec3(0, 1.62, 0)));
    model.add_light("lamp", "point", lamp.color, lamp.candela, lamp.foot + glm::dvec3(0, 1.62, 0),
                    glm::dvec3(0), 18);
  }
  model.add_light("moon", "directional", glm::dvec3(0.5, 0.65, 1), 1.1, glm::dvec3(2.2, 3, -6));
  model.add_light("sky", "directional", glm::dvec3(0.55, 0.6, 0.8), 0.35, glm::dvec3(-1, 4, 3));
  model.add_camera("low", glm::dvec3(-0.75, 0.95, 2.6), glm::dvec3(0.1, 1.15, -12), 52, 0.1);
  return model;
}

}  // namespace aluminate::scenes::generator
