// Fits against independent QR solutions, exact recovery, refusals, and the choice by held-out patches.
#include "calibration/fit.hpp"
#include "calibration/power.hpp"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <cmath>
#include <limits>

#include "calibration/linear_solve.hpp"
#include "platform/host/error.hpp"
#include "tests/calibration/photo_model.hpp"

namespace aluminate::calibration {
namespace {

const ChartReference& reference() { return chart_reference(ChartEdition::After2014); }

std::array<Colour, kPatchCount> target_xyy() {
  std::array<Colour, kPatchCount> target{};
  for (std::size_t i = 0; i < kPatchCount; ++i) target[i] = xyz_to_xyy(rgb_to_xyz(reference().rgb_lin[i]));
  return target;
}

// A photograph whose xyY is an affine image of the chart's.
PatchColours affine_in_xyy() {
  const Affine distortion{{{{0.9, 0.05, 0.01, 0.02}, {-0.03, 0.95, 0.02, 0.015}, {0.1, -0.05, 0.8, 0.03}}}};
  PatchColours samples;
  samples.usable.fill(true);
  for (std::size_t i = 0; i < kPatchCount; ++i)
    samples.rgb_lin[i] = xyz_to_rgb(xyy_to_xyz(evaluate(distortion, target_xyy()[i])));
  return samples;
}

TEST(Fit, PureAffineDistortionIsRecovered) {
  const PatchColours samples = affine_in_xyy();
  const Fit fit = fit_transform(FitKind::AffinePolyAffine, 3, samples, reference());
  EXPECT_LE(fit.stage_rms.back(), 1e-12);
  for (std::size_t i = 0; i < kPatchCount; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(fit.corrected[i][c], reference().rgb_lin[i][c], 1e-11) << i;
}

TEST(Fit, PureAffineDistortionOfLinearRgbIsRecovered) {
  test::Camera camera;
  camera.balance = {0.9, 0.8, 0.6};
  camera.cross_talk = {{{0.8, 0.15, 0.05}, {0.1, 0.8, 0.1}, {0.05, 0.15, 0.8}}};
  PatchColours samples;
  samples.usable.fill(true);
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    samples.rgb_lin[i] = multiply(camera.cross_talk, reference().rgb_lin[i]);
    for (std::size_t c = 0; c < 3; ++c)
      samples.rgb_lin[i][c] = samples.rgb_lin[i][c] * camera.balance[c] + 0.01;
  }
  const Fit fit = fit_transform(FitKind::Linear, 1, samples, reference());
  for (std::size_t i = 0; i < kPatchCount; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(fit.corrected[i][c], reference().rgb_lin[i][c], 1e-12) << i;
  EXPECT_NEAR(fit.after.max_de2000, 0.0, 1e-9);
}

TEST(Fit, ResidualNeverRisesFromStageToStage) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 40; ++trial) {
    PatchColours samples = test::photographed_patches(test::realistic_camera(), reference());
    const double spread = trial * 0.005;
    for (Colour& colour : samples.rgb_lin)
      for (double& value : colour)
        value = std::max(0.0, value + spread * (static_cast<double>(random()) / 4294967296.0 - 0.5));
    for (int degree = 1; degree <= kMaxDegree; ++degree) {
      const Fit fit = fit_transform(FitKind::AffinePolyAffine, degree, samples, reference());
      ASSERT_EQ(fit.stage_rms.size(), 4u);
      for (std::size_t i = 1; i < 4; ++i)
        EXPECT_LE(fit.stage_rms[i], fit.stage_rms[i - 1]) << trial << ' ' << degree;
    }
  }
}

Eigen::MatrixXd eigen_of(const std::array<Colour, kPatchCount>& colours) {
  Eigen::MatrixXd m(kPatchCount, 3);
  for (std::size_t i = 0; i < kPatchCount; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      m(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) = colours[i][c];
  return m;
}

// The same three stages by Householder QR of the unscaled Vandermonde matrices.
struct QrChain {
  Eigen::MatrixXd first, last;
  std::array<Eigen::VectorXd, 3> polynomials;
};
QrChain qr_chain(int degree, const PatchColours& samples) {
  const Eigen::MatrixXd target = eigen_of(target_xyy());
  std::array<Colour, kPatchCount> stage{};
  for (std::size_t i = 0; i < kPatchCount; ++i) stage[i] = rgb_to_stage_xyy(samples.rgb_lin[i]);
  Eigen::MatrixXd values = eigen_of(stage);
  const auto with_one = [](const Eigen::MatrixXd& v) {
    Eigen::MatrixXd m(v.rows(), 4);
    m << v, Eigen::VectorXd::Ones(v.rows());
    return m;
  };
  const auto clamp = [](Eigen::MatrixXd& v) {
    v.col(1) = v.col(1).cwiseMax(kMinChromaY);
    v.col(2) = v.col(2).cwiseMax(0.0);
  };
  QrChain chain;
  chain.first = with_one(values).colPivHouseholderQr().solve(target);
  values = (with_one(values) * chain.first).eval();
  clamp(values);
  for (int c = 0; c < 3; ++c) {
    Eigen::MatrixXd powers(values.rows(), degree + 1);
    for (int j = 0; j <= degree; ++j) powers.col(j) = values.col(c).array().pow(j);
    chain.polynomials[static_cast<std::size_t>(c)] = powers.colPivHouseholderQr().solve(target.col(c));
    values.col(c) = (powers * chain.polynomials[static_cast<std::size_t>(c)]).eval();
  }
  clamp(values);
  chain.last = with_one(values).colPivHouseholderQr().solve(target);
  return chain;
}

TEST(Fit, CoefficientsMatchAnIndependentQrSolution) {
  const PatchColours samples = test::photographed_patches(test::realistic_camera(), reference());
  for (int degree = 1; degree <= kMaxDegree; ++degree) {
    const Fit fit = fit_transform(FitKind::AffinePolyAffine, degree, samples, reference());
    const auto& chain = std::get<AffinePolyAffine>(fit.transform);
    const QrChain qr = qr_chain(degree, samples);
    // Degree 5 in plain powers has a condition number near 1e6, which QR itself feels.
    const double tolerance = degree <= 3 ? 1e-9 : 1e-6;
    for (int c = 0; c < 3; ++c) {
      const std::size_t channel = static_cast<std::size_t>(c);
      const double scale = qr.polynomials[channel].cwiseAbs().maxCoeff();
      for (int j = 0; j <= degree; ++j)
        EXPECT_NEAR(chain.polynomials[channel].a[static_cast<std::size_t>(j)], qr.polynomials[channel](j),
                    tolerance * scale)
            << degree << ' ' << c;
      for (int j = 0; j < 4; ++j) {
        EXPECT_NEAR(chain.first.m[channel][static_cast<std::size_t>(j)], qr.first(j, c), 1e-9) << degree;
        EXPECT_NEAR(chain.last.m[channel][static_cast<std::size_t>(j)], qr.last(j, c), tolerance) << degree;
      }
    }
  }
}

TEST(GaussJordan, IsAsGoodAsQrWithinTenTimes) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + trial % 6;
    Table rows(24, static_cast<std::size_t>(n)), target(24, 1);
    Eigen::MatrixXd a(24, n);
    Eigen::VectorXd truth(n);
    for (int j = 0; j < n; ++j) truth(j) = static_cast<double>(random()) / 4294967296.0 - 0.5;
    for (int r = 0; r < 24; ++r)
      for (int j = 0; j < n; ++j) {
        a(r, j) = static_cast<double>(random()) / 4294967296.0;
        rows.at(static_cast<std::size_t>(r), static_cast<std::size_t>(j)) = a(r, j);
      }
    const Eigen::VectorXd b = a * truth;
    for (int r = 0; r < 24; ++r) target.at(static_cast<std::size_t>(r), 0) = b(r);
    const Table ours = least_squares(rows, target, {}, "test");
    const Eigen::VectorXd qr = a.colPivHouseholderQr().solve(b);
    double our_error = 0.0;
    for (int j = 0; j < n; ++j)
      our_error = std::max(our_error, std::fabs(ours.at(static_cast<std::size_t>(j), 0) - truth(j)));
    // 1e-15: one rounding of a coefficient, when QR happens to hit the truth.
    EXPECT_LE(our_error, 10.0 * (qr - truth).cwiseAbs().maxCoeff() + 1e-15) << trial;
  }
}

