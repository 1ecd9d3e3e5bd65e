#include "shading/compiler/diagnostics.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string_view>
#include <vector>

namespace aluminate::compiler {
namespace {

struct Entry {
  SourcePlace place;
  std::string token, message;
};

std::string trimmed(std::string_view s) {
  while (!s.empty() && std::isspace(static_cast<unsigned char>(s.front())) != 0) s.remove_prefix(1);
  while (!s.empty() && std::isspace(static_cast<unsigned char>(s.back())) != 0) s.remove_suffix(1);
  return std::string(s);
}

// "ERROR: file:12: 'token' : message". The file may contain colons; the line number is the last ":digits:"
// before a quote.
bool parse_entry(const std::string& line, Entry& entry) {
  if (!line.starts_with("ERROR: ")) return false;
  const std::string rest = line.substr(7);
  std::size_t quote = rest.find(": '");
  if (quote == std::string::npos) {
    entry.message = trimmed(rest);
    return !entry.message.empty();
  }
  const std::string where = rest.substr(0, quote);
  const std::size_t colon = where.rfind(':');
  if (colon != std::string::npos && colon + 1 < where.size() &&
      std::all_of(where.begin() + static_cast<std::ptrdiff_t>(colon) + 1, where.end(),
                  [](unsigned char c) { return std::isdigit(c) != 0; })) {
    entry.place.file = where.substr(0, colon);
    entry.place.line = std::atoi(where.c_str() + colon + 1);
  }
  const std::size_t close = rest.find("' : ", quote + 3);
  if (close == std::string::npos) {
    entry.message = trimmed(rest.substr(quote + 2));
  } else {
    entry.token = rest.substr(quote + 3, close - quote - 3);
    entry.message = trimmed(rest.substr(close + 4));
  }
  return true;
}

// Column of the token as a whole word, from 1; 0 when the line does not hold it.
int column_of(const std::string& line, const std::string& token) {
  const auto word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  for (std::size_t at = line.find(token); at != std::string::npos && !token.empty();
       at = line.find(token, at + 1)) {
    const bool left = at == 0 || !word(line[at - 1]) || !word(token.front());
    const bool right =
        at + token.size() >= line.size() || !word(line[at + token.size()]) || !word(token.back());
    if (left && right) return static_cast<int>(at) + 1;
  }
  return 0;
}

std::string line_of(const std::string& text, int number) {
  std::istringstream in(text);
  std::string line;
  for (int k = 0; k < number && std::getline(in, line); ++k) {
  }
  return in ? line : "";
}

std::string hint_for(const Entry& e, bool hlsl) {
  const auto has = [&](std::string_view s) { return e.message.find(s) != std::string::npos; };
  if (has("no matching overloaded function")) {
    if (e.token == "tex2D" || e.token == "texCUBE" || e.token == "tex3D")
      return e.token + " takes a sampler and coordinates, optionally two gradients";
    if (e.token.starts_with("tex2D") || e.token.starts_with("texCUBE"))
      return e.token + " takes a sampler and a float4 whose w is the level, bias or divisor";
    return "check the name and the argument types";
  }
  if (has("unknown variable") || has("undeclared identifier")) return "declare it, or define it with -D";
  if (has("Could not process include") || has("cannot find include"))
    return "include files are looked for beside the including file, beside the source and in the include "
           "directories";
  if (has("Recursion") || has("recursion")) return "shaders have no call stack; write a loop";
  if (has("Entry point not found")) return "name the entry point with --entry";
  if (e.token == ";" && has("Expected")) return "a semicolon is missing on this line or the one before";
  if (has("#version")) return "start the file with #version 450";
  if (!hlsl && has("tex2D")) return "this is HLSL; name the file .hlsl";
  return "";
}

}  // namespace

UserError front_end_error(const std::string& log, const std::string& main_file, const TextOfFile& text_of,
                          bool hlsl) {
  std::vector<Entry> entries;
  std::istringstream in(log);
  std::string line, previous_column;
  int error_column = 0, error_line = 0;
  while (std::getline(in, line)) {
    Entry e;
    if (parse_entry(line, e)) {
      entries.push_back(e);
    } else if (const auto at = line.find("): error at column ");
               at != std::string::npos) {  // "file(12): error at column 5, ..."
      const auto open = line.rfind('(', at);
      if (open != std::string::npos) error_line = std::atoi(line.c_str() + open + 1);
      error_column = std::atoi(line.c_str() + at + 19);
    } else if (line.starts_with("    ") && !entries.empty() && entries.back().message.ends_with(":")) {
      entries.back().message += " " + trimmed(line);
    } else if (line.find("Entry point not found") != std::string::npos) {
      e.message = "Entry point not found";
      entries.push_back(e);
    }
  }
  if (entries.empty())
    return UserError(SourcePlace{main_file, 0, 0},
                     log.empty() ? "the source does not compile" : trimmed(log.substr(0, log.find('\n'))));

  Entry e = entries.front();
  if (e.place.file.empty()) e.place.file = main_file;
  if (e.place.line > 0) {
    if (const std::string* text = text_of(e.place.file))
      e.place.column = column_of(line_of(*text, e.place.line), e.token);
    if (e.place.column == 0 && e.place.line == error_line) e.place.column = error_column;
  }
  std::string what = e.message;
  for (const std::string_view prefix : {"Linking fragment stage: ", "Linking vertex stage: "})
    if (what.starts_with(prefix)) what = what.substr(prefix.size());
  if (what == "Expected")
    what = "expected '" + e.token + "'";
  else if (!e.token.empty() && e.token != "declaration" && e.token != "expression")
    what = fmt::format("'{}': {}", e.token, what);
  if (what.starts_with("expected 'declaration'")) what = "expected a declaration";
  if (!what.empty() && std::isupper(static_cast<unsigned char>(what[0])) != 0 &&
      (what.size() < 2 || std::isupper(static_cast<unsigned char>(what[1])) == 0))
    what[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(what[0])));
  return UserError(e.place, what, hint_for(e, hlsl));
}

}  // namespace aluminate::compiler
