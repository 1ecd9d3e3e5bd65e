#include "calibration/fit.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/linear_solve.hpp"
#include "calibration/power.hpp"
#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"
#include "platform/host/suggest.hpp"

namespace aluminate::calibration {
namespace {

using Colours = std::array<Colour, kPatchCount>;
using Weights = std::array<double, kPatchCount>;

Weights plain_weights(const PatchColours& samples) {
  Weights weights{};
  for (std::size_t i = 0; i < kPatchCount; ++i) weights[i] = samples.usable[i] ? 1.0 : 0.0;
  return weights;
}

// A linear-light error of a dark patch is seen more: L* has the slope Y^(-2/3), a squared error that slope
// squared. The offset keeps the black patch from deciding alone.
Weights lightness_weights(const PatchColours& samples, const ChartReference& reference) {
  Weights weights = plain_weights(samples);
  for (std::size_t i = 0; i < kPatchCount; ++i)
    weights[i] *= std::pow(rgb_to_xyz(reference.rgb_lin[i])[1] + 0.02, -4.0 / 3.0);
  return weights;
}

Table table_of(const Colours& colours) {
  Table table(kPatchCount, 3);
  for (std::size_t i = 0; i < kPatchCount; ++i)
    for (std::size_t c = 0; c < 3; ++c) table.at(i, c) = colours[i][c];
  return table;
}

Affine fit_affine(const Colours& from, const Colours& to, const Weights& weights, std::string_view what) {
  Table rows(kPatchCount, 4);
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    for (std::size_t c = 0; c < 3; ++c) rows.at(i, c) = from[i][c];
    rows.at(i, 3) = 1.0;
  }
  const Table solution = least_squares(rows, table_of(to), weights, what);
  Affine affine;
  for (std::size_t out = 0; out < 3; ++out)
    for (std::size_t in = 0; in < 4; ++in) affine.m[out][in] = solution.at(in, out);
  return affine;
}

// Solved in t = (x - centre)/half, which maps the patches to [-1, 1] and keeps the system well conditioned up
// to degree 5; expanded to powers of x afterwards.
Polynomial fit_polynomial(int degree, const Colours& from, const Colours& to, std::size_t channel,
                          const Weights& weights) {
  double low = INFINITY, high = -INFINITY;
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    if (!(weights[i] > 0.0)) continue;
    low = std::min(low, from[i][channel]);
    high = std::max(high, from[i][channel]);
  }
  const double centre = 0.5 * (low + high), half = high > low ? 0.5 * (high - low) : 1.0;
  const std::size_t terms = static_cast<std::size_t>(degree) + 1;
  Table rows(kPatchCount, terms), target(kPatchCount, 1);
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    double power = 1.0;
    for (std::size_t j = 0; j < terms; ++j, power *= (from[i][channel] - centre) / half)
      rows.at(i, j) = power;
    target.at(i, 0) = to[i][channel];
  }
  const Table scaled = least_squares(rows, target, weights, "polynomial stage");

  Polynomial polynomial;
  polynomial.a.fill(0.0);
  polynomial.low = low;
  polynomial.high = high;
  std::array<double, kMaxDegree + 1> basis{1.0};  // ((x - centre)/half)^j in powers of x
  for (std::size_t j = 0; j < terms; ++j) {
    for (std::size_t k = 0; k <= j; ++k) polynomial.a[k] += scaled.at(j, 0) * basis[k];
    if (j + 1 == terms) break;
    std::array<double, kMaxDegree + 1> next{};
    for (std::size_t k = 0; k <= j; ++k) {
      next[k] -= basis[k] * centre / half;
      next[k + 1] += basis[k] / half;
    }
    basis = next;
  }
  return polynomial;
}

double rms(const Colours& a, const Colours& b, const PatchColours& samples) {
  double sum = 0.0;
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    if (!samples.usable[i]) continue;
    for (std::size_t c = 0; c < 3; ++c) sum += (a[i][c] - b[i][c]) * (a[i][c] - b[i][c]);
  }
  return std::sqrt(sum / (3.0 * static_cast<double>(samples.usable_count())));
}

