// `aluminate cost --watch`: the price again whenever a shader or one of its includes changes, with what the
// change did. In: a request, a way to print and a way to wait. Out: text as it comes. A shader that does not
// compile while it is being edited is reported and watched on.
#pragma once

#include <functional>
#include <string>

#include "shading/report/cost_report.hpp"

namespace aluminate::report {

struct Watcher {
  std::function<void(const std::string&)> print;
  std::function<bool()> wait;  // called between two looks at the files; false ends the watch
};

/// Throws UserError when no subject is a file. Text that follows the first report: one line a figure that
/// changed, with helped or HURT, and the first differing instruction.
void watch_cost(const CostRequest& request, const Watcher& watcher);

}  // namespace aluminate::report
