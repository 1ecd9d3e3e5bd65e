// A glTF file after every check that can be made before its bytes are interpreted: the structure as tinygltf
// reads it, the files it names, the hash of all of them. tinygltf never touches the file system: it is handed
// bytes that were read here.
#pragma once

#include "scenes/loader.hpp"
#include "scenes/scene.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tinygltf {
class Model;
}

namespace aluminate::scenes::gltf {

/// Warnings, each once, in the order of their first appearance; a hostile file cannot grow them without end.
class Warnings {
 public:
  static constexpr std::size_t kMost = 200;
  void add(std::string line);
  std::vector<std::string> take();

 private:
  std::vector<std::string> lines_;
  std::size_t dropped_ = 0;
};

struct Document {
  std::string file;
  std::string content_hash;
  std::unique_ptr<tinygltf::Model> model;  // buffers filled; images hold their encoded bytes in Image::image
  Warnings warnings;

  Document();
  Document(Document&&) noexcept;
  ~Document();

  [[noreturn]] void fail(const std::string& place, const std::string& what,
                         const std::string& hint = {}) const;
};

Document read_document(const std::filesystem::path& path, const LoadLimits& limits);

/// What of the file may stand in a message or a name: printable, at most 64 characters.
std::string shown_name(const std::string& name);

}  // namespace aluminate::scenes::gltf
