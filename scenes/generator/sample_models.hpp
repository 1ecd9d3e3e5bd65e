// The sample scenes as models, one file each. See scenes/catalogue.hpp for what they are for.
#pragma once

#include "scenes/generator/model.hpp"

#include <filesystem>
#include <vector>

namespace aluminate::scenes::generator {

Model make_material_wall();
Model make_beach_hut();
Model make_grazing_floor();
Model make_overdraw_stress();
Model make_triangle();

/// All of them into a folder, in catalogue order.
void write_samples(const std::filesystem::path& folder);

}  // namespace aluminate::scenes::generator
