// Runs the program under test: arguments in; exit code, stdout and stderr out.
#pragma once

#include <string>
#include <vector>

namespace aluminate::test {

struct Finished {
  int code = -1;  // exit code; 128 + signal when killed
  std::string out, error;
};

/// working_directory empty: the current one. interrupt_after_ms > 0: SIGINT is sent then.
Finished run_program(const std::vector<std::string>& arguments, const std::string& working_directory = {},
                     int interrupt_after_ms = 0);

}  // namespace aluminate::test
