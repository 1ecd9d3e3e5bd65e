// The only place of the scene loader that opens files. A glTF names other files by URI; they must lie in or
// below the folder of the scene file after every symlink is followed. Anything else is a UserError and is not
// opened.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace aluminate::scenes::gltf {

bool is_data_uri(std::string_view uri);

/// %41 -> A. A '%' without two hex digits stays as it is.
std::string percent_decode(std::string_view uri);

/// The bytes of a regular file of 1 to max_bytes bytes; devices, pipes and folders are refused by name.
std::vector<std::uint8_t> read_regular_file(const std::filesystem::path& path, std::uint64_t max_bytes,
                                            const std::string& shown_as);

/// A folder that relative URIs are resolved in. `scene_file` names the scene in messages.
class ResourceFolder {
 public:
  ResourceFolder(std::filesystem::path folder, std::string scene_file, std::uint64_t max_bytes);

  /// place: JSON path of the URI, for messages. Throws UserError when the URI leaves the folder, names a
  /// scheme such as http:, is absolute, or the file is missing or not a regular file.
  std::vector<std::uint8_t> read(const std::string& uri, const std::string& place) const;

 private:
  std::filesystem::path folder_;
  std::string scene_file_;
  std::uint64_t max_bytes_;
};

}  // namespace aluminate::scenes::gltf
