// What every reader of a TOML file needs: the text parsed, places for messages, unknown keys refused with the
// nearest known one. In: text and the name of its file. Out: a table, or one UserError with file:line:column.
#pragma once

#include <toml++/toml.h>

#include <span>
#include <string>
#include <string_view>

#include "platform/host/error.hpp"

namespace aluminate::host {

/// hint: what a valid line of this kind of file looks like.
toml::table parse_toml(std::string_view text, const std::string& path, const std::string& hint);

/// Where a node stands.
SourcePlace toml_place(const std::string& path, const toml::source_region& region);

/// "an integer", "a table", ...: what a node is.
std::string_view toml_kind(const toml::node& node);

/// UserError for the first key (in the order of the file) that is not in `known`. where: "[clock]".
void refuse_unknown_keys(const toml::table& table, std::span<const std::string> known,
                         const std::string& where, const std::string& path);

}  // namespace aluminate::host
