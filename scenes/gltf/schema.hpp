// The parsed JSON of a glTF file in, nothing out: throws UserError at the first value whose type, range or
// reference is wrong, named by its JSON path. After this every index the loader follows exists and every
// integer fits. Covers what the loader and tinygltf read, not the whole glTF schema: unread properties may
// hold anything.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace aluminate::scenes::gltf {

void check_schema(const nlohmann::json& root, const std::string& file);

}  // namespace aluminate::scenes::gltf
