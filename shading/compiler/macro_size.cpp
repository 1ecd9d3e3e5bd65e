#include "shading/compiler/macro_size.hpp"

#include "platform/host/error.hpp"
#include "shading/compiler/limits.hpp"
#include "shading/compiler/source_tokens.hpp"

#include <algorithm>

namespace aluminate::compiler {
namespace {

constexpr double kMany = 1e18;
constexpr double kUnknownArgument = 16;  // words of an argument nobody sees here

// Lines joined at a backslash, comments replaced by a space.
std::string plain(const std::string& text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    if (text.compare(at, 2, "\\\n") == 0) {
      at += 2;
    } else if (text.compare(at, 3, "\\\r\n") == 0) {
      at += 3;
    } else if (text.compare(at, 2, "/*") == 0) {
      const auto end = text.find("*/", at + 2);
      at = end == std::string::npos ? text.size() : end + 2;
      out += ' ';
    } else {
      out += text[at++];
    }
  }
  return out;
}

void add_to(std::vector<double>& sum, const std::vector<double>& more, double times = 1) {
  for (std::size_t k = 0; k < more.size(); ++k) sum[k] = std::min(sum[k] + times * more[k], kMany);
}

}  // namespace

void MacroSize::add(const std::string& text, const std::string& file) {
  const std::string joined = plain(text);
  Tokens tokens(joined);
  Words rest, line;
  int at_line = 0;
  bool is_define = false;
  const auto finish = [&] {
    if (is_define)
      define(line);
    else
      rest.insert(rest.end(), line.begin(), line.end());
    line.clear();
  };
  Token t;
  while (tokens.next(t)) {
    if (t.line != at_line) {
      finish();
      is_define = false;
      at_line = t.line;
    }
    // A space between name and bracket makes the bracket part of the body.
    if (line.size() == 3 && is_define && t.text == "(" && joined[static_cast<std::size_t>(t.text.data() - joined.data()) - 1] <= ' ')
      line.emplace_back(" ");
    line.emplace_back(t.text);
    is_define = is_define || (line.size() == 2 && line[0] == "#" && line[1] == "define");
  }
  finish();
  texts_.push_back(std::move(rest));
  known_.clear();
  double total = 0;
  for (const Words& words : texts_) total += length_of(words, 0, words.size(), {})[0];
  if (total > static_cast<double>(kMaxExpandedTokens))
    throw UserError(SourcePlace{file, 0, 0},
                    fmt::format("the source has {:.3g} words and signs with its macros expanded", total),
                    fmt::format("the limit is {}", kMaxExpandedTokens));
}

// "#", "define", NAME, and "(" right behind it when it takes arguments.
void MacroSize::define(const Words& line) {
  if (line.size() < 3) return;
  Macro macro;
  std::size_t at = 3;
  if (at < line.size() && line[at] == "(") {
    macro.takes_arguments = true;
    for (++at; at < line.size() && line[at] != ")"; ++at)
      if (line[at] != ",") macro.parameters.push_back(line[at]);
    ++at;
  }
  for (; at < line.size(); ++at) macro.body.push_back(line[at]);
  macros_[line[2]].push_back(std::move(macro));
}

MacroSize::Length MacroSize::length_of(const std::string& name, const Macro& macro) {
  open_[name] = true;
  Length length = length_of(macro.body, 0, macro.body.size(), macro.parameters);
  open_[name] = false;
  return length;
}

// The longest of all definitions of the name.
MacroSize::Length MacroSize::length_of_name(const std::string& name) {
  if (const auto it = known_.find(name); it != known_.end()) return it->second;
  Length longest{0};
  for (const Macro& macro : macros_.at(name)) {
    const Length length = length_of(name, macro);
    longest.resize(std::max(longest.size(), length.size()), 0);
    for (std::size_t k = 0; k < length.size(); ++k) longest[k] = std::max(longest[k], length[k]);
  }
  return known_[name] = longest;
}

MacroSize::Length MacroSize::length_of(const Words& words, std::size_t begin, std::size_t end, const Words& parameters) {
  Length sum(1 + parameters.size(), 0);
  for (std::size_t at = begin; at < end; ++at) {
    const std::string& word = words[at];
    const auto parameter = std::find(parameters.begin(), parameters.end(), word);
    if (parameter != parameters.end()) {
      add_to(sum, {1});  // an empty argument still takes a step
      sum[1 + static_cast<std::size_t>(parameter - parameters.begin())] += 1;
      continue;
    }
    const auto macro = macros_.find(word);
    if (macro == macros_.end() || open_[word]) {
      add_to(sum, {1});
      continue;
    }
    const bool takes_arguments = std::any_of(macro->second.begin(), macro->second.end(),
                                             [](const Macro& m) { return m.takes_arguments; });
    const Length length = length_of_name(word);
    add_to(sum, {1 + length[0]});
    if (!takes_arguments) continue;
    if (at + 1 >= end || words[at + 1] != "(") {
      for (std::size_t k = 1; k < length.size(); ++k) add_to(sum, {kUnknownArgument * length[k]});
      continue;
    }
    std::size_t argument = 1, first = at + 2;
    int depth = 1;
    for (at = first; at < end; ++at) {
      const std::string& w = words[at];
      if (w == "(") ++depth;
      if (w == ")") --depth;
      if (depth > 0 && !(w == "," && depth == 1)) continue;
      add_to(sum, length_of(words, first, at, parameters), argument < length.size() ? 1 + length[argument] : 1);
      ++argument;
      first = at + 1;
      if (depth == 0) break;
    }
  }
  return sum;
}

}  // namespace aluminate::compiler
