// Colour conversions of the calibration, in double precision: linear sRGB (D65), CIE XYZ, xyY, Lab, colour
// differences. In and out: values, Y = 1 is a perfect white diffuser. Pure functions; nothing is clipped
// unless it says so.
#pragma once

#include <array>

namespace aluminate::calibration {

/// Three numbers of one colour; the function that takes them says which space.
using Colour = std::array<double, 3>;
using Matrix3 = std::array<std::array<double, 3>, 3>;  // rows

inline constexpr std::array<double, 2> kWhiteD50Xy{0.3457, 0.3585};  // [CIE15]
inline constexpr std::array<double, 2> kWhiteD65Xy{0.3127, 0.3290};

Colour multiply(const Matrix3& matrix, const Colour& colour) noexcept;
Matrix3 multiply(const Matrix3& a, const Matrix3& b) noexcept;
/// Throws UserError when the determinant is 0.
Matrix3 inverse(const Matrix3& matrix);

/// [IEC61966-2-1]; odd for negative values, unbounded above 1.
double srgb_to_linear(double encoded) noexcept;
double linear_to_srgb(double linear) noexcept;

/// Linear sRGB to XYZ relative to D65, from the primaries and the white above (not the rounded table of the
/// standard), so that RGB 1,1,1 has the chromaticity of the white exactly.
const Matrix3& srgb_to_xyz_matrix();
const Matrix3& xyz_to_srgb_matrix();
inline Colour rgb_to_xyz(const Colour& rgb) { return multiply(srgb_to_xyz_matrix(), rgb); }
inline Colour xyz_to_rgb(const Colour& xyz) { return multiply(xyz_to_srgb_matrix(), xyz); }

/// X+Y+Z = 0 has no chromaticity: `white` is used. y <= 0 in the other direction gives black.
Colour xyz_to_xyy(const Colour& xyz, const std::array<double, 2>& white = kWhiteD65Xy) noexcept;
Colour xyy_to_xyz(const Colour& xyy) noexcept;

/// XYZ of a white point with Y = 1.
Colour white_xyz(const std::array<double, 2>& xy) noexcept;

/// Linear Bradford adaptation [Lam85]: maps the white `from` exactly to `to`.
Matrix3 bradford(const std::array<double, 2>& from, const std::array<double, 2>& to);

/// CIE 1976 L*a*b* [CIE15].
Colour xyz_to_lab(const Colour& xyz, const std::array<double, 2>& white) noexcept;
Colour lab_to_xyz(const Colour& lab, const std::array<double, 2>& white) noexcept;

/// Linear sRGB to Lab relative to D65: the space of every difference that is reported.
Colour rgb_to_lab(const Colour& rgb) noexcept;

double delta_e_76(const Colour& lab_a, const Colour& lab_b) noexcept;
/// CIEDE2000 with kL = kC = kH = 1 [Sharma05].
double delta_e_2000(const Colour& lab_a, const Colour& lab_b) noexcept;

/// True when a component of linear sRGB lies outside of [0, 1] by more than the rounding of a matrix product.
bool outside_gamut(const Colour& rgb) noexcept;

}  // namespace aluminate::calibration
