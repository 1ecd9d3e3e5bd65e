// How long a source becomes once its macros are expanded, without expanding them: a macro of two copies of a macro of
// two copies ... doubles with every line, and the preprocessor would build it all. In: the texts of one shader as they
// are met. Out: nothing, or a UserError once the bound passes kMaxExpandedTokens.
//
// The bound takes the longest body of each name, wherever and under whatever condition it is defined. A name that is
// passed on to be called elsewhere is counted by a rule of thumb.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace aluminate::compiler {

class MacroSize {
 public:
  /// Adds a text and checks all so far. file names it in the error.
  void add(const std::string& text, const std::string& file);

 private:
  using Words = std::vector<std::string>;
  struct Macro {
    bool takes_arguments = false;
    Words parameters, body;
  };
  /// Length as a linear function of the lengths of a macro's arguments: [0] alone, [1 + i] times argument i.
  using Length = std::vector<double>;

  void define(const Words& line);
  Length length_of(const Words& words, std::size_t begin, std::size_t end, const Words& parameters);
  Length length_of(const std::string& name, const Macro& macro);
  Length length_of_name(const std::string& name);

  std::map<std::string, std::vector<Macro>, std::less<>> macros_;
  std::vector<Words> texts_;                           // what is not a definition
  std::map<std::string, Length, std::less<>> known_;   // by macro
  std::map<std::string, bool, std::less<>> open_;      // being measured: not expanded inside itself
};

}  // namespace aluminate::compiler
