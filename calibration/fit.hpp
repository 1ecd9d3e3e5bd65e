// Fits of a colour transform to 24 measured patches. In: the photograph's linear RGB of each patch, which
// patches may be used, the chart's reference. Out: a Transform, the RMS after each stage, and how far every
// patch is from its reference.
// --fit auto tries all kinds and keeps the one with the smallest error on patches it was not fitted to.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/chart.hpp"
#include "calibration/transform.hpp"

namespace aluminate::calibration {

struct PatchColours {
  std::array<Colour, kPatchCount> rgb_lin{};  // of the photograph
  std::array<bool, kPatchCount> usable{};     // false: clipped or damaged; not fitted, still reported

  std::size_t usable_count() const;
};

enum class FitKind { Auto, AffinePolyAffine, Linear, RootPoly, ToneLinear };
FitKind parse_fit_kind(
    std::string_view name);  // "auto", "affine-poly-affine", "linear", "root-poly", "tone-linear"

inline constexpr std::size_t kMinUsablePatches = 8;

/// Per-patch difference from the reference in CIEDE2000 and CIE76, and their summaries over the patches
/// given.
struct Differences {
  std::array<double, kPatchCount> de2000{}, de76{};
  double mean_de2000 = 0.0, max_de2000 = 0.0, mean_de76 = 0.0;
};
/// Over all patches, also those a fit left out.
Differences differences(const std::array<Colour, kPatchCount>& rgb_lin, const ChartReference& reference);

struct Fit {
  Transform transform;
  std::vector<double>
      stage_rms;  // of AffinePolyAffine: xyY RMS of input, affine, polynomial, affine; never rises
  double held_out_de2000 =
      0.0;  // mean over usable patches, each predicted by a fit without it; 0 when not computed
  std::array<Colour, kPatchCount> corrected{};
  Differences before, after;
};

/// One line of the comparison that --fit auto made.
struct Candidate {
  std::string name;
  std::optional<double> held_out_de2000;  // empty: the samples do not determine this fit
  std::string objection;                  // why it is not chosen although it predicts patches well, or empty
};

/// "", or why a transform is no map from light to albedo, which held-out patches cannot tell: on the ramp
/// from no light to the brightest usable patch, more light must not become a darker albedo.
std::string objection_to(const Transform& transform, const PatchColours& samples);

struct FitChoice {
  Fit fit;
  std::vector<Candidate> candidates;
};

/// One kind. degree: 1..5 for AffinePolyAffine, 1..3 for RootPoly, ignored otherwise. Not Auto. Throws
/// UserError when too few patches are usable, a usable one is not finite, or they do not determine the
/// coefficients.
Fit fit_transform(FitKind kind, int degree, const PatchColours& samples, const ChartReference& reference);

/// Auto: leave-one-out over all kinds and degrees; one with an objection is chosen only when all have one.
/// Otherwise the kind asked for, with its leave-one-out error.
FitChoice choose_fit(FitKind kind, int degree, const PatchColours& samples, const ChartReference& reference);

}  // namespace aluminate::calibration
