// Finds a ColorChecker in a photograph and says which patch is which. Two finders propose, one judge decides:
// grids of uniform areas (ours), then OpenCV's mcc when those fail. The judge turns a proposal into the four
// orientations a chart can have, aligns it to the patches' edges, and accepts it when the colours agree and
// all 24 patches are inside and sharp. A photograph without a usable chart is a UserError with the reason:
// none found, cut off, blurred.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "calibration/patch_sampling.hpp"

namespace aluminate::calibration {

enum class ChartFinder { Auto, Grid, OpenCv };
ChartFinder parse_chart_finder(std::string_view name);  // "auto", "grid", "opencv"

struct FoundChart {
  Corners corners{};
  double agreement = 0.0;   // chart_agreement of its 24 patches
  double edge_width = 0.0;  // blur: 10-90 % width of the patches' edges, in distances between patches
  std::string finder;       // "grid", "opencv mcc", "corners"
};

inline constexpr double kMinAgreement = 0.75;
inline constexpr double kMaxEdgeWidth = 0.40;  // wider edges meet in the sampled middle of a patch

FoundChart find_chart(const Photo& photo, const ChartReference& reference, const std::string& name,
                      ChartFinder finder = ChartFinder::Auto);

/// Judges corners that the user gave; they are kept as they are. Throws UserError when they cannot be a
/// chart's, with the order they seem to be in when they are four right points in a wrong order.
FoundChart check_chart(const Photo& photo, const Corners& corners, const ChartReference& reference,
                       const std::string& name);

/// Moves the corners by less than half a patch: first to where the patches' insides are most uniform, then so
/// that every patch lies in the middle between its edges.
Corners align_to_patches(const Photo& photo, const Corners& corners);

/// The median over the chart of how wide the edge between a patch and its surround is, in distances between
/// patches.
double chart_edge_width(const Photo& photo, const Corners& corners);

}  // namespace aluminate::calibration
