// The first triangle of every renderer: vertex colours, no light.
#include "scenes/generator/sample_models.hpp"

namespace aluminate::scenes::generator {

Model make_triangle() {
  Model model("triangle");
  Surface surface;
  surface.positions = {glm::dvec3(-1, -0.75, 0), glm::dvec3(1, -0.75, 0), glm::dvec3(0, 1, 0)};
  surface.normals.assign(3, glm::dvec3(0, 0, 1));
  surface.colors = {glm::dvec4(1, 0, 0, 1), glm::dvec4(0, 1, 0, 1), glm::dvec4(0, 0, 1, 1)};
  surface.indices = {0, 1, 2};
  ordered_json material = pbr_material("paint", glm::dvec4(1), 0, 1);
  material["extensions"]["KHR_materials_unlit"] = ordered_json::object();
  model.place("triangle", model.add_mesh("triangle", surface, model.add_material(material)));
  model.add_camera("front", glm::dvec3(0, 0.1, 4), glm::dvec3(0, 0.1, 0), 34, 0.1);
  return model;
}

}  // namespace aluminate::scenes::generator