TEST(GaussJordan, NeedsItsPivots) {
  Table a(2, 2), b(2, 1);
  a.values = {0.0, 1.0, 1.0, 0.0};
  b.values = {3.0, 5.0};
  ASSERT_TRUE(gauss_jordan(a, b, 1e-13));
  EXPECT_EQ(b.values, (std::vector<double>{5.0, 3.0}));
}

PatchColours patches_of(const std::vector<Colour>& colours) {
  PatchColours samples;
  samples.usable.fill(true);
  for (std::size_t i = 0; i < kPatchCount; ++i) samples.rgb_lin[i] = colours[i % colours.size()];
  return samples;
}

TEST(Fit, SingularSystemsAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  PatchColours all_clipped = test::photographed_patches(test::realistic_camera(), reference());
  all_clipped.usable.fill(false);
  PatchColours one_nan = test::photographed_patches(test::realistic_camera(), reference());
  one_nan.rgb_lin[5][1] = nan;
  PatchColours one_infinite = one_nan;
  one_infinite.rgb_lin[5][1] = std::numeric_limits<double>::infinity();
  const std::vector<std::pair<const char*, PatchColours>> cases{
      {"one colour", patches_of({{0.3, 0.4, 0.5}})},
      {"black", patches_of({{0, 0, 0}})},
      {"two colours", patches_of({{0.3, 0.4, 0.5}, {0.7, 0.2, 0.1}})},
      {"three colours", patches_of({{0.3, 0.4, 0.5}, {0.7, 0.2, 0.1}, {0.1, 0.2, 0.6}})},
      {"NaN", one_nan},
      {"infinity", one_infinite},
      {"all clipped", all_clipped}};
  for (const auto& [name, samples] : cases) {
    for (const FitKind kind : {FitKind::Auto, FitKind::AffinePolyAffine, FitKind::Linear, FitKind::RootPoly,
                               FitKind::ToneLinear}) {
      // Three colours do determine a matrix without offset, so a root polynomial of degree 1 is right to
      // accept them.
      EXPECT_THROW(choose_fit(kind, kind == FitKind::RootPoly ? 2 : 3, samples, reference()), UserError)
          << name << ' ' << static_cast<int>(kind);
    }
  }
}

