#include "scenes/generator/beach_hut_parts.hpp"

#include "scenes/generator/shapes.hpp"
#include "scenes/trigonometry.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace aluminate::scenes::generator {
namespace {

// The room: x in +-2, z in +-1.6, walls 2.2 high; the porch reaches to z = 3.
constexpr double kHalfWidth = 2.0, kHalfDepth = 1.6, kWallHeight = 2.2, kPorchEdge = 2.9;

struct Opening {
  double from, to, low, high;  // along the wall; heights above the floor
};

/// Upright planks from `from` to `to` along a wall in the local plane z = 0, leaving openings free.
void add_wall(Surface& out, double from, double to, const std::vector<Opening>& openings,
              const glm::dmat4& placement, Dice& dice) {
  constexpr double kPlank = 0.2;
  const int count = static_cast<int>(std::lround((to - from) / kPlank));
  for (int i = 0; i < count; ++i) {
    const double x = from + (i + 0.5) * kPlank;
    std::vector<std::pair<double, double>> spans{{0.0, kWallHeight}};
    for (const Opening& o : openings) {
      if (x < o.from || x > o.to) continue;
      spans.clear();
      if (o.low > 0.05) spans.emplace_back(0.0, o.low);
      spans.emplace_back(o.high, kWallHeight);
    }
    const double shade = dice.between(0.72, 1.0), tilt = dice.between(-0.6, 0.6),
                 depth = dice.between(-0.012, 0.012);
    for (const auto& [low, high] : spans) {
      Surface plank = box(glm::dvec3(kPlank / 2 - 0.006, (high - low) / 2, 0.022), 0.9);
      plank.tint(glm::dvec4(shade, shade * 0.98, shade * 0.95, 1));
      // Daylight hardly reaches the room side (local -z); the foot of the wall is dark on both.
      for (std::size_t k = 0; k < plank.positions.size(); ++k) {
        const double height = plank.positions[k].y + (low + high) / 2;
        const double side = plank.normals[k].z < -0.5 ? 0.42 : 1.0;
        plank.colors[k] *= glm::dvec4(glm::dvec3(side * (0.62 + 0.38 * smooth_step(0.0, 0.7, height))), 1);
      }
      out.append(plank,
                 placement * moved(glm::dvec3(x, kFloorHeight + (low + high) / 2, depth)) * turned_z(tilt));
    }
  }
  for (const Opening& o : openings) {
    // A frame around each opening.
    const auto bar = [&](double cx, double cy, double hx, double hy) {
      Surface frame = box(glm::dvec3(hx, hy, 0.045), 0.9);
      frame.tint(glm::dvec4(0.5, 0.42, 0.35, 1));
      out.append(frame, placement * moved(glm::dvec3(cx, kFloorHeight + cy, 0)));
    };
    const double cx = (o.from + o.to) / 2, cy = (o.low + o.high) / 2, hx = (o.to - o.from) / 2,
                 hy = (o.high - o.low) / 2;
    bar(cx, o.high, hx + 0.06, 0.035);
    if (o.low > 0.05) bar(cx, o.low, hx + 0.09, 0.035);
    bar(o.from, cy, 0.035, hy);
    bar(o.to, cy, 0.035, hy);
  }
}

void add_floor(Surface& out, Dice& dice) {
  for (double z = -kHalfDepth; z < kPorchEdge - 0.05; z += 0.25) {
    const double shade = dice.between(0.7, 1.0);
    Surface plank = box(glm::dvec3(kHalfWidth + 0.12, 0.03, 0.12), 0.9);
    plank.tint(glm::dvec4(glm::dvec3(shade * (z < kHalfDepth - 0.1 ? 0.5 : 1.0)), 1));
    out.append(plank, moved(glm::dvec3(dice.between(-0.03, 0.03), kFloorHeight - 0.03, z + 0.125)));
  }
}

void add_posts(Surface& out) {
  for (const double x : {-1.95, 1.95}) {
    for (const double z : {-1.6, 1.6, kPorchEdge - 0.12}) {
      const bool is_porch = z > 2;
      Surface post = tapered_cylinder(0.075, 0.065, is_porch ? 2.75 : 2.9, 10, 1, glm::dvec2(1, 4), true);
      post.tint(glm::dvec4(0.62, 0.55, 0.48, 1));
      out.append(post, moved(glm::dvec3(x, -0.35, z)));
    }
    Surface beam = box(glm::dvec3(0.06, 0.06, (kPorchEdge + kHalfDepth) / 2), 0.9);
    beam.tint(glm::dvec4(0.5, 0.44, 0.38, 1));
    out.append(beam, moved(glm::dvec3(x, kFloorHeight - 0.12, (kPorchEdge - kHalfDepth) / 2)));
  }
  // The porch's lintel, a rail on either side of the steps, the steps.
  Surface lintel = box(glm::dvec3(2.2, 0.06, 0.06), 0.9);
  lintel.tint(glm::dvec4(0.6, 0.53, 0.46, 1));
  out.append(lintel, moved(glm::dvec3(0, 2.42, kPorchEdge - 0.12)));
  for (const double x : {-1.3, 1.35}) {
    for (const double y : {0.38, 0.76}) {
      Surface rail = box(glm::dvec3(0.65, 0.028, 0.028), 0.9);
      rail.tint(glm::dvec4(0.8, 0.72, 0.62, 1));
      out.append(rail, moved(glm::dvec3(x, kFloorHeight + y, kPorchEdge - 0.12)));
    }
    Surface newel = box(glm::dvec3(0.04, 0.42, 0.04), 0.9);
    newel.tint(glm::dvec4(0.6, 0.53, 0.46, 1));
    out.append(newel, moved(glm::dvec3(x < 0 ? -0.65 : 0.7, kFloorHeight + 0.4, kPorchEdge - 0.12)));
  }
  for (int i = 0; i < 2; ++i) {
    Surface step = box(glm::dvec3(0.6, 0.035, 0.15), 0.9);
    step.tint(glm::dvec4(0.85, 0.78, 0.7, 1));
    out.append(step, moved(glm::dvec3(0, 0.32 - 0.18 * i, kPorchEdge + 0.14 + 0.28 * i)));
  }
}

/// One drooping leaf along +x, folded along its rib; uv.x along, uv.y across.
Surface frond() {
  Surface leaf = patch(
      9, 2,
      [](double u, double v) {
        const double across = 2 * v - 1, width = 0.34 * (1 - 0.3 * u);
        const double rise = 0.5 * u - 1.35 * u * u;
        return glm::dvec3(1.75 * u - 0.32 * u * u * u, rise - 0.16 * std::fabs(across) * (0.4 + u),
                          -across * width);
      },
      glm::dvec2(1));
  for (std::size_t i = 0; i < leaf.positions.size(); ++i)
    leaf.colors.push_back(glm::dvec4(glm::dvec3(0.55 + 0.45 * leaf.uv[i].x), 1));
  return leaf;
}

double grain(double u, double v) {
  return 0.65 * cloudy(u, v, 16, 2, 3, 61) + 0.35 * cloudy(u, v, 48, 3, 1, 62);
}

double leaflets(double u, double v) {
  const double across = std::fabs(2 * v - 1), along = u * 26 - across * 4.5;
  const double cut =
      std::fabs(along - std::floor(along) - 0.5) * 2;  // 0 in the middle of a leaflet, 1 in a gap
  const double outline = 1.02 - smooth_step(0.72, 1.0, u) - 0.5 * smooth_step(0.16, 0.0, u);
  const double leaflet = across < outline && cut < 0.80 - 0.5 * across * across ? 1 : 0;
  return across < 0.07 ? 1 : leaflet;
}

}  // namespace

