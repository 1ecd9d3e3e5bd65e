// The 24 patches of a ColorChecker Classic as its makers publish them: before and after the paint change of
// November 2014. Out: names and reference colours under D50 as published and as linear sRGB under D65
// (Bradford), which is what a photograph is corrected to. Patch 18 (cyan) lies outside of sRGB: its red stays
// negative, nothing is clipped here.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "calibration/colour_space.hpp"

namespace aluminate::calibration {

inline constexpr std::size_t kPatchCount = 24;
inline constexpr int kChartColumns = 6,
                     kChartRows = 4;  // patch i: column i % 6, row i / 6; row 3 is white .. black

inline constexpr std::size_t kWhitePatch = 18, kBlackPatch = 23;

enum class ChartEdition {
  Before2014,  // GretagMacbeth 2005, xyY under D50 [ColourScience]
  After2014,   // X-Rite, Lab under D50 [XRite2014]
};

std::string_view edition_name(ChartEdition edition);  // "before-2014", "after-2014"
ChartEdition parse_edition(std::string_view name);    // UserError with the names

const std::array<std::string_view, kPatchCount>& patch_names();  // "dark skin", ...

struct ChartReference {
  ChartEdition edition;
  std::array<Colour, kPatchCount> lab_d50;
  std::array<Colour, kPatchCount> rgb_lin;  // sRGB primaries, D65, reflectance: white about 0.9
  std::array<Colour, kPatchCount> lab_d65;  // of rgb_lin
  int outside_gamut = 0;                    // patches with a component of rgb_lin outside of [0, 1]
};

const ChartReference& chart_reference(ChartEdition edition);

}  // namespace aluminate::calibration
