// Scenes for the tests of the passes: the shipped samples and, where present, the public models.
#pragma once

#include <string>

#include "scenes/scene.hpp"

namespace aluminate::test {

/// scenes/samples/NAME.gltf, loaded once.
const scenes::Scene& sample_scene(const std::string& name);

/// Path of a public model, empty when it is not there.
std::string public_model(const std::string& file);

}  // namespace aluminate::test
