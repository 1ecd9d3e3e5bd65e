// Colour conversions and the chart's reference data against published figures.
#include "calibration/colour_space.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/chart.hpp"

namespace aluminate::calibration {
namespace {

TEST(ColourSpace, SrgbTransferIsItsOwnInverseOnEveryCode) {
  for (int code = -65535; code <= 65535; ++code) {
    const double encoded = code / 65535.0;
    ASSERT_NEAR(linear_to_srgb(srgb_to_linear(encoded)), encoded, 1e-7)
        << code;  // the standard's two pieces miss each other by 3e-8
  }
}

TEST(ColourSpace, WhiteOfTheMatrixIsD65) {
  const Colour xyy = xyz_to_xyy(rgb_to_xyz({1, 1, 1}));
  EXPECT_NEAR(xyy[0], 0.3127, 1e-15);
  EXPECT_NEAR(xyy[1], 0.3290, 1e-15);
  EXPECT_NEAR(xyy[2], 1.0, 1e-15);
  EXPECT_NEAR(srgb_to_xyz_matrix()[1][1], 0.7152, 5e-5);  // the standard prints four digits
}

TEST(ColourSpace, BradfordMapsWhiteToWhiteAndMatchesThePublishedMatrix) {
  const Matrix3 m = bradford(kWhiteD50Xy, kWhiteD65Xy);
  const Colour white = multiply(m, white_xyz(kWhiteD50Xy));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(white[i], white_xyz(kWhiteD65Xy)[i], 1e-14);
  // Lindbloom's D50 -> D65; his whites have four digits of XYZ, so the fourth digit may differ.
  EXPECT_NEAR(m[0][0], 0.9555766, 5e-4);
  EXPECT_NEAR(m[2][2], 1.3299098, 2e-3);
}

TEST(ColourSpace, BlackHasTheChromaticityOfTheWhitePoint) {
  const Colour xyy = xyz_to_xyy({0, 0, 0});
  EXPECT_EQ(xyy, (Colour{0.3127, 0.3290, 0.0}));
  EXPECT_EQ(xyy_to_xyz({0.3, 0.0, 0.5}), (Colour{0, 0, 0}));
}

struct DeltaCase {
  Colour a, b;
  double expected;
};

// Pairs from the supplementary data of the CIEDE2000 implementation notes; printed with four decimals. They
// visit the hue wrap, neutrals and the rotation term.
TEST(ColourSpace, Ciede2000MatchesThePublishedPairs) {
  const DeltaCase cases[] = {{{50, 2.6772, -79.7751}, {50, 0, -82.7485}, 2.0425},
                             {{50, 3.1571, -77.2803}, {50, 0, -82.7485}, 2.8615},
                             {{50, 2.8361, -74.0200}, {50, 0, -82.7485}, 3.4412},
                             {{50, -1.3802, -84.2814}, {50, 0, -82.7485}, 1.0000},
                             {{50, 0, 0}, {50, -1, 2}, 2.3669},
                             {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0009}, 7.1792},
                             {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0011}, 7.2195},
                             {{50, -0.0010, 2.4900}, {50, 0.0009, -2.4900}, 4.8045},
                             {{50, 2.5, 0}, {50, 0, -2.5}, 4.3065},
                             {{50, 2.5, 0}, {73, 25, -18}, 27.1492},
                             {{50, 2.5, 0}, {61, -5, 29}, 22.8977},
                             {{50, 2.5, 0}, {56, -27, -3}, 31.9030},
                             {{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
                             {{22.7233, 20.0904, -46.6940}, {23.0331, 14.9730, -42.5619}, 2.0373},
                             {{90.8027, -2.0831, 1.4410}, {91.1528, -1.6435, 0.0447}, 1.4441},
                             {{2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}, 0.9082}};
  for (const DeltaCase& c : cases) {
    EXPECT_NEAR(delta_e_2000(c.a, c.b), c.expected, 5e-5) << c.a[1] << ' ' << c.b[1];
    EXPECT_NEAR(delta_e_2000(c.b, c.a), c.expected, 5e-5) << "swapped";
  }
}

int srgb8(double linear) {
  return static_cast<int>(std::lround(255.0 * std::clamp(linear_to_srgb(linear), 0.0, 1.0)));
}

TEST(Chart, SrgbCodesAreThePublishedOnes) {
  const ChartReference& before = chart_reference(ChartEdition::Before2014);
  const ChartReference& after = chart_reference(ChartEdition::After2014);
  const auto codes = [](const Colour& c) {
    return std::array<int, 3>{srgb8(c[0]), srgb8(c[1]), srgb8(c[2])};
  };
  EXPECT_EQ(codes(before.rgb_lin[0]), (std::array<int, 3>{115, 81, 67}));
  EXPECT_EQ(codes(before.rgb_lin[1]), (std::array<int, 3>{199, 147, 129}));
  EXPECT_EQ(codes(before.rgb_lin[kWhitePatch]), (std::array<int, 3>{245, 245, 243}));
  EXPECT_EQ(codes(before.rgb_lin[kBlackPatch]), (std::array<int, 3>{49, 49, 51}));
  EXPECT_EQ(codes(after.rgb_lin[0]), (std::array<int, 3>{116, 79, 65}));
}

TEST(Chart, EditionsDifferByWhatIsPublished) {
  const ChartReference& before = chart_reference(ChartEdition::Before2014);
  const ChartReference& after = chart_reference(ChartEdition::After2014);
  double sum = 0.0, largest = 0.0;
  std::size_t worst = 0;
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    const double e = delta_e_76(before.lab_d50[i], after.lab_d50[i]);
    sum += e;
    if (e > largest) worst = i, largest = e;
  }
  EXPECT_NEAR(sum / 24.0, 1.23, 0.005);  // both figures are published with two decimals
  EXPECT_NEAR(largest, 2.38, 0.005);
  EXPECT_EQ(patch_names()[worst], "red");
}

TEST(Chart, CyanAloneLiesOutsideOfSrgbAndIsNotClipped) {
  for (const ChartEdition edition : {ChartEdition::Before2014, ChartEdition::After2014}) {
    const ChartReference& reference = chart_reference(edition);
    EXPECT_EQ(reference.outside_gamut, 1) << edition_name(edition);
    EXPECT_LT(reference.rgb_lin[17][0], 0.0);
  }
}

TEST(Chart, LabOfTheReferenceSurvivesTheRoundTrip) {
  for (const Colour& lab : chart_reference(ChartEdition::After2014).lab_d50) {
    const Colour again = xyz_to_lab(lab_to_xyz(lab, kWhiteD50Xy), kWhiteD50Xy);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(again[i], lab[i], 1e-12);
  }
}

}  // namespace
}  // namespace aluminate::calibration
