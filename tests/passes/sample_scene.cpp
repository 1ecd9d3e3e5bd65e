#include "tests/passes/sample_scene.hpp"

#include <filesystem>
#include <map>

#include "scenes/loader.hpp"

namespace aluminate::test {

const scenes::Scene& sample_scene(const std::string& name) {
  static std::map<std::string, scenes::Scene> loaded;
  const auto found = loaded.find(name);
  if (found != loaded.end()) return found->second;
  return loaded
      .emplace(name,
               scenes::load_scene(std::string(ALUMINATE_SOURCE_DIR) + "/scenes/samples/" + name + ".gltf"))
      .first->second;
}

std::string public_model(const std::string& file) {
  const std::string path = std::string(ALUMINATE_SHARED_DIR) + "/scenes/" + file;
  return std::filesystem::exists(path) ? path : "";
}

}  // namespace aluminate::test
