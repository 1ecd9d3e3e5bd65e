// From linear radiance to stored pixels: tone map (a pass of its own, in the VM, billed) and sRGB encoding.
#pragma once

#include <array>
#include <glm/glm.hpp>

#include "shading/passes/draw_list.hpp"
#include "shading/passes/frame.hpp"

namespace aluminate::passes {

/// Linear light of the stored display values a picture is cleared to.
std::array<float, 3> linear_background(const glm::dvec3& stored);
/// Fills `linear` with the background's linear value, so that blending over it is right.
void clear_to_background(const glm::dvec3& stored, Frame& frame);

/// Fills rgba8. With a tone map, adds the pass "resolve" to the bill; without, the render target's clamp does
/// it for free.
void resolve(const FrameOptions& options, const DrawList& list, Frame& frame);

}  // namespace aluminate::passes