TEST(Fit, AnUnusablePatchMayHoldAnything) {
  PatchColours samples = test::photographed_patches(test::realistic_camera(), reference());
  samples.usable[18] = false;
  const Fit clean = fit_transform(FitKind::Linear, 1, samples, reference());
  samples.rgb_lin[18] = {1e9, 0.0, -5.0};
  const Fit wild = fit_transform(FitKind::Linear, 1, samples, reference());
  EXPECT_EQ(std::get<LinearFit>(clean.transform).matrix, std::get<LinearFit>(wild.transform).matrix);
}

TEST(Fit, AutoMeetsTheBarOnTheRealisticPhotograph) {
  for (const ChartEdition edition : {ChartEdition::Before2014, ChartEdition::After2014}) {
    const ChartReference& chart = chart_reference(edition);
    const PatchColours samples = test::photographed_patches(test::realistic_camera(), chart);
    const FitChoice choice = choose_fit(FitKind::Auto, 3, samples, chart);
    EXPECT_LE(choice.fit.after.mean_de76, 2.5);
    EXPECT_GT(choice.fit.before.mean_de76, 10.0) << "the photograph must need correcting";
    for (const Candidate& candidate : choice.candidates) {
      EXPECT_LE(choice.fit.held_out_de2000, candidate.held_out_de2000.value_or(INFINITY)) << candidate.name;
    }
    EXPECT_EQ(choice.candidates.size(), 9u);
  }
}

