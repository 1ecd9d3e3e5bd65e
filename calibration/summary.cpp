// What a person is told about a calibration.
#include <algorithm>
#include <cmath>

#include "calibration/calibrate.hpp"
#include "platform/host/error.hpp"
#include "platform/host/text_table.hpp"

namespace aluminate::calibration {

std::vector<std::string> warnings_of(const Calibration& calibration) {
  std::vector<std::string> warnings;
  const Fit& fit = calibration.fit.fit;
  const ChartReference& reference = chart_reference(calibration.options.edition);
  const auto unused = std::count_if(calibration.patches.begin(), calibration.patches.end(),
                                    [](const PatchSample& sample) { return !sample.usable(); });
  if (unused > 0)
    warnings.push_back(fmt::format("{} of 24 patches are not used (clipped or uneven)", unused));
  for (const auto& [patch, name] : {std::pair{kWhitePatch, "white"}, {kBlackPatch, "black"}}) {
    const double found = rgb_to_xyz(fit.corrected[patch])[1],
                 expected = rgb_to_xyz(reference.rgb_lin[patch])[1];
    if (std::fabs(found - expected) <= (patch == kWhitePatch ? kWhiteTolerance : kBlackTolerance)) continue;
    const bool clipped = calibration.patches[patch].is_clipped();
    warnings.push_back(
        fmt::format("the {} patch has luminance {:.3f}, expected {:.3f}{}", name, found, expected,
                    clipped ? ": it is clipped in the photograph, and what is near it is extrapolated" : ""));
  }
  if (const double lift = rgb_to_xyz(correct(fit.transform, {0, 0, 0}))[1]; lift > kMostOfNoLight)
    warnings.push_back(
        fmt::format("no light becomes an albedo of {:.3f}: the photograph's blacks are crushed, and dark "
                    "materials are lost",
                    lift));
  const double pixels = static_cast<double>(std::max<std::int64_t>(calibration.counts.pixels, 1));
  const double negative = static_cast<double>(calibration.counts.negative) / pixels;
  if (negative > kManyNegative)
    warnings.push_back(
        fmt::format("{:.0f} % of the pixels have a channel below 0, which became 0: they are darker or more "
                    "saturated than the chart's patches, or lit differently",
                    100.0 * negative));
  for (const Candidate& candidate : calibration.fit.candidates)
    if (candidate.name == transform_name(fit.transform) && !candidate.objection.empty())
      warnings.push_back(fmt::format("{} {}", candidate.name, candidate.objection));
  return warnings;
}

std::string verdict_line(const Calibration& calibration) {
  const Fit& fit = calibration.fit.fit;
  return fmt::format("{}: dE2000 mean {:.2f} -> {:.2f}, max {:.2f}, held out {:.2f}",
                     transform_name(fit.transform), fit.before.mean_de2000, fit.after.mean_de2000,
                     fit.after.max_de2000, fit.held_out_de2000);
}

std::string summary_text(const Calibration& calibration) {
  const Fit& fit = calibration.fit.fit;
  const ChartReference& reference = chart_reference(calibration.options.edition);
  host::TextTable table({{"#", host::Align::Right},
                         {"patch"},
                         {"dE2000 before", host::Align::Right},
                         {"after", host::Align::Right},
                         {"luminance", host::Align::Right},
                         {"note"}});
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    const PatchSample& sample = calibration.patches[i];
    std::string note;
    const auto add = [&](const std::string& text) { note += (note.empty() ? "" : ", ") + text; };
    if (sample.is_clipped())
      add(fmt::format("clipped ({:.0f} %), not used",
                      100.0 * std::max(sample.clipped_high, sample.clipped_low)));
    if (sample.is_uneven())
      add(fmt::format("uneven ({:.0f} %){}", 100.0 * sample.unevenness,
                      sample.unevenness > kUnevenRefused ? ", not used" : ""));
    if (outside_gamut(reference.rgb_lin[i])) add("reference outside of sRGB");
    table.add_row({fmt::format("{}", i + 1), std::string(patch_names()[i]),
                   fmt::format("{:.2f}", fit.before.de2000[i]), fmt::format("{:.2f}", fit.after.de2000[i]),
                   fmt::format("{:.3f}", rgb_to_xyz(fit.corrected[i])[1]), note});
  }
  std::string text = fmt::format(
      "{}: {} x {}, {}; chart {} (agreement {:.2f})\n", calibration.photo, calibration.width,
      calibration.height, calibration.photo_kind,
      calibration.chart.finder == "corners" ? "at the given corners" : "found by " + calibration.chart.finder,
      calibration.chart.agreement);
  text += table.text();
  if (calibration.fit.candidates.size() > 1) {
    text += "fits, by dE2000 of patches they were not fitted to:";
    for (const Candidate& candidate : calibration.fit.candidates)
      text += fmt::format(" {} {}{}{}", candidate.name,
                          candidate.held_out_de2000 ? fmt::format("{:.2f}", *candidate.held_out_de2000) : "-",
                          candidate.objection.empty() ? "" : " (" + candidate.objection + ")",
                          &candidate == &calibration.fit.candidates.back() ? "\n" : ";");
  }
  if (!fit.stage_rms.empty())
    text += fmt::format("xyY rms: photo {:.5f}, affine {:.5f}, polynomial {:.5f}, affine {:.5f}\n",
                        fit.stage_rms[0], fit.stage_rms[1], fit.stage_rms[2], fit.stage_rms[3]);
  text += fmt::format("{}; dE76 mean {:.2f} -> {:.2f}\n", verdict_line(calibration), fit.before.mean_de76,
                      fit.after.mean_de76);
  const CorrectionCounts& counts = calibration.counts;
  const double percent = 100.0 / static_cast<double>(std::max<std::int64_t>(counts.pixels, 1));
  const auto share = [&](std::int64_t count) { return percent * static_cast<double>(count); };
  text += fmt::format(
      "albedo: white {:.3f}, black {:.3f}; pixels darker than {:g}: {:.2f} %, brighter than {:g}: {:.2f} %, "
      "clipped at 0: {:.2f} %, above 1: {:.2f} %, at a limit of the photo: {:.2f} %\n",
      rgb_to_xyz(fit.corrected[kWhitePatch])[1], rgb_to_xyz(fit.corrected[kBlackPatch])[1], kDarkestAlbedo,
      share(counts.too_dark), kBrightestAlbedo, share(counts.too_bright), share(counts.negative),
      share(counts.above_one), share(counts.clipped_input));
  return text;
}

}  // namespace aluminate::calibration
