// Named checks against what was accepted: renders or prices, compares exactly, explains the first difference,
// and accepts one name at a time. In: a check file, read relative to the working directory. Out: results to
// print (check_report.hpp), pages to look at, goldens when asked for. Never accepts what two renderings
// disagree on.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "shading/report/check_file.hpp"
#include "shading/report/golden.hpp"
#include "shading/report/statistics.hpp"

namespace aluminate::report {

enum class Outcome : std::uint8_t {
  Ok,          // as accepted
  Differs,     // see difference
  OverBudget,  // as accepted, but over budget_ms
  Missing,     // never accepted
  Extra,       // a golden that no check names
  Unstable,    // two renderings with other threads and vector widths differ
  Accepted,    // --update
  Removed,     // --update of an extra golden
  Error,       // could not be rendered, priced or read
};

/// The first pixel, in reading order, that differs.
struct PixelChange {
  int x = -1, y = -1;
  std::array<int, 4> before{}, after{};  // stored RGBA, 0..255
  std::string draw;                      // "draw 3 'wall', drawn"; empty: background
};

struct CheckResult {
  std::string name;
  Outcome outcome = Outcome::Ok;
  Golden accepted, found;
  GoldenDifference
      difference;         // Differs, Accepted: from what was accepted before; Unstable: of the two renderings
  ImageDifference image;  // where the picture differs
  PixelChange pixel;
  std::string page;          // HTML that shows the difference; empty: none
  std::string message;       // Error: what and hint, one a line
  std::string renamed_from;  // Missing: an extra golden with the same contents
  double frame_ms = 0, budget_ms = 0;
  double seconds = 0;  // wall time; the only field that varies
};

struct CheckRequest {
  CheckFile file;
  std::vector<std::string> names;   // empty: all, and goldens that no check names are reported
  std::vector<std::string> update;  // accept these; only they are run
  bool verify = false;              // render everything twice; accepting always does
};

struct CheckRun {
  std::vector<CheckResult> results;
  int count(Outcome outcome) const;
  /// 0 all ok or accepted; 1 something differs, is missing, extra, unstable or over budget; 2 an error.
  int exit_code() const;
};

/// Throws UserError for names that do not exist and for --update on a machine whose self-test fails. What
/// goes wrong inside one check is that check's Error and stops no other.
CheckRun run_checks(const CheckRequest& request);

/// "goldens/wall/cheap.toml" and ".png".
std::string golden_path(const CheckFile& file, const std::string& name);
std::string golden_picture_path(const CheckFile& file, const std::string& name);

}  // namespace aluminate::report
