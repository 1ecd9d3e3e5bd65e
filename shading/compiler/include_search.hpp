// Where #include looks: the including file's folder, the source's folder, the include directories, in this
// order; text in memory before the disk when the includer is in memory too.
#pragma once

#include "shading/compiler/compile.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace aluminate::compiler {

struct IncludeFile {
  std::string name;  // as later #includes and errors name it
  std::string text;
};

/// The folder a source's own includes are relative to.
std::filesystem::path source_folder(const Options& options);

/// local: written in quotes, so the includer's folder comes first.
std::optional<IncludeFile> find_include(const Options& options, const std::string& name,
                                        const std::string& includer, bool local);

/// A name that may follow #include in a text.
struct IncludeName {
  std::string name;
  bool local = true;
};
/// Every name the preprocessor could meet, and perhaps some it never does (conditionals and comments are not
/// looked at). Nothing when a name cannot be told from the text, as with a macro's.
std::optional<std::vector<IncludeName>> possible_includes(const std::string& text);

}  // namespace aluminate::compiler
