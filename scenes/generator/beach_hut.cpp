// A plank hut on a tropical beach, hours before sunset. Outside: sand, blended water, alpha-tested palms and
// thatch under a sun and a sky light. Inside: a table in the light of a lantern, windows to the sea. The hut
// faces +z, the sea lies at +x. Nothing casts shadows at run time, so corners and the room are darkened in
// the vertex colours.
#include "scenes/generator/beach_hut_parts.hpp"
#include "scenes/generator/sample_models.hpp"
#include "scenes/generator/shapes.hpp"
#include "scenes/trigonometry.hpp"

#include <algorithm>
#include <cmath>

namespace aluminate::scenes::generator {
namespace {

struct Palm {
  double x, z, turn, size;
};
constexpr Palm kPalms[] = {{-3.6, -1.0, 200, 1.05}, {3.2, -2.7, -25, 1.2}, {-5.4, -4.2, 120, 1.25},
                           {-0.9, -4.8, 75, 1.3},   {-8.2, 0.6, 160, 1.1}, {5.6, -6.8, -60, 1.15}};
constexpr Palm kBushes[] = {{-3.0, 1.3, 270, 0.3}, {-4.4, 0.2, 20, 0.42},  {2.9, -0.9, 300, 0.34},
                            {-6.2, -1.6, 90, 0.5}, {-2.2, -3.6, 130, 0.5}, {4.2, -4.4, 45, 0.45},
                            {-5.6, 3.2, 230, 0.26}};

/// How much of the sky the sand sees: less under the hut and around what stands on it.
double open_sky(double x, double z) {
  const double from_hut = std::max(std::fabs(x - 0.25) - 2.1, std::fabs(z - 0.5) - 2.45);
  double light = 0.12 + 0.88 * smooth_step(-0.25, 0.85, from_hut);
  for (const Palm& palm : kPalms) {
    const double dx = x - palm.x - 0.15, dz = z - palm.z + 0.15;
    light *= 1 - 0.5 * smooth_step(0.75, 0.15, std::sqrt(dx * dx + dz * dz));
  }
  for (const Palm& bush : kBushes) {
    const double dx = x - bush.x - 0.1, dz = z - bush.z + 0.1;
    light *= 1 - 0.55 * smooth_step(2.4 * bush.size, 0.3 * bush.size, std::sqrt(dx * dx + dz * dz));
  }
  return light;
}

void add_land_and_sea(Model& model, const HutPaint& paint) {
  Surface sand = patch(
      46, 46,
      [](double u, double v) {
        // About 0.3 m apart around the hut, where the baked shadows are; coarse towards the horizon.
        const double s = 2 * u - 1, t = 2 * v - 1;
        const glm::dvec2 at(7 * s + 31 * s * s * s * s * s, -7 * t - 31 * t * t * t * t * t);
        return glm::dvec3(at.x, ground_height(at.x, at.y), at.y);
      },
      glm::dvec2(1));
  for (std::size_t i = 0; i < sand.positions.size(); ++i) {
    const glm::dvec3& p = sand.positions[i];
    sand.uv[i] = glm::dvec2(p.x, p.z) * 0.45;
    const double wet = smooth_step(-0.55, -0.1, p.y);
    sand.colors.push_back(glm::dvec4(glm::dvec3(0.52, 0.46, 0.42) + glm::dvec3(0.48, 0.54, 0.58) * wet, 1) *
                          glm::dvec4(glm::dvec3(open_sky(p.x, p.z)), 1));
  }
  sand.add_tangents();
  model.place("sand", model.add_mesh("sand", sand, paint.sand));

  Surface water = patch(
      10, 16, [](double u, double v) { return glm::dvec3(2 + u * u * 60, -0.32, 60 - 120 * v); },
      glm::dvec2(1));
  for (std::size_t i = 0; i < water.positions.size(); ++i)
    water.uv[i] = glm::dvec2(water.positions[i].x, water.positions[i].z) * 0.22;
  water.add_tangents();
  const int water_mesh = model.add_mesh("water", water, paint.water);

  // Seen from within: the patch turns the other way round.
  Surface sky = patch(
      32, 12,
      [](double u, double v) {
        const SinCos east = sin_cos(-2 * kPi * u), up = sin_cos(kPi * (0.62 * v - 0.12));
        return 70.0 * glm::dvec3(up.cos * east.sin, up.sin, up.cos * east.cos);
      },
      glm::dvec2(1), true);
  sky.uv.clear();
  for (const glm::dvec3& p : sky.positions) {
    const double height = p.y / 70, glow = smooth_step(-0.2, 1, (-p.x * 0.55 - p.z * 0.83) / 70);
    const glm::dvec3 horizon = glm::dvec3(0.80, 0.62, 0.42) + glm::dvec3(0.12, 0.02, -0.1) * glow;
    const glm::dvec3 zenith(0.10, 0.27, 0.52);
    const double t = smooth_step(-0.03, 0.62, height);
    sky.colors.push_back(glm::dvec4(horizon + (zenith - horizon) * std::sqrt(t), 1));
  }
  model.place("sky", model.add_mesh("sky", sky, paint.sky));

  // Headlands behind the beach.
  const int hill = model.add_mesh("hill", boulder(1, 24, 12, 0.35, 17), paint.jungle);
  model.place("headland", hill, moved(glm::dvec3(-26, -2, -38)) * scaled(glm::dvec3(20, 9, 9)));
  model.place("headland", hill,
              moved(glm::dvec3(-4, -2, -47)) * turned_y(100) * scaled(glm::dvec3(9, 7, 17)));
  model.place("headland", hill,
              moved(glm::dvec3(-44, -2, -10)) * turned_y(40) * scaled(glm::dvec3(12, 8, 18)));

  const int rock = model.add_mesh("rock", boulder(0.5, 16, 9, 0.4, 5), paint.rock);
  const double rocks[][4] = {{5.4, -0.30, 1.2, 1.4},
                             {6.4, -0.38, 0.2, 0.9},
                             {4.9, -0.25, -0.3, 0.6},
                             {7.6, -0.42, -4.0, 1.9},
                             {5.9, -0.3, 4.6, 0.5}};
  for (const auto& r : rocks)
    model.place("rock", rock,
                moved(glm::dvec3(r[0], r[1], r[2])) * turned_y(r[3] * 200) *
                    scaled(glm::dvec3(r[3], r[3] * 0.75, r[3])));
  model.place("water", water_mesh);  // blended: after what lies behind it
}

void add_palms(Model& model, const HutPaint& paint) {
  const int trunk = model.add_mesh("trunk", palm_trunk(), paint.bark),
            crown = model.add_mesh("crown", palm_crown(), paint.leaf);
  const int nut = model.add_mesh("coconut", sphere(0.13, 12, 8, glm::dvec2(1)), paint.coconut);
  for (const Palm& palm : kPalms) {
    const glm::dmat4 place = moved(glm::dvec3(palm.x, ground_height(palm.x, palm.z) - 0.05, palm.z)) *
                             turned_y(palm.turn) * scaled(glm::dvec3(palm.size));
    model.place("palm trunk", trunk, place);
    model.place("palm crown", crown, place * moved(trunk_tip()));
    for (int i = 0; i < 3; ++i)
      model.place("coconut", nut,
                  place * moved(trunk_tip()) * turned_y(120 * i + 30) * moved(glm::dvec3(0.17, -0.12, 0)));
  }
  for (const Palm& bush : kBushes)
    model.place("bush", crown,
                moved(glm::dvec3(bush.x, ground_height(bush.x, bush.z) + 0.12, bush.z)) *
                    turned_y(bush.turn) * scaled(glm::dvec3(bush.size, bush.size * 1.7, bush.size)));
}

void add_furniture(Model& model, const HutPaint& paint) {
  const double floor = kFloorHeight;
  Surface table;
  for (int i = 0; i < 4; ++i) {
    Surface plank = box(glm::dvec3(0.6, 0.025, 0.095), 0.9);
    plank.tint(glm::dvec4(glm::dvec3(0.62 + 0.09 * (i * 7 % 4)), 1));
    table.append(plank, moved(glm::dvec3(0, 0.76, -0.3 + 0.2 * i)));
  }
  for (const double x : {-0.5, 0.5}) {
    for (const double z : {-0.3, 0.3}) {
      Surface leg = box(glm::dvec3(0.035, 0.37, 0.035), 0.9);
      leg.tint(glm::dvec4(glm::dvec3(0.45), 1));
      table.append(leg, moved(glm::dvec3(x, 0.37, z)));
    }
  }
  const glm::dmat4 at_table = moved(glm::dvec3(0.75, floor, -0.35)) * turned_y(-12);
  model.place("table", model.add_mesh("table", table, paint.wood), at_table);

  Surface stool = tapered_cylinder(0.2, 0.17, 0.45, 14, 2, glm::dvec2(2, 1), true);
  stool.tint(glm::dvec4(glm::dvec3(0.6), 1));
  const int stool_mesh = model.add_mesh("stool", stool, paint.wood);
  model.place("stool", stool_mesh, moved(glm::dvec3(-0.15, floor, -0.75)));
  model.place("stool", stool_mesh, moved(glm::dvec3(0.95, floor, 0.5)));

  const std::vector<glm::dvec2> bowl_profile{{0.05, 0.0},   {0.12, 0.02}, {0.2, 0.09},  {0.235, 0.16},
                                             {0.22, 0.158}, {0.185, 0.1}, {0.1, 0.045}, {0.0, 0.035}};
  model.place("bowl", model.add_mesh("bowl", lathe(bowl_profile, 28, glm::dvec2(1)), paint.ceramic),
              at_table * moved(glm::dvec3(-0.1, 0.785, 0.02)));
  const int fruit = model.add_mesh("fruit", sphere(0.075, 18, 10, glm::dvec2(1)), paint.fruit);
  for (const glm::dvec3& p :
       {glm::dvec3(-0.16, 0.9, 0.05), glm::dvec3(-0.03, 0.9, 0.07), glm::dvec3(-0.1, 0.9, -0.07),
        glm::dvec3(-0.09, 0.985, 0.02), glm::dvec3(0.27, 0.86, 0.2)})
    model.place("fruit", fruit, at_table * moved(p));

  const std::vector<glm::dvec2> lantern_profile{{0.0, -0.02}, {0.09, 0.0}, {0.1, 0.03}, {0.06, 0.05}};
  const std::vector<glm::dvec2> cap_profile{
      {0.07, 0.25}, {0.11, 0.26}, {0.05, 0.32}, {0.015, 0.36}, {0.012, 1.0}};
  Surface metal = lathe(lantern_profile, 18, glm::dvec2(1));
  metal.append(lathe(cap_profile, 18, glm::dvec2(1)));
  const glm::dvec3 lamp(0.35, floor + 1.5, -0.2);
  model.place("lantern", model.add_mesh("lantern", metal, paint.brass), moved(lamp));
  model.place("flame", model.add_mesh("flame", sphere(0.065, 16, 10, glm::dvec2(1)), paint.glow),
              moved(lamp + glm::dvec3(0, 0.14, 0)));
  model.add_light("lantern", "point", glm::dvec3(1, 0.62, 0.28), 4.2, lamp + glm::dvec3(0, 0.14, 0),
                  glm::dvec3(0), 5);

  const std::vector<glm::dvec2> bottle_profile{{0.0, 0.0},    {0.055, 0.0},  {0.06, 0.02},  {0.06, 0.17},
                                               {0.045, 0.21}, {0.018, 0.25}, {0.018, 0.31}, {0.022, 0.315}};
  model.place("bottle", model.add_mesh("bottle", lathe(bottle_profile, 20, glm::dvec2(1)), paint.glass),
              at_table * moved(glm::dvec3(0.36, 0.785, -0.12)));

  // A surfboard leans at the porch.
  Surface board = sphere(1, 24, 14, glm::dvec2(1));
  for (const glm::dvec3& p : board.positions)
    board.colors.push_back(std::fabs(p.x) < 0.16 ? glm::dvec4(0.9, 0.86, 0.78, 1)
                                                 : glm::dvec4(0.75, 0.09, 0.05, 1));
  model.place("surfboard", model.add_mesh("surfboard", board, paint.lacquer),
              moved(glm::dvec3(1.72, floor + 0.98, 1.86)) * turned_x(-11) * turned_z(4) *
                  scaled(glm::dvec3(0.27, 1.08, 0.045)));
}

}  // namespace

Model make_beach_hut() {
  Model model("beach_hut");
  const HutPaint paint = paint_hut(model);
  model.add_camera("outside", glm::dvec3(-3.9, 1.75, 8.6), glm::dvec3(0.75, 1.55, 0), 44, 0.1);
  model.add_camera("inside", glm::dvec3(-1.62, 1.98, -1.22), glm::dvec3(1.0, 1.28, 0.62), 62, 0.05);
  model.place("hut", model.add_mesh("hut", hut_planks(), paint.wood));
  model.place("thatch", model.add_mesh("thatch", thatch_roof(), paint.thatch));
  add_furniture(model, paint);
  add_palms(model, paint);
  add_land_and_sea(model, paint);
  model.add_light("sun", "directional", glm::dvec3(1, 0.82, 0.58), 4.6, glm::dvec3(-5.5, 5, 6.5));
  model.add_light("sky", "directional", glm::dvec3(0.5, 0.7, 1), 1.3, glm::dvec3(2.5, 6, -2));
  model.add_light("bounce", "directional", glm::dvec3(1, 0.8, 0.55), 0.55, glm::dvec3(2, -3, 4));
  return model;
}

}  // namespace aluminate::scenes::generator
