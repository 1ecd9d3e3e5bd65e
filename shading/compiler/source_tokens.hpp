// Shader text as words, numbers and single characters, comments and strings left out. Knows no grammar.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace aluminate::compiler {

struct Token {
  std::string_view text;
  int line = 0, column = 0;
};

// Words, numbers and single characters outside comments and strings.
class Tokens {
 public:
  explicit Tokens(const std::string& text) : text_(text) {}

  bool next(Token& token) {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '\n') {
        step(1);
      } else if (std::isspace(static_cast<unsigned char>(c)) != 0) {
        step(1);
      } else if (text_.compare(at_, 2, "//") == 0) {
        while (at_ < text_.size() && text_[at_] != '\n') step(1);
      } else if (text_.compare(at_, 2, "/*") == 0) {
        const auto end = text_.find("*/", at_ + 2);
        step(end == std::string::npos ? text_.size() - at_ : end + 2 - at_);
      } else if (c == '"') {
        std::size_t end = at_ + 1;
        while (end < text_.size() && text_[end] != '"' && text_[end] != '\n') ++end;
        step(std::min(end + 1, text_.size()) - at_);
      } else {
        std::size_t size = 1;
        const auto word = [](char ch) {
          return std::isalnum(static_cast<unsigned char>(ch)) != 0 || ch == '_';
        };
        if (word(c))
          while (at_ + size < text_.size() && word(text_[at_ + size])) ++size;
        token = {std::string_view(text_).substr(at_, size), line_, column_};
        step(size);
        return true;
      }
    }
    return false;
  }

 private:
  void step(std::size_t n) {
    for (; n > 0 && at_ < text_.size(); --n, ++at_) {
      ++column_;
      if (text_[at_] == '\n') {
        ++line_;
        column_ = 1;
      }
    }
  }
  const std::string& text_;
  std::size_t at_ = 0;
  int line_ = 1, column_ = 1;
};

inline bool is_word(std::string_view t) {
  return !t.empty() && (std::isalpha(static_cast<unsigned char>(t[0])) != 0 || t[0] == '_');
}


}  // namespace aluminate::compiler
