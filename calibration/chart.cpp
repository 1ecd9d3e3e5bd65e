#include "calibration/chart.hpp"

#include <string>
#include <vector>

#include "platform/host/error.hpp"
#include "platform/host/suggest.hpp"

namespace aluminate::calibration {
namespace {

constexpr std::array<Colour, kPatchCount> kXyyBefore2014{{
    {0.4316, 0.3777, 0.1008}, {0.4197, 0.3744, 0.3495}, {0.2760, 0.3016, 0.1836}, {0.3703, 0.4499, 0.1325},
    {0.2999, 0.2856, 0.2304}, {0.2848, 0.3911, 0.4178}, {0.5295, 0.4055, 0.3118}, {0.2305, 0.2106, 0.1126},
    {0.5012, 0.3273, 0.1938}, {0.3319, 0.2482, 0.0637}, {0.3984, 0.5008, 0.4446}, {0.4957, 0.4427, 0.4357},
    {0.2018, 0.1692, 0.0575}, {0.3253, 0.5032, 0.2318}, {0.5686, 0.3303, 0.1257}, {0.4697, 0.4734, 0.5981},
    {0.4159, 0.2688, 0.2009}, {0.2131, 0.3023, 0.1930}, {0.3469, 0.3608, 0.9131}, {0.3440, 0.3584, 0.5894},
    {0.3432, 0.3581, 0.3632}, {0.3446, 0.3579, 0.1915}, {0.3401, 0.3548, 0.0883}, {0.3406, 0.3537, 0.0311},
}};

constexpr std::array<Colour, kPatchCount> kLabAfter2014{{
    {37.54, 14.37, 14.92},  {64.66, 19.27, 17.50},   {49.32, -3.82, -22.54}, {43.46, -12.74, 22.72},
    {54.94, 9.61, -24.79},  {70.48, -32.26, -0.37},  {62.73, 35.83, 56.50},  {39.43, 10.75, -45.17},
    {50.57, 48.64, 16.67},  {30.10, 22.54, -20.87},  {71.77, -24.13, 58.19}, {71.51, 18.24, 67.37},
    {28.37, 15.42, -49.80}, {54.38, -39.72, 32.27},  {42.43, 51.05, 28.62},  {81.80, 2.67, 80.41},
    {50.63, 51.28, -14.12}, {49.57, -29.71, -28.32}, {95.19, -1.03, 2.93},   {81.29, -0.57, 0.44},
    {66.89, -0.75, -0.06},  {50.76, -0.13, 0.14},    {35.63, -0.46, -0.48},  {20.64, 0.07, -0.46},
}};

ChartReference make_reference(ChartEdition edition) {
  ChartReference reference{};
  reference.edition = edition;
  const Matrix3 to_d65 = bradford(kWhiteD50Xy, kWhiteD65Xy);
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    const Colour xyz = edition == ChartEdition::Before2014 ? xyy_to_xyz(kXyyBefore2014[i])
                                                           : lab_to_xyz(kLabAfter2014[i], kWhiteD50Xy);
    reference.lab_d50[i] = xyz_to_lab(xyz, kWhiteD50Xy);
    reference.rgb_lin[i] = xyz_to_rgb(multiply(to_d65, xyz));
    reference.lab_d65[i] = rgb_to_lab(reference.rgb_lin[i]);
    reference.outside_gamut += outside_gamut(reference.rgb_lin[i]) ? 1 : 0;
  }
  return reference;
}

}  // namespace

std::string_view edition_name(ChartEdition edition) {
  return edition == ChartEdition::Before2014 ? "before-2014" : "after-2014";
}

ChartEdition parse_edition(std::string_view name) {
  for (const ChartEdition edition : {ChartEdition::Before2014, ChartEdition::After2014})
    if (name == edition_name(edition)) return edition;
  const std::vector<std::string> known{"after-2014", "before-2014"};
  throw UserError(fmt::format("unknown chart edition '{}'", name), host::did_you_mean(name, known));
}

const std::array<std::string_view, kPatchCount>& patch_names() {
  static constexpr std::array<std::string_view, kPatchCount> kNames{
      "dark skin", "light skin",    "blue sky",     "foliage",   "blue flower",  "bluish green",
      "orange",    "purplish blue", "moderate red", "purple",    "yellow green", "orange yellow",
      "blue",      "green",         "red",          "yellow",    "magenta",      "cyan",
      "white",     "neutral 8",     "neutral 6.5",  "neutral 5", "neutral 3.5",  "black"};
  return kNames;
}

const ChartReference& chart_reference(ChartEdition edition) {
  static const ChartReference before = make_reference(ChartEdition::Before2014);
  static const ChartReference after = make_reference(ChartEdition::After2014);
  return edition == ChartEdition::Before2014 ? before : after;
}

}  // namespace aluminate::calibration