template <class Map>
Colours mapped(const Colours& colours, Map&& map) {
  Colours result{};
  std::transform(colours.begin(), colours.end(), result.begin(), map);
  return result;
}

// Three least-squares fits in sequence, each from the values so far to the same target. Each contains the
// identity, and the clamp moves values towards the targets, so a stage can only lower the RMS; one that
// rounding made worse stays the identity.
AffinePolyAffine fit_chain(int degree, const PatchColours& samples, const ChartReference& reference,
                           std::vector<double>& stage_rms) {
  const Weights weights = plain_weights(samples);
  const Colours target =
      mapped(reference.rgb_lin, [](const Colour& rgb) { return xyz_to_xyy(rgb_to_xyz(rgb)); });
  Colours values = mapped(samples.rgb_lin, rgb_to_stage_xyy);
  AffinePolyAffine chain;
  chain.degree = degree;
  stage_rms = {rms(values, target, samples)};
  const auto advance = [&](const Colours& next) {
    const double error = rms(next, target, samples);
    const bool better = error <= stage_rms.back();
    if (better) values = next;
    stage_rms.push_back(better ? error : stage_rms.back());
    return better;
  };
  const auto affine_stage = [&](std::string_view what) {
    const Affine affine = fit_affine(values, target, weights, what);
    return advance(mapped(values, [&](const Colour& v) { return clamp_xyy(evaluate(affine, v)); }))
               ? affine
               : Affine{};
  };

  chain.first = affine_stage("first affine stage");
  std::array<Polynomial, 3> polynomials;
  for (std::size_t c = 0; c < 3; ++c) polynomials[c] = fit_polynomial(degree, values, target, c, weights);
  const auto polynomial_stage = [&](const Colour& v) {
    Colour out{};
    for (std::size_t c = 0; c < 3; ++c) out[c] = evaluate(polynomials[c], v[c]);
    return clamp_xyy(out);
  };
  if (advance(mapped(values, polynomial_stage))) chain.polynomials = polynomials;
  chain.last = affine_stage("last affine stage");
  return chain;
}

RootPolynomial fit_root(int degree, const PatchColours& samples, const ChartReference& reference) {
  const std::size_t terms = root_term_count(degree);
  Table rows(kPatchCount, terms);
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    const std::vector<double> values = root_terms(degree, samples.rgb_lin[i]);
    for (std::size_t t = 0; t < terms; ++t) rows.at(i, t) = values[t];
  }
  const Weights weights = lightness_weights(samples, reference);
  const Table solution = least_squares(rows, table_of(reference.rgb_lin), weights, "root polynomial");
  RootPolynomial fit{degree, std::vector<Colour>(terms)};
  for (std::size_t t = 0; t < terms; ++t)
    for (std::size_t c = 0; c < 3; ++c) fit.coefficients[t][c] = solution.at(t, c);
  return fit;
}

LinearFit fit_linear(const PatchColours& samples, const ChartReference& reference) {
  return {
      fit_affine(samples.rgb_lin, reference.rgb_lin, lightness_weights(samples, reference), "linear fit")};
}

double weighted_error(const Transform& transform, const PatchColours& samples,
                      const ChartReference& reference) {
  const Weights weights = lightness_weights(samples, reference);
  double sum = 0.0;
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    if (!(weights[i] > 0.0)) continue;
    const Colour out = correct(transform, samples.rgb_lin[i]);
    for (std::size_t c = 0; c < 3; ++c)
      sum += weights[i] * (out[c] - reference.rgb_lin[i][c]) * (out[c] - reference.rgb_lin[i][c]);
  }
  return sum;
}

