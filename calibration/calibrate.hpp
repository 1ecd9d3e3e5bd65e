// The whole way from a photograph to an albedo: read, lens, polarisation, chart, fit, correct, write. One
// call a photograph. All outputs are written together at the end or not at all. Never prints; the summary is
// text for the caller.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/correct_image.hpp"
#include "calibration/find_chart.hpp"
#include "calibration/fit.hpp"
#include "calibration/lens.hpp"

namespace aluminate::calibration {

struct CalibrationOptions {
  std::optional<Corners> corners;  // empty: find the chart
  ChartFinder finder = ChartFinder::Auto;
  ChartEdition edition = ChartEdition::After2014;
  FitKind fit = FitKind::Auto;
  int degree = 3;
  Encoding input_encoding = Encoding::Srgb;  // of integer pictures
  std::string bayer;                         // pattern, when the picture is a mosaic
  std::string lens;                          // "", "auto", a lensfun name, or parse_lens text
  std::array<double, 3> vignette{};          // overrides the lens's
  std::array<double, 2> lateral{1, 1};       // red and blue radius; 1 1: the lens's
  double focal_px = 0.0;
  std::string parallel;  // photograph with the polariser parallel; PHOTO is then the crossed one
  double leakage = 0.0;
  OutputFormat format;
  int cube_size = 33;
};

/// Paths; empty: not written.
struct CalibrationOutputs {
  std::string image, json, cube, report, material, specular;
};

struct Calibration {
  std::string photo;
  std::string photo_kind;
  std::string photo_hash;  // XXH3-128 of the file
  int width = 0, height = 0;
  CalibrationOptions options;
  FoundChart chart;
  PatchSamples patches;
  FitChoice fit;
  CorrectionCounts counts;
  std::vector<std::string> warnings;
};

/// Throws UserError naming the photograph.
Calibration calibrate(const std::string& photo, const CalibrationOptions& options,
                      const CalibrationOutputs& outputs, const std::string& command);

/// What makes the result doubtful, one sentence each: patches that were not used, white or black far from
/// where they belong, many pixels outside of what the fit can say.
inline constexpr double kWhiteTolerance = 0.06, kBlackTolerance = 0.02;  // of luminance
inline constexpr double kMostOfNoLight = 0.02;  // luminance; coal, the darkest material, has it [Lagarde11]
inline constexpr double kManyNegative = 0.1;    // share of the pixels
std::vector<std::string> warnings_of(const Calibration& calibration);

/// What a person wants to know: per patch the CIEDE2000 before and after, the fits compared, warnings.
std::string summary_text(const Calibration& calibration);
/// One line.
std::string verdict_line(const Calibration& calibration);

/// One photograph of a batch.
struct BatchItem {
  std::string photo, output;
  std::optional<Calibration> done;  // empty: refused
  std::string reason;               // why
};

/// Every picture in a folder, by name; outputs go to output_folder under the photograph's name with `ending`.
/// A photograph that fails is listed with its reason and never stops the others. Shows progress.
std::vector<BatchItem> calibrate_folder(const std::string& folder, const std::string& output_folder,
                                        const std::string& ending, const CalibrationOptions& options,
                                        const std::string& command);
std::string batch_text(const std::vector<BatchItem>& items);

}  // namespace aluminate::calibration
