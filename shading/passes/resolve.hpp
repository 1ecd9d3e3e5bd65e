// From linear radiance to stored pixels through a tone map: a pass of its own, in the VM, billed.
#pragma once

#include "shading/passes/draw_list.hpp"
#include "shading/passes/frame.hpp"

namespace aluminate::passes {

/// With a tone map: fills rgba8 and adds the pass "resolve" to the bill. Without, the render target's clamp does it for
/// free, tile by tile (tile_pixels.hpp), and nothing is left to do.
void resolve(const FrameOptions& options, const DrawList& list, Frame& frame);

}  // namespace aluminate::passes