// One exponent for all channels, by a scan of 0.4 .. 2.5 (in steps of 8 %) and a golden-section search around
// the best: the error is smooth but need not have a single valley.
ToneLinear fit_tone(const PatchColours& samples, const ChartReference& reference) {
  const auto at = [&](double log_exponent) {
    ToneLinear fit;
    fit.exponent = std::exp(log_exponent);
    PatchColours bent = samples;
    for (Colour& colour : bent.rgb_lin)
      raise_to(fit.exponent, colour.data(), colour.size());
    fit.matrix = fit_linear(bent, reference).matrix;
    return fit;
  };
  const auto error = [&](double log_exponent) {
    return weighted_error(at(log_exponent), samples, reference);
  };
  constexpr double kStep = 0.08, kLimit = 0.92;
  double best = 0.0, best_error = error(0.0);
  for (double x = -kLimit; x <= kLimit; x += kStep) {
    if (const double e = error(x); e < best_error) {
      best = x;
      best_error = e;
    }
  }
  constexpr double kGolden = 0.6180339887498949;
  double low = best - kStep, high = best + kStep;
  double left = high - kGolden * (high - low), right = low + kGolden * (high - low);
  double left_error = error(left), right_error = error(right);
  for (int i = 0; i < 30; ++i) {  // 0.16 * 0.618^30 = 9e-8
    if (left_error <= right_error) {
      high = right;
      right = left;
      right_error = left_error;
      left = high - kGolden * (high - low);
      left_error = error(left);
    } else {
      low = left;
      left = right;
      left_error = right_error;
      right = low + kGolden * (high - low);
      right_error = error(right);
    }
  }
  const double refined = 0.5 * (low + high);
  return at(error(refined) < best_error ? refined : best);
}

Transform solve(FitKind kind, int degree, const PatchColours& samples, const ChartReference& reference,
                std::vector<double>& stage_rms) {
  switch (kind) {
    case FitKind::AffinePolyAffine:
      return fit_chain(degree, samples, reference, stage_rms);
    case FitKind::RootPoly:
      return fit_root(degree, samples, reference);
    case FitKind::ToneLinear:
      return fit_tone(samples, reference);
    default:
      return fit_linear(samples, reference);
  }
}

void check_samples(const PatchColours& samples) {
  if (samples.usable_count() < kMinUsablePatches) {
    throw UserError(
        fmt::format(
            "only {} of {} patches can be used, at least {} are needed: the others are clipped or damaged",
            samples.usable_count(), kPatchCount, kMinUsablePatches),
        "expose so that the white patch is not clipped and the black patch is above zero");
  }
  for (std::size_t i = 0; i < kPatchCount; ++i)
    for (const double value : samples.rgb_lin[i])
      if (samples.usable[i] && !std::isfinite(value))
        throw UserError(fmt::format("patch {} ({}) is not a finite number", i + 1, patch_names()[i]));
}

void check_degree(FitKind kind, int degree) {
  const int most = kind == FitKind::RootPoly ? 3 : kMaxDegree;
  if ((kind == FitKind::RootPoly || kind == FitKind::AffinePolyAffine) && (degree < 1 || degree > most)) {
    throw UserError(fmt::format("degree {} is outside of 1..{}", degree, most),
                    "24 patches do not carry more");
  }
}

double held_out_error(FitKind kind, int degree, const PatchColours& samples,
                      const ChartReference& reference) {
  std::array<double, kPatchCount> errors{};
  host::parallel_for(static_cast<std::int64_t>(kPatchCount), [&](std::int64_t index) {
    const std::size_t left_out = static_cast<std::size_t>(index);
    if (!samples.usable[left_out]) return;
    PatchColours rest = samples;
    rest.usable[left_out] = false;
    std::vector<double> ignored;
    const Transform transform = solve(kind, degree, rest, reference, ignored);
    errors[left_out] =
        delta_e_2000(rgb_to_lab(correct(transform, samples.rgb_lin[left_out])), reference.lab_d65[left_out]);
  });
  double sum = 0.0;
  for (const double error : errors) sum += error;
  return sum / static_cast<double>(samples.usable_count());
}

}  // namespace

std::size_t PatchColours::usable_count() const {
  return static_cast<std::size_t>(std::count(usable.begin(), usable.end(), true));
}

FitKind parse_fit_kind(std::string_view name) {
  static const std::vector<std::string> known{"auto", "affine-poly-affine", "linear", "root-poly",
                                              "tone-linear"};
  const auto found = std::find(known.begin(), known.end(), name);
  if (found == known.end())
    throw UserError(fmt::format("unknown fit '{}'", name), host::did_you_mean(name, known));
  return static_cast<FitKind>(found - known.begin());
}

