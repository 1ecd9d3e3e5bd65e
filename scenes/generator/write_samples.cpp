#include "scenes/generator/sample_models.hpp"

namespace aluminate::scenes::generator {

void write_samples(const std::filesystem::path& folder) {
  for (const auto make :
       {&make_material_wall, &make_beach_hut, &make_grazing_floor, &make_overdraw_stress, &make_triangle})
    make().write(folder);
}

}  // namespace aluminate::scenes::generator
