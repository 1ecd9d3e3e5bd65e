#include "calibration/transform.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "calibration/power.hpp"
#include "platform/host/error.hpp"

namespace aluminate::calibration {
namespace {

// cbrt by an exponent-dividing first guess and three Halley steps, so that a loop over it vectorises. x >= 0.
// Error of the guess below 6 %; a step turns e into about 2/3 e^3: 6e-2, 1.5e-4, 2e-12, rounding.
inline double cube_root(double x) noexcept {
  constexpr std::uint64_t kBias =
      0x2A9F'7893'0000'0000u;  // two thirds of the exponent bias, tuned for the mantissa
  double y = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) / 3 + kBias);
  for (int step = 0; step < 3; ++step) {
    const double cube = y * y * y;
    y = y * ((cube + 2.0 * x) / (2.0 * cube + x));
  }
  return x > 0.0 ? y : 0.0;
}

inline void affine_columns(const Affine& f, double& a, double& b, double& c) noexcept {
  const double x = a, y = b, z = c;
  a = f.m[0][0] * x + f.m[0][1] * y + f.m[0][2] * z + f.m[0][3];
  b = f.m[1][0] * x + f.m[1][1] * y + f.m[1][2] * z + f.m[1][3];
  c = f.m[2][0] * x + f.m[2][1] * y + f.m[2][2] * z + f.m[2][3];
}

inline void matrix_columns(const Matrix3& m, double& a, double& b, double& c) noexcept {
  const double x = a, y = b, z = c;
  a = m[0][0] * x + m[0][1] * y + m[0][2] * z;
  b = m[1][0] * x + m[1][1] * y + m[1][2] * z;
  c = m[2][0] * x + m[2][1] * y + m[2][2] * z;
}

inline double at_least(double value, double bound) noexcept {
  return value > bound ? value : bound;
}  // a NaN becomes the bound

inline double within(double value, double low, double high) noexcept {
  const double raised = at_least(value, low);
  return raised < high ? raised : high;
}

// RGB columns to xyY of the first stage.
inline void to_stage_xyy(const Matrix3& to_xyz, double& r, double& g, double& b) noexcept {
  matrix_columns(to_xyz, r, g, b);
  const double sum = r + g + b, luminance = g;
  const double reciprocal = sum > 0.0 ? 1.0 / sum : 0.0;
  r = sum > 0.0 ? within(r * reciprocal, 0.0, kMaxChroma) : kWhiteD65Xy[0];
  g = sum > 0.0 ? within(g * reciprocal, kMinInputChromaY, kMaxChroma) : kWhiteD65Xy[1];
  b = at_least(luminance, 0.0);
}

double horner(const std::array<double, kMaxDegree + 1>& a, double x) noexcept {
  return a[0] + x * (a[1] + x * (a[2] + x * (a[3] + x * (a[4] + x * a[5]))));
}

double slope(const std::array<double, kMaxDegree + 1>& a, double x) noexcept {
  return a[1] + x * (2.0 * a[2] + x * (3.0 * a[3] + x * (4.0 * a[4] + x * 5.0 * a[5])));
}

// Inside [low, high] both clamps vanish exactly and the result is the polynomial.
struct PolynomialKernel {
  explicit PolynomialKernel(const Polynomial& p) noexcept
      : polynomial(p), low_slope(slope(p.a, p.low)), high_slope(slope(p.a, p.high)) {}
  double operator()(double x) const noexcept {
    const double clamped = std::min(std::max(x, polynomial.low), polynomial.high);
    const double over = x - clamped;
    return horner(polynomial.a, clamped) + over * (over > 0.0 ? high_slope : low_slope);
  }
  Polynomial polynomial;
  double low_slope, high_slope;
};

void correct_kind(const LinearFit& fit, double* r, double* g, double* b, std::size_t count) noexcept {
  const Affine f = fit.matrix;
  for (std::size_t i = 0; i < count; ++i) affine_columns(f, r[i], g[i], b[i]);
}

void correct_kind(const ToneLinear& fit, double* r, double* g, double* b, std::size_t count) noexcept {
  for (double* channel : {r, g, b}) raise_to(fit.exponent, channel, count);
  const Affine f = fit.matrix;
  for (std::size_t i = 0; i < count; ++i) affine_columns(f, r[i], g[i], b[i]);
}

template <int degree>
inline void root_terms_of(double r, double g, double b, double* t) noexcept {
  r = at_least(r, 0.0);
  g = at_least(g, 0.0);
  b = at_least(b, 0.0);
  t[0] = r;
  t[1] = g;
  t[2] = b;
  if constexpr (degree >= 2) {
    const double sr = std::sqrt(r), sg = std::sqrt(g), sb = std::sqrt(b);
    t[3] = sr * sg;
    t[4] = sg * sb;
    t[5] = sr * sb;
  }
  if constexpr (degree >= 3) {
    const double cr = cube_root(r), cg = cube_root(g), cb = cube_root(b);
    t[6] = cr * cg * cg;
    t[7] = cg * cb * cb;
    t[8] = cr * cb * cb;
    t[9] = cg * cr * cr;
    t[10] = cb * cg * cg;
    t[11] = cb * cr * cr;
    t[12] = cr * cg * cb;
  }
}

