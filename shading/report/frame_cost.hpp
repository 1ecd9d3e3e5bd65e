// A frame's counts to console milliseconds: the bridge from passes::PassTotals to platform/console's budget
// arithmetic.
#pragma once

#include <vector>

#include "platform/console/frame_budget.hpp"
#include "shading/passes/frame.hpp"

namespace aluminate::report {

/// One PassWork for each pass of the frame. Every target is 32-bit, with D24, both with the frame's samples a
/// pixel (a written pixel is billed with all of them); on consoles with eDRAM a pass pays for the targets
/// later passes fetch and the last one for the resolve of the picture.
std::vector<console::PassWork> pass_work(const passes::Frame& frame, const console::GpuModel& gpu);

/// budget_ms <= 0: the platform's own frame.
console::FrameBudget frame_budget(const passes::Frame& frame, const console::GpuModel& gpu, double budget_ms);

}  // namespace aluminate::report
