// The colour of each patch of a chart whose corners are known. In: a photograph and the four corner centres.
// Out: robust means over the middle of each patch with what is wrong with it: clipped, uneven. Never changes
// the photograph.
#pragma once

#include <array>

#include "calibration/chart_geometry.hpp"
#include "calibration/fit.hpp"
#include "calibration/photo.hpp"

namespace aluminate::calibration {

inline constexpr double kSampledHalfWidth = 0.2;  // of the distance between centres: the middle 40 %
inline constexpr double kMaxClippedShare = 0.02;  // more pixels than this at a limit bias the mean
inline constexpr double kUnevenReported = 0.05;   // luminance across a patch: above it is said so,
inline constexpr double kUnevenRefused =
    0.25;  // above this the patch is not used: a shadow, a reflection, a thumb

struct PatchSample {
  Point centre;
  Colour mean{};       // linear RGB of the photograph, without outliers
  Colour deviation{};  // standard deviation of the pixels kept
  int pixels = 0;      // looked at
  int outliers = 0;    // left out: further than 3 robust standard deviations from the median
  double clipped_high = 0.0, clipped_low = 0.0;  // share of pixels with a channel at its limit
  double unevenness =
      0.0;  // difference of opposite halves over the mean, of luminance, the larger of the two axes
  bool is_clipped() const { return clipped_high > kMaxClippedShare || clipped_low > kMaxClippedShare; }
  bool is_uneven() const { return unevenness > kUnevenReported; }
  bool usable() const { return pixels > 0 && !is_clipped() && unevenness <= kUnevenRefused; }
};

using PatchSamples = std::array<PatchSample, kPatchCount>;

/// Enough for a mean 50 times quieter than a pixel; a patch of a large photograph has hundreds of thousands.
inline constexpr int kMostPixels = 20000;

/// most_pixels: looked at in a patch, about; larger ones are sampled in equal steps.
PatchSamples sample_patches(const Photo& photo, const Corners& corners, int most_pixels = kMostPixels);

PatchColours colours_of(const PatchSamples& samples);

/// How well an affine map of linear RGB turns the patches into the chart's: 1 - residual/variance over usable
/// patches, summed over channels, of cube-rooted values so that dark patches count. A chart: above 0.85; the
/// same chart turned or mirrored, or a grid of other colours: below 0.6.
double chart_agreement(const PatchColours& colours, const ChartReference& reference);

}  // namespace aluminate::calibration
