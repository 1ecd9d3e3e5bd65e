#include "shading/compiler/source_scan.hpp"

#include "platform/host/error.hpp"
#include "shading/compiler/front_end.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace aluminate::compiler {
namespace {

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

bool is_word(std::string_view t) {
  return !t.empty() && (std::isalpha(static_cast<unsigned char>(t[0])) != 0 || t[0] == '_');
}

}  // namespace

void scan_source(const std::string& text, const std::string& file) {
  if (text.size() > kMaxSourceBytes)
    throw UserError(SourcePlace{file, 0, 0}, fmt::format("the source has {} bytes", text.size()),
                    fmt::format("the limit is {}", kMaxSourceBytes));
  if (const auto zero = text.find('\0'); zero != std::string::npos)
    throw UserError(
        SourcePlace{file,
                    static_cast<int>(
                        1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(zero), '\n')),
                    0},
        "the source contains a zero byte", "is this a binary file? SPIR-V modules end in .spv");
  Tokens tokens(text);
  Token t;
  int depth = 0, prefix = 0, operators = 0, nested = 0;
  while (tokens.next(t)) {
    const SourcePlace here{file, t.line, t.column};
    const char c = t.text[0];
    if (c == '(' || c == '[' || c == '{') ++depth;
    if (c == ')' || c == ']' || c == '}') depth = std::max(depth - 1, 0);
    if (depth > kMaxBracketDepth)
      throw UserError(here, fmt::format("brackets nested deeper than {}", kMaxBracketDepth));
    const bool is_operator = std::string_view("-+!~*&|<>=?:,/%^.").find(c) != std::string_view::npos;
    prefix = is_operator ? prefix + 1 : 0;
    if (prefix > kMaxBracketDepth)
      throw UserError(here, fmt::format("more than {} operators in a row", kMaxBracketDepth));
    // Parsers recurse on long expressions and on statements without braces; both end at ; or }.
    if (is_operator) ++operators;
    if (t.text == "if" || t.text == "else" || t.text == "for" || t.text == "while" || t.text == "do")
      ++nested;
    if (c == ';' || c == '{' || c == '}') operators = 0;
    if (c == '}' || (c == ';' && depth == 0)) nested = std::max(nested - 4, 0);
    if (operators > 20000) throw UserError(here, "an expression with more than 20000 operators");
    if (nested > 4000) throw UserError(here, "statements nested too deeply");
  }
}

void refuse_effect_syntax(const std::string& text, const std::string& file) {
  struct Rule {
    std::string_view word, follow, what, hint;
  };
  static constexpr std::array kRules = {
      Rule{"technique", "", "unsupported: effect-framework 'technique' blocks",
           "keep the functions only and name the entry point with --entry"},
      Rule{"technique10", "", "unsupported: effect-framework 'technique10' blocks",
           "keep the functions only and name the entry point with --entry"},
      Rule{"technique11", "", "unsupported: effect-framework 'technique11' blocks",
           "keep the functions only and name the entry point with --entry"},
      Rule{"sampler_state", "", "unsupported: 'sampler_state' blocks",
           "declare 'sampler2D name : register(sN);'; filters and wrap modes come from the scene"},
      Rule{"stateblock_state", "", "unsupported: 'stateblock_state' blocks",
           "render state does not belong to the shader here"},
      Rule{"asm", "{", "unsupported: inline 'asm'", "write tfetch2D as tex2D, tex2Dlod or tex2Dgrad"},
      Rule{"compile", "ps_", "unsupported: 'compile' expressions", "name the entry point with --entry"},
      Rule{"texture", "word;", "unsupported: 'texture' objects",
           "declare 'sampler2D name : register(sN);' alone"},
  };
  Tokens tokens(text);
  Token t, previous{}, before{};
  while (tokens.next(t)) {
    for (const Rule& rule : kRules) {
      bool hit = rule.follow.empty() && t.text == rule.word && previous.text != "." && previous.text != "#";
      if (rule.follow == "{") hit = previous.text == rule.word && t.text == "{";
      if (rule.follow == "ps_")
        hit = previous.text == rule.word && (t.text.starts_with("ps_") || t.text.starts_with("vs_"));
      if (rule.follow == "word;")
        hit = before.text == rule.word && is_word(previous.text) && (t.text == ";" || t.text == "<");
      if (!hit) continue;
      const Token& at = rule.follow.empty() ? t : rule.follow == "word;" ? before : previous;
      throw UserError(SourcePlace{file, at.line, at.column}, std::string(rule.what), std::string(rule.hint));
    }
    before = previous;
    previous = t;
  }
}

void find_explicit_registers(const std::string& text, std::set<std::string>& names) {
  Tokens tokens(text);
  Token t;
  std::string name;  // last word outside brackets
  int square = 0;
  enum { Nothing, Colon, Register, Open } state = Nothing;
  while (tokens.next(t)) {
    if (t.text == "[") ++square;
    if (t.text == "]") --square;
    if (state == Open) {
      if (t.text.size() > 1 && (t.text[0] == 'c' || t.text[0] == 'C')) names.insert(name);
      state = Nothing;
    } else if (state == Register) {
      state = t.text == "(" ? Open : Nothing;
    } else if (state == Colon && t.text == "register") {
      state = Register;
    } else if (t.text == ":") {
      state = Colon;
    } else {
      state = Nothing;
      if (square == 0 && is_word(t.text)) name = t.text;
    }
  }
}

}  // namespace aluminate::compiler
