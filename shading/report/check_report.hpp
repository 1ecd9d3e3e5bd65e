// What a run of checks found, for people (text, Markdown) and for machines (JUnit XML). Pure formatting;
// everything but the times in JUnit is the same on every machine.
#pragma once

#include <string>

#include "shading/report/check.hpp"

namespace aluminate::report {

/// One line a check, then for each that is not ok what changed, where to look and the command that accepts
/// it.
std::string check_text(const CheckRun& run);
std::string check_markdown(const CheckRun& run);
std::string check_junit(const CheckRun& run);

/// What changed between two prices: a line for each figure and for the first differing instruction of each
/// program.
std::string difference_lines(const GoldenDifference& difference);

}  // namespace aluminate::report
