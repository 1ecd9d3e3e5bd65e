// Shared between the two kernel files; see shading/vm/decoded.hpp for what the rest of the VM uses.
#pragma once

#include "shading/vm/decoded.hpp"

namespace aluminate::vm {

/// Clamps the destination row to the grid's range and counts covered lanes. The slow path of Post::Range, taken only
/// when some lane is out of range. op.masked: touches only lanes of the execution mask.
void enforce_range(const Operation& op, Frame& frame) noexcept;

/// Kernels that are not elementwise; nullptr for the elementwise ones.
KernelFunction find_lane_kernel(Kernel kernel);

}  // namespace aluminate::vm