TEST(Fit, ToneLinearUndoesAPowerCurveBehindCrossTalk) {
  test::Camera camera = test::realistic_camera();
  camera.code_max = 0;
  const Fit fit =
      fit_transform(FitKind::ToneLinear, 1, test::photographed_patches(camera, reference()), reference());
  const auto& tone = std::get<ToneLinear>(fit.transform);
  EXPECT_NEAR(tone.exponent, 1.1, 1e-6);  // the search ends within 1e-7 of the logarithm
  EXPECT_LT(fit.after.max_de2000, 1e-3);
}

TEST(Fit, PowersOfManyNumbersAreThoseOfOne) {
  std::mt19937_64 random(17);
  const auto uniform = [&](double low, double high) { return low + (high - low) * 0x1p-64 * static_cast<double>(random()); };
  double worst = 0.0;
  for (int trial = 0; trial < 400; ++trial) {
    const double exponent = uniform(-3.0, 3.0);
    std::vector<double> x(static_cast<std::size_t>(1 + trial % 37));
    for (double& value : x) value = std::exp2(uniform(-30.0, 30.0)) * (random() % 2 == 0 ? 1.0 : -1.0);
    std::vector<double> powers = x;
    raise_to(exponent, powers.data(), powers.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double expected = std::copysign(std::pow(std::fabs(x[i]), exponent), x[i]);
      worst = std::max(worst, std::fabs(powers[i] / expected - 1.0));
    }
  }
  EXPECT_LT(worst, 1e-13);
  double edges[] = {0.0, -0.0, 1.0, -1.0, 0.5, 4.0};
  raise_to(0.5, edges, std::size(edges));
  const double expected[] = {0.0, -0.0, 1.0, -1.0, std::sqrt(0.5), 2.0};
  for (std::size_t i = 0; i < std::size(edges); ++i) EXPECT_NEAR(edges[i], expected[i], 2e-16);
  EXPECT_TRUE(std::signbit(edges[1]));
}

TEST(Fit, TransformsThatMakeMoreLightDarkerAreObjectedTo) {
  const PatchColours samples = test::photographed_patches(test::realistic_camera(), reference());
  EXPECT_EQ(objection_to(LinearFit{}, samples), "");
  AffinePolyAffine chain;
  for (Polynomial& p : chain.polynomials) p.high = 10.0;
  EXPECT_EQ(objection_to(chain, samples), "");
  chain.polynomials[2].a = {0.0, 1.0, -1.2, 0.0, 0.0, 0.0};  // falls beyond Y = 0.42
  EXPECT_EQ(objection_to(chain, samples), "makes more light darker");
}

TEST(Fit, AutoChoosesNoTransformItObjectsToWhileThereIsAnother) {
  // Wrong tone curves: high degrees follow them and turn over near black.
  std::mt19937 random(3);
  int objected = 0;
  for (int trial = 0; trial < 30; ++trial) {
    PatchColours samples = test::photographed_patches(test::realistic_camera(), reference());
    for (Colour& colour : samples.rgb_lin)
      for (double& value : colour)
        value =
            std::pow(value, 0.4 + 0.03 * trial) * (1.0 + 0.02 * static_cast<double>(random() % 100) / 100.0);
    const FitChoice choice = choose_fit(FitKind::Auto, 3, samples, reference());
    double best = 1e9;
    for (const Candidate& candidate : choice.candidates) {
      objected += candidate.objection.empty() ? 0 : 1;
      if (candidate.objection.empty() && candidate.held_out_de2000)
        best = std::min(best, *candidate.held_out_de2000);
    }
    EXPECT_EQ(choice.fit.held_out_de2000, best);
    EXPECT_EQ(objection_to(choice.fit.transform, samples), "");
  }
  EXPECT_GT(objected, 0);
}

