// Two kinds of failure that never stand in for each other.
//   UserError   the input or the command line is wrong: file:line:column, what, hint. Caught once, in apps/; exit 2.
//   ALU_CHECK   a bug of ours: prints the condition and its operands and throws InternalError; exit 3.
// Diagnostics (notes, warnings) are neither: see platform/host/log.hpp.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <stdexcept>
#include <string>

namespace aluminate {

/// A place in a user's file. line and column count from 1; 0 = not known.
struct SourcePlace {
  std::string file;
  int line = 0;
  int column = 0;

  /// "file:line:column", leaving out what is not known; empty when there is no file.
  std::string text() const {
    if (file.empty()) return "";
    if (line <= 0) return file;
    return column > 0 ? fmt::format("{}:{}:{}", file, line, column) : fmt::format("{}:{}", file, line);
  }
};

class UserError : public std::runtime_error {
 public:
  UserError(SourcePlace place, const std::string& what, std::string hint = {})
      : std::runtime_error(place.text().empty() ? what : place.text() + ": " + what),
        place_(std::move(place)),
        hint_(std::move(hint)) {}
  // A template, because {file} in braces, meant as a place, would rather be a string.
  template <class Text>
    requires std::convertible_to<const Text&, std::string>
  explicit UserError(const Text& what, std::string hint = {}) : UserError(SourcePlace{}, what, std::move(hint)) {}

  const SourcePlace& place() const { return place_; }
  const std::string& hint() const { return hint_; }

 private:
  SourcePlace place_;
  std::string hint_;
};

class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] inline void fail_check(const char* file, int line, const char* condition, const std::string& detail) {
  throw InternalError(fmt::format("{}:{}: check failed: {}{}{}", file, line, condition, detail.empty() ? "" : ": ", detail));
}

}  // namespace aluminate

/// ALU_CHECK(condition, "format", operands...): on in every build; not for inner loops.
#define ALU_CHECK(condition, ...)                                                                  \
  do {                                                                                             \
    if (!(condition)) ::aluminate::fail_check(__FILE__, __LINE__, #condition, fmt::format(__VA_ARGS__)); \
  } while (false)
