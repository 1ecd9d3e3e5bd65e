// What a check accepted: the hash of a picture and every cost of it, exact, as a small text file that reads
// well in a diff. In: a rendered frame or a priced shader. Out: the same numbers to compare with those of an
// earlier day. Nothing here renders, and nothing is compared with a tolerance.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "shading/cost/static_cost.hpp"
#include "shading/report/document.hpp"

namespace aluminate::report {

/// One number. The key ends in its unit or is a count: alu_words, fetch_cyc, alu_clk, derated_ms.
struct GoldenFigure {
  std::string key;
  double value = 0;
  bool operator==(const GoldenFigure&) const = default;
};

/// A pass of a frame, a program, or the frame itself.
struct GoldenSection {
  std::string kind;  // "frame", "pass", "program"
  std::string name;  // "forward"; empty for the frame
  std::vector<GoldenFigure> figures;
  std::vector<std::string> instructions;  // programs: as they issue, one a line

  std::string label() const { return name.empty() ? kind : kind + " " + name; }
};

struct Golden {
  std::string check;    // name
  std::string command;  // makes it again
  int width = 0, height = 0;
  std::string image_hash;  // XXH3-128 of the stored picture; empty: costs only
  std::vector<GoldenSection> sections;
};

/// Numbers of a frame and of each program that took part in it.
Golden golden_of(const std::string& check, const Billed& billed, bool with_image, bool with_cost);
/// Numbers of shaders before anything runs.
Golden golden_of(const std::string& check, const std::string& command,
                 const std::vector<cost::StaticCost>& costs);

/// The file's text, and back (golden_file.cpp). `path` names it in messages. Throws UserError with
/// file:line:column for anything that write_golden would not have written.
std::string write_golden(const Golden& golden);
Golden parse_golden(std::string_view text, const std::string& path);

enum class Change { None, Helped, Hurt, Other };
/// "same", "helped", "HURT", "changed".
std::string_view change_word(Change change);

struct FigureChange {
  std::string section, key;
  double before = 0, after = 0;
  bool was_there = true, is_there = true;
  Change change = Change::Other;
};

/// The first place where two listings of a program part.
struct InstructionChange {
  std::string section;
  std::size_t line = 0;       // 0-based
  std::string before, after;  // empty: the listing ends here
};

struct GoldenDifference {
  bool image_differs = false;
  std::vector<FigureChange> figures;
  std::vector<InstructionChange> instructions;  // at most one a program
  bool cost_differs() const { return !figures.empty() || !instructions.empty(); }
  bool same() const { return !image_differs && !cost_differs(); }
  /// Hurt when any cost rose, else Helped when any fell, else Other.
  Change cost_change() const;
};

GoldenDifference compare_goldens(const Golden& accepted, const Golden& found);

}  // namespace aluminate::report
