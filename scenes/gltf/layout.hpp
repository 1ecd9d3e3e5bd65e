// Sizes: that every buffer view lies in its buffer and every accessor in its views, in 64-bit arithmetic,
// before any byte is read or allocated. Runs on JSON that passed check_schema. Throws UserError with the JSON
// path.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace aluminate::scenes::gltf {

void check_layout(const nlohmann::json& root, const std::string& file);

}  // namespace aluminate::scenes::gltf
