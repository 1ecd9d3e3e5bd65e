// What a fit produces and an image is corrected with: a map from the photograph's linear RGB to albedo in
// linear sRGB. Four kinds; each holds exactly the numbers that the JSON export prints, so a reader can repeat
// the correction by hand. Applied to columns of values, so that the loop over pixels vectorises; one
// definition serves patches and images.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "calibration/colour_space.hpp"

namespace aluminate::calibration {

inline constexpr int kMaxDegree = 5;  // beyond it the normal equations lose half of their digits
inline constexpr double kMinChromaY =
    1e-4;  // y and Y are kept at or above kMinChromaY and 0 after every xyY stage
// Chromaticities of input outside of this box belong to no light (the spectral locus ends at x 0.735, y
// 0.834): noise of nearly black pixels. y of a saturated violet goes down to 0.005, that of a surface colour
// never.
inline constexpr double kMaxChroma = 0.85, kMinInputChromaY = 0.01;

/// out[i] = sum_j m[i][j] in[j] + m[i][3].
struct Affine {
  std::array<std::array<double, 4>, 3> m{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  bool operator==(const Affine&) const = default;
};

/// sum_j a[j] x^j for x in [low, high], the range of the patches; beyond it the tangent at its end goes on,
/// because a polynomial of degree 3 or 5 is worth nothing outside of its samples.
struct Polynomial {
  std::array<double, kMaxDegree + 1> a{0, 1, 0, 0, 0, 0};
  double low = 0.0, high = 1.0;
  bool operator==(const Polynomial&) const = default;
};

/// Affine, then one polynomial a channel, then affine, all in xyY of linear sRGB primaries [McAuley12]. After
/// each stage y >= kMinChromaY and Y >= 0. Input without light has the chromaticity of the white point.
struct AffinePolyAffine {
  Affine first;
  std::array<Polynomial, 3> polynomials;
  Affine last;
  int degree = 3;
};

/// Affine in linear RGB: white balance, cross-talk, exposure and flare.
struct LinearFit {
  Affine matrix;
};

/// rgb^exponent (odd for negative values), then affine: the same behind a camera's tone curve or a wrong
/// gamma.
struct ToneLinear {
  double exponent = 1.0;
  Affine matrix;
};

/// Root polynomials [Finlayson15]: homogeneous of degree 1, so a change of exposure scales the result.
/// Negative input is taken as 0. Terms of degree 2: r g b sqrt(rg) sqrt(gb) sqrt(rb); of degree 3 also cbrt
/// of rg^2 gb^2 rb^2 gr^2 bg^2 br^2 and rgb.
struct RootPolynomial {
  int degree = 2;                    // 1..3
  std::vector<Colour> coefficients;  // one a term: what it adds to R, G and B
};

using Transform = std::variant<LinearFit, ToneLinear, RootPolynomial, AffinePolyAffine>;

std::size_t root_term_count(int degree);  // 3, 6, 13
const std::array<std::string_view, 13>& root_term_names();
/// The terms of one colour, in the order above.
std::vector<double> root_terms(int degree, const Colour& rgb);

double evaluate(const Polynomial& polynomial, double x) noexcept;
Colour evaluate(const Affine& affine, const Colour& in) noexcept;
/// xyY with y and Y brought up to their lower bounds.
Colour clamp_xyy(const Colour& xyy) noexcept;
/// What the first stage of AffinePolyAffine sees.
Colour rgb_to_stage_xyy(const Colour& rgb) noexcept;

/// count values a channel, replaced in place. Negative results stay negative.
void correct(const Transform& transform, double* r, double* g, double* b, std::size_t count) noexcept;
Colour correct(const Transform& transform, const Colour& rgb) noexcept;

/// "linear", "tone-linear", "root-poly 2", "affine-poly-affine 3".
std::string transform_name(const Transform& transform);

}  // namespace aluminate::calibration
