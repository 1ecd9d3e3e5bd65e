// The outer layer of a scene file: .gltf is JSON text, .glb the same with bytes behind it [glTF2 4.4]. In:
// the file's bytes. Out: where its parts lie, and the JSON as a tree, depth and number of values bounded.
// Knows nothing of what the JSON means.
#pragma once

#include "scenes/loader.hpp"

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

namespace aluminate::scenes::gltf {

struct Container {
  bool binary = false;
  std::span<const std::uint8_t> json_text;
  std::span<const std::uint8_t> bin;  // of the BIN chunk, empty = none
};

/// A glb's header and first two chunks; any other file is taken as JSON text. Throws UserError.
Container open_container(std::span<const std::uint8_t> bytes, const std::string& file);

/// JSON text to a tree, with ceilings on depth and on the number of values: a small text can ask for a great
/// deal of both. Throws UserError with line and column.
nlohmann::json parse_json(const Container& container, const std::string& file, const LoadLimits& limits);

/// A .glb of the two chunks, each padded to four bytes. Throws UserError above 4 GiB.
std::vector<std::uint8_t> glb_bytes(const nlohmann::json& root, std::span<const std::uint8_t> bin,
                                    const std::string& file);

std::uint32_t little_endian_u32(std::span<const std::uint8_t> bytes, std::size_t at);

}  // namespace aluminate::scenes::gltf
