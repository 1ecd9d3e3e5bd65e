#include "shading/compiler/source_scan.hpp"

#include "platform/host/error.hpp"
#include "shading/compiler/limits.hpp"
#include "shading/compiler/source_tokens.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <vector>

namespace aluminate::compiler {
namespace {

// How many statements are open around a token: what a parser's recursion depth is made of. An if or loop lasts to the
// end of the statement it governs; an else takes up the if before it.
class StatementDepth {
 public:
  int next(std::string_view t) {
    if (t == "(") ++round_;
    if (t == ")") round_ = std::max(round_ - 1, 0);
    if (t == "else") {  // the one it follows has just ended
      total_ += ended_ - open_.back();
      open_.back() = ended_;
    }
    if (t == "if" || t == "else" || t == "for" || t == "while" || t == "do" || t == "switch") add(1);
    if (t == "{") {
      open_.push_back(0);
      round_ = 0;
    }
    if (t == "}") {
      total_ -= open_.back();
      if (open_.size() > 1) open_.pop_back();
      else open_.back() = 0;
      end();
    }
    if (t == ";" && round_ == 0) end();
    return total_;
  }

 private:
  void add(int n) {
    open_.back() += n;
    total_ += n;
  }
  void end() {
    ended_ = open_.back();
    total_ -= ended_;
    open_.back() = 0;
  }
  std::vector<int> open_{0};  // by block
  int total_ = 0, ended_ = 0, round_ = 0;
};

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
  int depth = 0, prefix = 0, operators = 0;
  StatementDepth statements;
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
    if (statements.next(t.text) > kMaxStatementDepth)
      throw UserError(here, fmt::format("statements nested deeper than {}", kMaxStatementDepth),
                      "an 'else if' lies inside the 'else' before it");
    // Parsers recurse on long expressions.
    if (is_operator) ++operators;
    if (c == ';' || c == '{' || c == '}') operators = 0;
    if (operators > 20000) throw UserError(here, "an expression with more than 20000 operators");
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
