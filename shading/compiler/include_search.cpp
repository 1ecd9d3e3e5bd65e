#include "shading/compiler/include_search.hpp"

#include <cctype>
#include <fstream>
#include <sstream>
#include <string_view>

namespace aluminate::compiler {
namespace {

// Backslash-newline is nothing to the preprocessor.
std::string without_splices(const std::string& text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\') {
      std::size_t next = i + 1;
      if (next < text.size() && text[next] == '\r') ++next;
      if (next < text.size() && text[next] == '\n') {
        i = next;
        continue;
      }
    }
    out += text[i];
  }
  return out;
}

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

}  // namespace

std::filesystem::path source_folder(const Options& options) {
  return std::filesystem::path(options.source_path.empty() ? "shader" : options.source_path).parent_path();
}

std::optional<IncludeFile> find_include(const Options& options, const std::string& name,
                                        const std::string& includer, bool local) {
  const auto in_memory = options.files.find(name);
  const bool from_memory = includer.empty() || includer == options.source_path
                               ? options.source.has_value()
                               : options.files.contains(includer);
  if (from_memory && in_memory != options.files.end()) return IncludeFile{name, in_memory->second};
  std::vector<std::filesystem::path> folders;
  if (local && !includer.empty()) folders.push_back(std::filesystem::path(includer).parent_path());
  folders.push_back(source_folder(options));
  folders.insert(folders.end(), options.include_dirs.begin(), options.include_dirs.end());
  for (const auto& folder : folders) {
    const std::filesystem::path path = folder.empty() ? std::filesystem::path(name) : folder / name;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) continue;
    std::ifstream in(path, std::ios::binary);
    std::ostringstream content;
    content << in.rdbuf();
    return IncludeFile{path.string(), std::move(content).str()};
  }
  if (in_memory != options.files.end()) return IncludeFile{name, in_memory->second};
  return std::nullopt;
}

std::optional<std::vector<IncludeName>> possible_includes(const std::string& spliced) {
  constexpr std::string_view kWord = "include";
  const std::string text = without_splices(spliced);
  std::vector<IncludeName> names;
  for (std::size_t at = text.find(kWord); at != std::string::npos; at = text.find(kWord, at + 1)) {
    std::size_t next = at + kWord.size();
    if ((at > 0 && is_word(text[at - 1])) || (next < text.size() && is_word(text[next]))) continue;
    while (next < text.size() && is_blank(text[next])) ++next;
    const char open = next < text.size() ? text[next] : '\n';
    if (open == '"' || open == '<') {
      const std::size_t close = text.find_first_of(open == '"' ? "\"\r\n" : ">\r\n", next + 1);
      if (close == std::string::npos) return std::nullopt;
      names.push_back({text.substr(next + 1, close - next - 1), open == '"'});
      continue;
    }
    // A directive all the same when a # stands before it, blanks or a comment in between.
    std::size_t before = at;
    while (before > 0 && is_blank(text[before - 1])) --before;
    if (before > 0 && (text[before - 1] == '#' || text[before - 1] == '/')) return std::nullopt;
  }
  return names;
}

}  // namespace aluminate::compiler
