// One pixel under the microscope: every draw that touched it, what became of it, and each instruction with
// its value.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "shading/passes/frame.hpp"

namespace aluminate::passes {

/// One instruction as the pixel's lane executed it.
struct TracedInstruction {
  std::string text, place;  // "mad r3.xyz, ...", "material.hlsl:81:5"
  std::array<double, 4> value{};
  std::uint8_t mask = 0;  // components written
  bool saturated = false;
};

/// One fragment of a draw at the pixel, or one helper lane: on the bill, or turned away before it was shaded.
struct PixelVisit {
  std::uint32_t draw = 0;
  std::string mesh, program;
  /// "drawn", "blended", "discarded" (alpha test) · "overdrawn": passed the depth test, a later draw covers
  /// it · "z-failed": shaded, then behind what was there · "z-failed early": rejected before shading, costs
  /// nothing · "helper lane" · "lit", "not lit": draws over the G-buffer.
  std::string outcome;
  std::uint32_t alu_words = 0, alu_slots = 0, fetches = 0, fetch_cyc = 0;
};

struct PixelReport {
  int x = 0, y = 0;
  std::array<double, 3> linear{};        // after the last draw, the mean of its samples
  std::uint32_t depth_d24 = 0;           // of the first sample
  std::vector<PixelVisit> visits;        // submission order
  std::vector<TracedInstruction> trace;  // of the last draw that was executed here
  std::string traced_program;
  std::uint32_t alu_words = 0, alu_slots = 0, fetches = 0,
                fetch_cyc = 0;  // sums over visits = the cost layers at this pixel
};

/// Throws UserError when (x, y) lies outside the picture.
PixelReport inspect_pixel(const scenes::Scene& scene, const FrameOptions& options, int x, int y);

std::string pixel_text(const PixelReport& report);

}  // namespace aluminate::passes
