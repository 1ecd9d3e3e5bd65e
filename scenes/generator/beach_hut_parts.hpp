// The parts of the beach hut scene: its materials, and the surfaces that take more than one line.
#pragma once

#include "scenes/generator/model.hpp"
#include "scenes/generator/paint.hpp"

namespace aluminate::scenes::generator {

constexpr double kFloorHeight = 0.5;  // the hut stands on stilts

/// Material indices.
struct HutPaint {
  int wood, thatch, sand, water, sky, jungle, rock, bark, leaf, coconut, ceramic, fruit, brass, glow, glass,
      lacquer;
};
HutPaint paint_hut(Model& model);

double ground_height(double x, double z);

Surface hut_planks();  // walls with a door and windows, floor, porch, posts, beams, steps
Surface thatch_roof();
Surface palm_trunk();  // 4 m, leaning towards +x
glm::dvec3 trunk_tip();
Surface palm_crown();  // around the origin
/// A sphere with a noisy radius.
Surface boulder(double radius, int slices, int stacks, double roughness, std::uint32_t seed);

}  // namespace aluminate::scenes::generator
