// What every subcommand shares: the exit code, the command as typed (for reports) and the common options. A
// command file declares its arguments, calls one library function and prints what comes back; it decides
// nothing.
#pragma once

#include <CLI/CLI.hpp>

#include <map>
#include <string>
#include <vector>

#include "shading/passes/options.hpp"

namespace aluminate::apps {

enum ExitCode { kDone = 0, kAnswerIsNo = 1, kUsageError = 2, kOurBug = 3 };

struct Session {
  int exit_code = kDone;
  std::string command;  // argv joined, as typed
};

/// --size --camera --visibility ... as passes::option_table() lists them, and --threads. Values are kept as
/// text until resolve(), so that every mistake is reported the same way.
class FrameArguments {
 public:
  /// names: the subset of option_table() a command takes; empty: all.
  void add_to(CLI::App& command, const std::vector<std::string>& names = {});
  /// Applies --threads and returns the options. Throws UserError.
  passes::FrameOptions resolve() const;

 private:
  std::map<std::string, std::vector<std::string>> values_;
  bool checked_ = false;
  int threads_ = 0;
};

/// Each adds one verb to the program.
void add_render(CLI::App& app, Session& session);
void add_compare(CLI::App& app, Session& session);
void add_cost(CLI::App& app, Session& session);
void add_pixel(CLI::App& app, Session& session);
void add_eval(CLI::App& app, Session& session);
void add_platform(CLI::App& app, Session& session);
void add_scene(CLI::App& app, Session& session);
void add_diff(CLI::App& app, Session& session);
void add_sweep(CLI::App& app, Session& session);
void add_sky(CLI::App& app, Session& session);
void add_toksvig(CLI::App& app, Session& session);
void add_cubemap(CLI::App& app, Session& session);
void add_calibrate(CLI::App& app, Session& session);
void add_check(CLI::App& app, Session& session);
void add_doctor(CLI::App& app, Session& session);

}  // namespace aluminate::apps