HutPaint paint_hut(Model& model) {
  const int wood = model.add_texture("planks", paint_rgb(64, 128, [](double u, double v) {
                                       const double g = grain(u, v);
                                       return glm::dvec3(0.62, 0.47, 0.34) * (0.58 + 0.62 * g);
                                     }));
  const int straw = model.add_texture(
      "thatch", paint_rgba(128, 64, [](double u, double v) {
        const double blade = cloudy(u, v, 48, 2, 2, 71), length = 0.62 + 0.36 * noise(u * 64, 0, 64, 1, 73);
        const glm::dvec3 color = glm::dvec3(0.72, 0.58, 0.36) * (0.45 + 0.75 * blade) * (0.6 + 0.5 * v);
        return glm::dvec4(color, v < length ? 1 : 0);
      }));
  const int sand = model.add_texture("sand", paint_rgb(128, 128, [](double u, double v) {
                                       const double n = cloudy(u, v, 3, 3, 3, 81),
                                                    speck = noise(u * 64, v * 64, 64, 64, 85);
                                       return glm::dvec3(0.86, 0.76, 0.60) * (0.84 + 0.12 * n + 0.1 * speck);
                                     }));
  const int ripples = model.add_texture("sand_normal", paint_normals(128, 128, 0.011, [](double u, double v) {
                                          const double bend = 0.25 * cloudy(u, v, 2, 2, 2, 91);
                                          return 0.5 + 0.5 * sin_cos(2 * kPi * (5 * (u + bend) + 2 * v)).sin +
                                                 0.5 * cloudy(u, v, 12, 12, 2, 95);
                                        }));
  const int waves = model.add_texture("water_normal", paint_normals(128, 128, 0.035, [](double u, double v) {
                                        return cloudy(u, v, 4, 3, 3, 101);
                                      }));
  const int leaf = model.add_texture(
      "palm_leaf", paint_rgba(128, 64, [](double u, double v) {
        const double across = std::fabs(2 * v - 1), n = cloudy(u, v, 16, 4, 2, 111);
        const glm::dvec3 green = glm::dvec3(0.30, 0.44, 0.13) * (0.7 + 0.5 * n);
        const glm::dvec3 tip = glm::dvec3(0.62, 0.58, 0.22);
        const double t = 0.75 * smooth_step(0.5, 1.0, std::max(u, across) - 0.1 * n);
        const glm::dvec3 rib = across < 0.07 ? glm::dvec3(0.55, 0.52, 0.25) : green + (tip - green) * t;
        return glm::dvec4(rib, leaflets(u, v));
      }));
  HutPaint paint{};
  paint.wood = model.add_material(pbr_material("planks", glm::dvec4(1), 0, 0.75, wood));
  ordered_json thatch = pbr_material("thatch", glm::dvec4(1), 0, 0.9, straw);
  thatch["alphaMode"] = "MASK";
  thatch["doubleSided"] = true;
  paint.thatch = model.add_material(thatch);
  paint.sand = model.add_material(pbr_material("sand", glm::dvec4(1), 0, 0.85, sand, ripples));
  ordered_json water = pbr_material("water", glm::dvec4(0.015, 0.16, 0.19, 0.78), 0, 0.22, -1, waves);
  water["alphaMode"] = "BLEND";
  paint.water = model.add_material(water);
  ordered_json sky = pbr_material("sky", glm::dvec4(1), 0, 1);
  sky["extensions"]["KHR_materials_unlit"] = ordered_json::object();
  paint.sky = model.add_material(sky);
  paint.jungle = model.add_material(pbr_material("jungle", glm::dvec4(0.05, 0.11, 0.05, 1), 0, 0.95));
  paint.rock = model.add_material(pbr_material("rock", glm::dvec4(0.16, 0.14, 0.13, 1), 0, 0.6));
  paint.bark = model.add_material(pbr_material("bark", glm::dvec4(0.62, 0.58, 0.55, 1), 0, 0.85, wood));
  ordered_json green = pbr_material("palm leaf", glm::dvec4(1), 0, 0.5, leaf);
  green["alphaMode"] = "MASK";
  green["doubleSided"] = true;
  paint.leaf = model.add_material(green);
  paint.coconut = model.add_material(pbr_material("coconut", glm::dvec4(0.20, 0.12, 0.04, 1), 0, 0.6));
  paint.ceramic = model.add_material(pbr_material("ceramic", glm::dvec4(0.06, 0.24, 0.42, 1), 0, 0.25));
  paint.fruit = model.add_material(pbr_material("fruit", glm::dvec4(0.9, 0.35, 0.03, 1), 0, 0.45));
  paint.brass = model.add_material(pbr_material("brass", glm::dvec4(0.88, 0.68, 0.35, 1), 1, 0.4));
  ordered_json glow = pbr_material("flame", glm::dvec4(0, 0, 0, 1), 0, 1);
  glow["emissiveFactor"] = {1.0, 0.7, 0.3};
  glow["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 1.6;
  paint.glow = model.add_material(glow);
  ordered_json glass = pbr_material("bottle glass", glm::dvec4(0.02, 0.3, 0.12, 0.45), 0, 0.15);
  glass["alphaMode"] = "BLEND";
  paint.glass = model.add_material(glass);
  paint.lacquer = model.add_material(pbr_material("lacquer", glm::dvec4(1), 0, 0.2));
  return paint;
}

double ground_height(double x, double z) {
  const double dunes = 0.5 * noise(x * 0.16 + 40, z * 0.16 + 40, 256, 256, 7) - 0.2;
  const double far = smooth_step(3.0, 12.0, std::sqrt(x * x + z * z));
  const double shore = 0.16 * std::max(0.0, x - 2.6 + 0.5 * sin_cos(z * 0.35).sin);
  return 0.05 + dunes * (0.15 + 1.6 * far) - std::min(shore, 2.5);
}

Surface hut_planks() {
  Surface out;
  Dice dice(2012);
  const glm::dmat4 front = moved(glm::dvec3(0, 0, kHalfDepth)),
                   back = moved(glm::dvec3(0, 0, -kHalfDepth)) * turned_y(180);
  const glm::dmat4 left = moved(glm::dvec3(-kHalfWidth, 0, 0)) * turned_y(-90),
                   right = moved(glm::dvec3(kHalfWidth, 0, 0)) * turned_y(90);
  add_wall(out, -kHalfWidth, kHalfWidth, {{-0.6, 0.2, 0, 1.95}, {0.8, 1.6, 0.95, 1.65}}, front, dice);
  add_wall(out, -kHalfWidth, kHalfWidth, {{-0.6, 0.6, 1.0, 1.7}}, back, dice);
  add_wall(out, -kHalfDepth, kHalfDepth, {{-0.4, 0.4, 0.95, 1.65}}, left, dice);
  add_wall(out, -kHalfDepth, kHalfDepth, {{-0.8, 0.8, 0.85, 1.75}}, right, dice);
  add_floor(out, dice);
  add_posts(out);
  return out;
}

Surface thatch_roof() {
  // Overlapping courses of straw: two slopes down from the ridge along x; the front one reaches over the
  // porch.
  Surface out;
  const double ridge_y = 4.0, eaves_y = 2.42;
  for (const double side : {1.0, -1.0}) {
    const double run = side > 0 ? kPorchEdge + 0.35 : kHalfDepth + 0.55;
    const int courses = side > 0 ? 6 : 4;
    for (int i = 0; i < courses; ++i) {
      const double t0 = static_cast<double>(i) / courses, t1 = static_cast<double>(i + 1) / courses + 0.09;
      const double lift = 0.05;
      Surface course = patch(
          6, 1,
          [&](double u, double v) {
            // v = 0 at the lower edge; the upper edge tucks under the course above.
            const double t = t1 + (t0 - t1) * v;
            const double sag = 0.06 * (2 * u - 1) * (2 * u - 1);
            return glm::dvec3((u - 0.5) * (5.3 + 0.1 * (i % 2)) * side,
                              ridge_y + (eaves_y - ridge_y) * t + lift * (1 - v) + sag, side * run * t);
          },
          glm::dvec2(3, 1));
      for (glm::dvec2& uv : course.uv) uv = glm::dvec2(uv.x + 0.37 * i, 0.98 - 0.96 * uv.y);
      course.tint(glm::dvec4(glm::dvec3(0.82 + 0.06 * (i * 5 % 4)), 1));
      out.append(course);
    }
  }
  // A bundle along the ridge.
  Surface ridge = patch(
      16, 6,
      [&](double u, double v) {
        const SinCos a = sin_cos(kPi * (1.25 * v - 0.125));
        const double sag = 0.06 * (2 * u - 1) * (2 * u - 1);
        return glm::dvec3((u - 0.5) * 5.4, ridge_y - 0.08 + 0.16 * a.sin + sag, 0.17 * a.cos);
      },
      glm::dvec2(2, 0.5));
  for (glm::dvec2& uv : ridge.uv) uv = glm::dvec2(uv.y * 0.8, uv.x * 0.25);
  ridge.tint(glm::dvec4(0.8, 0.75, 0.7, 1));
  out.append(ridge);
  return out;
}

glm::dvec3 trunk_tip() { return glm::dvec3(1.05, 3.9, 0); }

Surface palm_trunk() {
  Surface trunk = patch(
      8, 26,
      [](double u, double v) {
        const SinCos a = sin_cos(2 * kPi * u);
        const double scar = v * 26 / 2 - std::floor(v * 26 / 2);  // a ring every second row of vertices
        const double r = (0.16 - 0.07 * v + 0.08 * smooth_step(0.12, 0.0, v)) * (1 + 0.1 * scar);
        const glm::dvec3 centre(1.05 * v * v, 3.95 * v, 0);
        return centre + glm::dvec3(a.sin * r, 0, a.cos * r);
      },
      glm::dvec2(1, 4), true);
  for (const glm::dvec2& uv : trunk.uv)
    trunk.colors.push_back(glm::dvec4(
        glm::dvec3(0.6 + 0.4 * smooth_step(0, 0.3, uv.y / 4) - 0.35 * smooth_step(0.85, 1, uv.y / 4)), 1));
  return trunk;
}

Surface palm_crown() {
  Surface crown;
  const Surface leaf = frond();
  Dice dice(7);
  constexpr int kFronds = 13;
  for (int i = 0; i < kFronds; ++i) {
    const double turn = 360.0 * i / kFronds + dice.between(-9, 9), lift = i % 3 == 0   ? 42
                                                                          : i % 3 == 1 ? 14
                                                                                       : -8;
    crown.append(leaf, turned_y(turn) * turned_z(lift + dice.between(-6, 6)) *
                           scaled(glm::dvec3(dice.between(0.85, 1.15))));
  }
  return crown;
}

Surface boulder(double radius, int slices, int stacks, double roughness, std::uint32_t seed) {
  const auto shape = [&](const glm::dvec3& n) {
    const double a = noise(n.x * 1.6 + 8, n.y * 1.6 + 8, 64, 64, seed),
                 b = noise(n.y * 2.6 + 8, n.z * 2.6 + 8, 64, 64, seed + 1);
    return radius * (1 + roughness * (a + 0.6 * b - 0.8));
  };
  return patch(
      slices, stacks,
      [&](double u, double v) {
        const SinCos east = sin_cos(2 * kPi * u), south = sin_cos(kPi * (1 - v));
        const glm::dvec3 n(south.sin * east.sin, south.cos, south.sin * east.cos);
        return n * shape(n);
      },
      glm::dvec2(1), true);
}

}  // namespace aluminate::scenes::generator