template <int degree>
void correct_root(const RootPolynomial& fit, double* r, double* g, double* b, std::size_t count) noexcept {
  constexpr std::size_t kTerms = degree == 1 ? 3 : degree == 2 ? 6 : 13;
  std::array<Colour, kTerms> k{};
  for (std::size_t t = 0; t < kTerms; ++t) k[t] = fit.coefficients[t];
  for (std::size_t i = 0; i < count; ++i) {
    double term[kTerms];
    root_terms_of<degree>(r[i], g[i], b[i], term);
    double sum0 = 0.0, sum1 = 0.0, sum2 = 0.0;
    for (std::size_t t = 0; t < kTerms; ++t) {
      sum0 += k[t][0] * term[t];
      sum1 += k[t][1] * term[t];
      sum2 += k[t][2] * term[t];
    }
    r[i] = sum0;
    g[i] = sum1;
    b[i] = sum2;
  }
}

void correct_kind(const RootPolynomial& fit, double* r, double* g, double* b, std::size_t count) noexcept {
  if (fit.degree == 1)
    correct_root<1>(fit, r, g, b, count);
  else if (fit.degree == 2)
    correct_root<2>(fit, r, g, b, count);
  else
    correct_root<3>(fit, r, g, b, count);
}

void correct_kind(const AffinePolyAffine& fit, double* r, double* g, double* b, std::size_t count) noexcept {
  const Matrix3 to_xyz = srgb_to_xyz_matrix(), to_rgb = xyz_to_srgb_matrix();
  const Affine first = fit.first, last = fit.last;
  const PolynomialKernel px(fit.polynomials[0]), py(fit.polynomials[1]), p_lum(fit.polynomials[2]);
  for (std::size_t i = 0; i < count; ++i) {
    double x = r[i], y = g[i], z = b[i];
    to_stage_xyy(to_xyz, x, y, z);
    affine_columns(first, x, y, z);
    y = at_least(y, kMinChromaY);
    z = at_least(z, 0.0);
    x = px(x);
    y = at_least(py(y), kMinChromaY);
    z = at_least(p_lum(z), 0.0);
    affine_columns(last, x, y, z);
    y = at_least(y, kMinChromaY);
    z = at_least(z, 0.0);
    const double sum = z / y;
    double out_x = x * sum, out_y = z, out_z = (1.0 - x - y) * sum;
    matrix_columns(to_rgb, out_x, out_y, out_z);
    r[i] = out_x;
    g[i] = out_y;
    b[i] = out_z;
  }
}

}  // namespace

std::size_t root_term_count(int degree) { return degree == 1 ? 3 : degree == 2 ? 6 : 13; }

const std::array<std::string_view, 13>& root_term_names() {
  static constexpr std::array<std::string_view, 13> kNames{
      "r",         "g",         "b",         "sqrt(rg)",  "sqrt(gb)",  "sqrt(rb)", "cbrt(rgg)",
      "cbrt(gbb)", "cbrt(rbb)", "cbrt(grr)", "cbrt(bgg)", "cbrt(brr)", "cbrt(rgb)"};
  return kNames;
}

std::vector<double> root_terms(int degree, const Colour& rgb) {
  std::vector<double> terms(13, 0.0);
  root_terms_of<3>(rgb[0], rgb[1], rgb[2], terms.data());
  terms.resize(root_term_count(degree));
  return terms;
}

double evaluate(const Polynomial& polynomial, double x) noexcept { return PolynomialKernel(polynomial)(x); }

Colour evaluate(const Affine& affine, const Colour& in) noexcept {
  Colour out = in;
  affine_columns(affine, out[0], out[1], out[2]);
  return out;
}

Colour clamp_xyy(const Colour& xyy) noexcept {
  return {xyy[0], at_least(xyy[1], kMinChromaY), at_least(xyy[2], 0.0)};
}

Colour rgb_to_stage_xyy(const Colour& rgb) noexcept {
  Colour xyy = rgb;
  to_stage_xyy(srgb_to_xyz_matrix(), xyy[0], xyy[1], xyy[2]);
  return xyy;
}

void correct(const Transform& transform, double* r, double* g, double* b, std::size_t count) noexcept {
  std::visit([&](const auto& fit) { correct_kind(fit, r, g, b, count); }, transform);
}

Colour correct(const Transform& transform, const Colour& rgb) noexcept {
  Colour out = rgb;
  correct(transform, &out[0], &out[1], &out[2], 1);
  return out;
}

std::string transform_name(const Transform& transform) {
  if (const auto* root = std::get_if<RootPolynomial>(&transform))
    return fmt::format("root-poly {}", root->degree);
  if (const auto* chain = std::get_if<AffinePolyAffine>(&transform))
    return fmt::format("affine-poly-affine {}", chain->degree);
  return std::holds_alternative<LinearFit>(transform) ? "linear" : "tone-linear";
}

}  // namespace aluminate::calibration
