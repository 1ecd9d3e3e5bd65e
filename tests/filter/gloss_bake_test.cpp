// Baked gloss: identities of the bake, and whether the filtered lobe looks like the surface from afar.
#include "shading/filter/gloss_bake.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "shading/brdf/blinn_phong.hpp"
#include "tests/filter/bumpy_map.hpp"

namespace aluminate::filter {
namespace {

TEST(GlossBake, FlatMapKeepsTheArtistsGlossInEveryMip) {
  const auto pixels = bumpy_map(16, 0.0, 153);
  for (const BakedLevel& level : bake_gloss({pixels, 16, 16}))
    for (const double gloss : level.filtered_gloss.texels) {
      // One stored normal everywhere; the mean of equal unit vectors is short by roundings only, 2^-52 in
      // length, which at m = 8192^0.6 = 223 moves gloss by 223 * 2e-16 / (13 ln 2).
      EXPECT_NEAR(gloss, 0.6, 1e-13);
    }
}

TEST(GlossBake, FilteringNeverRaisesGlossAndRoughensTowardsTheTop) {
  const auto pixels = bumpy_map(64, 1.0, 200);
  const auto levels = bake_gloss({pixels, 64, 64});
  double previous = 1.0;
  for (const BakedLevel& level : levels) {
    double mean_length = 0.0;
    for (std::size_t i = 0; i < level.gloss.texels.size(); ++i) {
      EXPECT_LE(level.filtered_gloss.texels[i], level.gloss.texels[i]);
      mean_length += level.length.texels[i] / static_cast<double>(level.gloss.texels.size());
    }
    EXPECT_LE(mean_length, previous + 1e-15);
    previous = mean_length;
  }
  EXPECT_LT(summarize(levels).back().mean_filtered_gloss,
            0.5 * summarize(levels).front().mean_filtered_gloss);
}

TEST(GlossBake, FactorAtAFixedPowerConvertsToTheBakeAtTheMaterialsPower) {
  const auto pixels = bumpy_map(32, 1.0, 220);
  const double m = brdf::power_from_gloss(220 / 255.0);
  for (const BakedLevel& level : bake_gloss({pixels, 32, 32})) {
    const ScalarLevel fixed = bake_factor(level), direct = bake_factor(level, m);
    for (std::size_t i = 0; i < fixed.texels.size(); ++i) {
      const double converted = brdf::convert_toksvig_factor(fixed.texels[i], brdf::kFixedPower, m);
      EXPECT_NEAR(converted, direct.texels[i], 1e-12);
      const double gloss = converted * m > 1.0 ? brdf::gloss_from_power(converted * m) : 0.0;
      EXPECT_NEAR(gloss, level.filtered_gloss.texels[i], 1e-12);
    }
  }
}

TEST(GlossBake, FootprintFiltersLevelZeroToo) {
  const auto pixels = bumpy_map(32, 2.0, 220);
  const auto point = bake_gloss({pixels, 32, 32}),
             wide = bake_gloss({pixels, 32, 32}, {.footprint_sigma = 0.5});
  // A unit vector is short by roundings only, 2^-52, which m = 2400 multiplies.
  EXPECT_NEAR(summarize(point)[0].mean_filtered_gloss, summarize(point)[0].mean_gloss, 1e-12);
  EXPECT_LT(summarize(wide)[0].mean_filtered_gloss, summarize(wide)[0].mean_gloss - 0.1);
}

TEST(GlossBake, MaterialFactorIsTheNamedMeanOverTheLevel) {
  const auto pixels = bumpy_map(32, 1.0, 180);
  const auto levels = bake_gloss({pixels, 32, 32});
  const auto rows = summarize(levels);
  const double m = brdf::power_from_gloss(180 / 255.0);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    double sum = 0.0;
    for (const double length : levels[i].length.texels) sum += brdf::toksvig_factor(length, m);
    EXPECT_NEAR(rows[i].material_factor[0], sum / static_cast<double>(levels[i].length.texels.size()), 1e-12);
    // The mean inequalities, arithmetic >= geometric >= harmonic, up to roundings over 1024 texels.
    EXPECT_GE(rows[i].material_factor[0], rows[i].material_factor[1] - 1e-13);
    EXPECT_GE(rows[i].material_factor[1], rows[i].material_factor[3] - 1e-13);
  }
}

// What the eye sees from afar: the mean of the lobes of all texels, against one lobe on the mean normal.
TEST(GlossBake, FilteredLobeMatchesTheDistantSurfaceWhereTheUnfilteredDoesNot) {
  const auto pixels = bumpy_map(64, 0.25, 180);
  const auto levels = bake_gloss({pixels, 64, 64});
  const double m = brdf::power_from_gloss(180 / 255.0);
  const BakedLevel& top = levels.back();
  const glm::dvec3 mean_normal = glm::normalize(top.normal.texels[0]);
  const double filtered = brdf::power_from_gloss(top.filtered_gloss.texels[0]);
  double filtered_error = 0.0, plain_error = 0.0, energy = 0.0;
  for (double tilt = -0.6; tilt <= 0.6; tilt += 0.02)
    for (const bool along_x : {true, false}) {
      const glm::dvec3 h = along_x ? glm::dvec3(std::sin(tilt), 0, std::cos(tilt))
                                   : glm::dvec3(0, std::sin(tilt), std::cos(tilt));
      double truth = 0.0;
      for (const glm::dvec3& n : levels[0].normal.texels)
        truth += brdf::norm_m_plus_2(m) * brdf::blinn_phong_lobe(m, glm::dot(n, h));
      truth /= static_cast<double>(levels[0].normal.texels.size());
      const double cosine = glm::dot(mean_normal, h);
      filtered_error +=
          std::fabs(brdf::norm_m_plus_2(filtered) * brdf::blinn_phong_lobe(filtered, cosine) - truth);
      plain_error += std::fabs(brdf::norm_m_plus_2(m) * brdf::blinn_phong_lobe(m, cosine) - truth);
      energy += truth;
    }
  // The map is a flat quarter plus bumps: two lobes, which one lobe can only approximate. Filtering must
  // still remove most of the error that leaving the power alone makes.
  EXPECT_LT(filtered_error, 0.5 * plain_error) << filtered_error / energy << ' ' << plain_error / energy;
}

}  // namespace
}  // namespace aluminate::filter
