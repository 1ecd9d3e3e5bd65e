// A calibration as files for others: JSON for programs, .cube for OpenColorIO and editors, a glTF square for
// the renderer. In: a finished calibration. Out: text. Deterministic; numbers are printed so that they read
// back the same.
#pragma once

#include <string>

#include "calibration/calibrate.hpp"

namespace aluminate::calibration {

/// Schema "aluminate.calibrate/1".
std::string calibration_json(const Calibration& calibration, const std::string& command);

/// Resolve's .cube text [Cube10]: sRGB-encoded photograph in, sRGB-encoded albedo out, red fastest, clipped
/// to [0, 1].
std::string cube_text(const Transform& transform, int size, const std::string& title);

/// A square of width:height with the albedo as base colour, rough and not metallic. texture: path as seen
/// from the file.
std::string material_gltf(const std::string& texture, int width, int height);

}  // namespace aluminate::calibration
