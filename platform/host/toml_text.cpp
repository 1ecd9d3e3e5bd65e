#include "platform/host/toml_text.hpp"

#include <algorithm>

#include "platform/host/suggest.hpp"

namespace aluminate::host {

toml::table parse_toml(std::string_view text, const std::string& path, const std::string& hint) {
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    throw UserError(toml_place(path, error.source()), "not valid TOML: " + std::string(error.description()),
                    hint);
  }
}

SourcePlace toml_place(const std::string& path, const toml::source_region& region) {
  return {path, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

std::string_view toml_kind(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "a string";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "a boolean";
    default:
      return "a date or time";
  }
}

void refuse_unknown_keys(const toml::table& table, std::span<const std::string> known,
                         const std::string& where, const std::string& path) {
  const toml::key* first = nullptr;  // tables are sorted by name; people read from the top
  for (const auto& [key, node] : table) {
    if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
    const auto at = [](const toml::key& k) {
      return std::pair(k.source().begin.line, k.source().begin.column);
    };
    if (first == nullptr || at(key) < at(*first)) first = &key;
  }
  if (first != nullptr)
    throw UserError(toml_place(path, first->source()),
                    fmt::format("unknown key '{}' in {}", first->str(), where),
                    did_you_mean(first->str(), known));
}

}  // namespace aluminate::host