Differences differences(const std::array<Colour, kPatchCount>& rgb_lin, const ChartReference& reference) {
  Differences result;
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    const Colour lab = rgb_to_lab(rgb_lin[i]);
    result.de2000[i] = delta_e_2000(lab, reference.lab_d65[i]);
    result.de76[i] = delta_e_76(lab, reference.lab_d65[i]);
    result.mean_de2000 += result.de2000[i] / static_cast<double>(kPatchCount);
    result.mean_de76 += result.de76[i] / static_cast<double>(kPatchCount);
    result.max_de2000 = std::max(result.max_de2000, result.de2000[i]);
  }
  return result;
}

Fit fit_transform(FitKind kind, int degree, const PatchColours& samples, const ChartReference& reference) {
  ALU_CHECK(kind != FitKind::Auto, "auto is not a kind of fit");
  check_degree(kind, degree);
  check_samples(samples);
  Fit fit;
  fit.transform = solve(kind, degree, samples, reference, fit.stage_rms);
  for (std::size_t i = 0; i < kPatchCount; ++i) fit.corrected[i] = correct(fit.transform, samples.rgb_lin[i]);
  fit.before = differences(samples.rgb_lin, reference);
  fit.after = differences(fit.corrected, reference);
  return fit;
}

std::string objection_to(const Transform& transform, const PatchColours& samples) {
  Colour brightest{};
  for (std::size_t i = 0; i < kPatchCount; ++i)
    if (samples.usable[i] && rgb_to_xyz(samples.rgb_lin[i])[1] > rgb_to_xyz(brightest)[1])
      brightest = samples.rgb_lin[i];
  constexpr int kSteps = 64;
  double before = 0.0;
  for (int step = 0; step <= kSteps; ++step) {
    const double t = static_cast<double>(step) / kSteps;
    const Colour albedo = correct(transform, {t * brightest[0], t * brightest[1], t * brightest[2]});
    const double luminance = std::max(0.0, rgb_to_xyz(albedo)[1]);
    if (luminance < before - 1e-6) return "makes more light darker";
    before = luminance;
  }
  return "";
}

FitChoice choose_fit(FitKind kind, int degree, const PatchColours& samples, const ChartReference& reference) {
  check_degree(kind, degree);
  check_samples(samples);
  struct Trial {
    FitKind kind;
    int degree;
  };
  std::vector<Trial> trials{{kind, degree}};
  if (kind == FitKind::Auto) {  // the simplest first: it wins a tie
    trials = {{FitKind::Linear, 1}, {FitKind::ToneLinear, 1}, {FitKind::RootPoly, 2}, {FitKind::RootPoly, 3}};
    for (int d = 1; d <= kMaxDegree; ++d) trials.push_back({FitKind::AffinePolyAffine, d});
  }
  FitChoice choice;
  std::optional<double> best;
  bool best_has_objection = false;
  std::string refusal;
  for (const Trial& trial : trials) {
    try {
      Fit fit = fit_transform(trial.kind, trial.degree, samples, reference);
      Candidate candidate{transform_name(fit.transform), std::nullopt, objection_to(fit.transform, samples)};
      try {
        candidate.held_out_de2000 = held_out_error(trial.kind, trial.degree, samples, reference);
      } catch (const UserError&) {
        // One patch fewer no longer determines it: the fit stands, but nothing is known about other colours.
        if (kind != FitKind::Auto) choice.fit = std::move(fit);
        choice.candidates.push_back(std::move(candidate));
        continue;
      }
      const bool has_objection = !candidate.objection.empty();
      if (!best ||
          (has_objection == best_has_objection ? *candidate.held_out_de2000 < *best : best_has_objection)) {
        best = candidate.held_out_de2000;
        best_has_objection = has_objection;
        choice.fit = std::move(fit);
        choice.fit.held_out_de2000 = *best;
      }
      choice.candidates.push_back(std::move(candidate));
    } catch (const UserError& error) {
      if (kind != FitKind::Auto) throw;
      if (refusal.empty()) refusal = error.what();
    }
  }
  if (!best && kind == FitKind::Auto) {
    throw UserError(refusal.empty() ? "the usable patches determine no fit" : refusal,
                    "photograph the whole chart under even light");
  }
  return choice;
}

}  // namespace aluminate::calibration
