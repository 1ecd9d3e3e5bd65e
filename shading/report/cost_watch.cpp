#include "shading/report/cost_watch.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "platform/host/error.hpp"
#include "shading/report/check_report.hpp"
#include "shading/report/golden.hpp"

namespace aluminate::report {
namespace {

namespace fs = std::filesystem;

/// When each file was written, and its size: an editor that restores the time still changes something.
using FileTimes = std::map<std::string, std::pair<std::optional<fs::file_time_type>, std::uintmax_t>>;

FileTimes look_at(const std::set<std::string>& files) {
  FileTimes times;
  for (const std::string& file : files) {
    std::error_code error;
    const fs::file_time_type time = fs::last_write_time(file, error);
    const std::uintmax_t size = error ? 0 : fs::file_size(file, error);
    times[file] = {error ? std::nullopt : std::optional(time), size};  // absent while an editor renames
  }
  return times;
}

}  // namespace

void watch_cost(const CostRequest& request, const Watcher& watcher) {
  std::set<std::string> files;
  for (const std::string& subject : request.subjects)
    if (fs::exists(subject)) files.insert(subject);
  if (files.empty())
    throw UserError("--watch needs a shader file", "variants of the shipped shader do not change");

  std::optional<Golden> before;
  const auto price = [&] {
    try {
      const std::vector<cost::StaticCost> costs = price_subjects(request);
      for (const cost::StaticCost& cost : costs)
        for (const std::string& file : cost.files)
          if (fs::exists(file)) files.insert(file);
      const Golden now = golden_of("watch", cost_command(request), costs);
      watcher.print(before ? difference_lines(compare_goldens(*before, now)) : cost_report(request));
      before = now;
    } catch (const UserError& error) {
      watcher.print(
          fmt::format("{}\n{}", error.what(), error.hint().empty() ? "" : "  " + error.hint() + "\n"));
    }
  };
  price();
  for (FileTimes seen = look_at(files); watcher.wait();) {
    if (FileTimes now = look_at(files); now == seen) continue;
    price();
    seen = look_at(files);
  }
}

}  // namespace aluminate::report