TEST(Fit, RootPolynomialFollowsExposure) {
  const PatchColours samples = test::photographed_patches(test::realistic_camera(), reference());
  for (int degree = 1; degree <= 3; ++degree) {
    const Fit fit = fit_transform(FitKind::RootPoly, degree, samples, reference());
    const Colour one = correct(fit.transform, samples.rgb_lin[3]);
    Colour brighter = samples.rgb_lin[3];
    for (double& value : brighter) value *= 3.0;
    const Colour three = correct(fit.transform, brighter);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(three[c], 3.0 * one[c], 1e-13);
  }
}

TEST(Transform, RootTermsEqualTheirDefinition) {
  const Colour c{0.37, 0.0021, 0.91};
  const std::vector<double> t = root_terms(3, c);
  ASSERT_EQ(t.size(), 13u);
  const auto near = [&](std::size_t i, double product) { EXPECT_NEAR(t[i], std::cbrt(product), 1e-14) << i; };
  EXPECT_NEAR(t[3], std::sqrt(c[0] * c[1]), 1e-15);
  near(6, c[0] * c[1] * c[1]);
  near(7, c[1] * c[2] * c[2]);
  near(8, c[0] * c[2] * c[2]);
  near(9, c[1] * c[0] * c[0]);
  near(10, c[2] * c[1] * c[1]);
  near(11, c[2] * c[0] * c[0]);
  near(12, c[0] * c[1] * c[2]);
  EXPECT_EQ(root_terms(3, {0, 0, 0}), std::vector<double>(13, 0.0));
  for (double x = 1e-12; x < 1e6; x *= 1.37)
    EXPECT_NEAR(root_terms(3, {x, x, x})[12] / x, 1.0, 4e-16 * 8) << x;  // three roots multiplied
}

TEST(Transform, PolynomialContinuesAlongItsTangent) {
  Polynomial p;
  p.a = {0.1, 0.5, 2.0, -1.0, 0.0, 0.0};
  p.low = 0.2;
  p.high = 0.8;
  const auto plain = [&](double x) { return 0.1 + x * (0.5 + x * (2.0 - x)); };
  EXPECT_DOUBLE_EQ(evaluate(p, 0.5), plain(0.5));
  EXPECT_DOUBLE_EQ(evaluate(p, 0.2), plain(0.2));
  const double slope = 0.5 + 4.0 * 0.8 - 3.0 * 0.8 * 0.8;
  EXPECT_NEAR(evaluate(p, 1.3), plain(0.8) + 0.5 * slope, 1e-14);
}

TEST(Transform, ColumnsGiveWhatSingleColoursGive) {
  const PatchColours samples = test::photographed_patches(test::realistic_camera(), reference());
  for (const auto& [kind, degree] : {std::pair{FitKind::Linear, 1},
                                     {FitKind::ToneLinear, 1},
                                     {FitKind::RootPoly, 3},
                                     {FitKind::AffinePolyAffine, 5}}) {
    const Fit fit = fit_transform(kind, degree, samples, reference());
    std::array<double, kPatchCount> r{}, g{}, b{};
    for (std::size_t i = 0; i < kPatchCount; ++i)
      r[i] = samples.rgb_lin[i][0], g[i] = samples.rgb_lin[i][1], b[i] = samples.rgb_lin[i][2];
    correct(fit.transform, r.data(), g.data(), b.data(), kPatchCount);
    for (std::size_t i = 0; i < kPatchCount; ++i)
      EXPECT_EQ((Colour{r[i], g[i], b[i]}), fit.corrected[i]) << transform_name(fit.transform);
  }
}

TEST(Fit, DegreesOutsideOfTheirRangeAreRefused) {
  const PatchColours samples = test::photographed_patches(test::realistic_camera(), reference());
  for (const int degree : {-1, 0, 6, 100})
    EXPECT_THROW(fit_transform(FitKind::AffinePolyAffine, degree, samples, reference()), UserError);
  EXPECT_THROW(fit_transform(FitKind::RootPoly, 4, samples, reference()), UserError);
  EXPECT_THROW(parse_fit_kind("lineer"), UserError);
}

}  // namespace
}  // namespace aluminate::calibration
