// aluminate.toml: which pictures and costs a project holds on to. In: the text. Out: one spec for each named
// check, its options resolved. Every mistake is a UserError with file:line:column; nothing is rendered and no
// golden is read.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "platform/host/error.hpp"
#include "shading/passes/options.hpp"

namespace aluminate::report {

struct CheckSpec {
  std::string name;                             // "wall/cheap"; also the golden's file name
  std::string scene;                            // a scene to render, or empty:
  std::string subject;                          // a shader file or variant as `aluminate cost` takes it
  std::string stage = "pixel", entry = "main";  // of the subject
  passes::FrameOptions options;
  bool image = true, cost = true;  // what is compared
  double budget_ms = 0;            // > 0: the frame must also fit
  SourcePlace place;
};

struct CheckFile {
  std::string path;
  std::string goldens = "goldens";         // folder of accepted results
  std::string output = "aluminate-check";  // folder for the pages that show differences
  std::vector<CheckSpec> checks;           // in the order of the file, lists expanded
};

CheckFile parse_check_file(std::string_view text, const std::string& path);
CheckFile load_check_file(const std::string& path);

}  // namespace aluminate::report
