#include "calibration/colour_space.hpp"

#include <cmath>
#include <numbers>

#include "platform/host/error.hpp"

namespace aluminate::calibration {
namespace {

// Primaries of sRGB [IEC61966-2-1].
constexpr std::array<std::array<double, 2>, 3> kPrimariesXy{{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}}};

// The Bradford cone response [Lam85].
constexpr Matrix3 kBradford{
    {{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};

// CIE's exact rationals: the cube root and its tangent meet here.
constexpr double kLabEpsilon = 216.0 / 24389.0;
constexpr double kLabKappa = 24389.0 / 27.0;

Matrix3 make_srgb_to_xyz() {
  Matrix3 primaries{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Colour xyz = white_xyz(kPrimariesXy[i]);
    for (std::size_t row = 0; row < 3; ++row) primaries[row][i] = xyz[row];
  }
  const Colour scale = multiply(inverse(primaries), white_xyz(kWhiteD65Xy));
  for (auto& row : primaries)
    for (std::size_t i = 0; i < 3; ++i) row[i] *= scale[i];
  return primaries;
}

double lab_f(double t) noexcept { return t > kLabEpsilon ? std::cbrt(t) : (kLabKappa * t + 16.0) / 116.0; }
double lab_f_inverse(double f) noexcept {
  const double cube = f * f * f;
  return cube > kLabEpsilon ? cube : (116.0 * f - 16.0) / kLabKappa;
}

double radians(double degrees) noexcept { return degrees * std::numbers::pi / 180.0; }

// Hue angle in degrees, [0, 360); 0 for a neutral.
double hue_degrees(double a, double b) noexcept {
  if (a == 0.0 && b == 0.0) return 0.0;
  const double degrees = std::atan2(b, a) * 180.0 / std::numbers::pi;
  return degrees < 0.0 ? degrees + 360.0 : degrees;
}

}  // namespace

Colour multiply(const Matrix3& m, const Colour& c) noexcept {
  return {m[0][0] * c[0] + m[0][1] * c[1] + m[0][2] * c[2], m[1][0] * c[0] + m[1][1] * c[1] + m[1][2] * c[2],
          m[2][0] * c[0] + m[2][1] * c[1] + m[2][2] * c[2]};
}

Matrix3 multiply(const Matrix3& a, const Matrix3& b) noexcept {
  Matrix3 product{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      product[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
  return product;
}

Matrix3 inverse(const Matrix3& m) {
  const auto minor = [&](std::size_t r0, std::size_t r1, std::size_t c0, std::size_t c1) {
    return m[r0][c0] * m[r1][c1] - m[r0][c1] * m[r1][c0];
  };
  const double determinant =
      m[0][0] * minor(1, 2, 1, 2) - m[0][1] * minor(1, 2, 0, 2) + m[0][2] * minor(1, 2, 0, 1);
  if (!std::isfinite(determinant) || determinant == 0.0)
    throw UserError("a colour matrix cannot be inverted");
  const double r = 1.0 / determinant;
  return {{{minor(1, 2, 1, 2) * r, -minor(0, 2, 1, 2) * r, minor(0, 1, 1, 2) * r},
           {-minor(1, 2, 0, 2) * r, minor(0, 2, 0, 2) * r, -minor(0, 1, 0, 2) * r},
           {minor(1, 2, 0, 1) * r, -minor(0, 2, 0, 1) * r, minor(0, 1, 0, 1) * r}}};
}

double srgb_to_linear(double encoded) noexcept {
  const double s = std::fabs(encoded);
  return std::copysign(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4), encoded);
}

double linear_to_srgb(double linear) noexcept {
  const double l = std::fabs(linear);
  return std::copysign(l <= 0.0031308 ? l * 12.92 : 1.055 * std::pow(l, 1.0 / 2.4) - 0.055, linear);
}

const Matrix3& srgb_to_xyz_matrix() {
  static const Matrix3 matrix = make_srgb_to_xyz();
  return matrix;
}

const Matrix3& xyz_to_srgb_matrix() {
  static const Matrix3 matrix = inverse(srgb_to_xyz_matrix());
  return matrix;
}

Colour xyz_to_xyy(const Colour& xyz, const std::array<double, 2>& white) noexcept {
  const double sum = xyz[0] + xyz[1] + xyz[2];
  if (sum == 0.0) return {white[0], white[1], xyz[1]};
  return {xyz[0] / sum, xyz[1] / sum, xyz[1]};
}

Colour xyy_to_xyz(const Colour& xyy) noexcept {
  if (!(xyy[1] > 0.0)) return {0.0, 0.0, 0.0};
  const double sum = xyy[2] / xyy[1];
  return {xyy[0] * sum, xyy[2], (1.0 - xyy[0] - xyy[1]) * sum};
}

Colour white_xyz(const std::array<double, 2>& xy) noexcept { return xyy_to_xyz({xy[0], xy[1], 1.0}); }

Matrix3 bradford(const std::array<double, 2>& from, const std::array<double, 2>& to) {
  const Colour cone_from = multiply(kBradford, white_xyz(from)), cone_to = multiply(kBradford, white_xyz(to));
  Matrix3 scaled = kBradford;
  for (std::size_t row = 0; row < 3; ++row)
    for (double& value : scaled[row]) value *= cone_to[row] / cone_from[row];
  return multiply(inverse(kBradford), scaled);
}

Colour xyz_to_lab(const Colour& xyz, const std::array<double, 2>& white) noexcept {
  const Colour w = white_xyz(white);
  const double fx = lab_f(xyz[0] / w[0]), fy = lab_f(xyz[1] / w[1]), fz = lab_f(xyz[2] / w[2]);
  return {116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)};
}

Colour lab_to_xyz(const Colour& lab, const std::array<double, 2>& white) noexcept {
  const Colour w = white_xyz(white);
  const double fy = (lab[0] + 16.0) / 116.0;
  return {w[0] * lab_f_inverse(fy + lab[1] / 500.0), w[1] * lab_f_inverse(fy),
          w[2] * lab_f_inverse(fy - lab[2] / 200.0)};
}

Colour rgb_to_lab(const Colour& rgb) noexcept { return xyz_to_lab(rgb_to_xyz(rgb), kWhiteD65Xy); }

double delta_e_76(const Colour& a, const Colour& b) noexcept {
  const double dl = a[0] - b[0], da = a[1] - b[1], db = a[2] - b[2];
  return std::sqrt(dl * dl + da * da + db * db);
}

double delta_e_2000(const Colour& a, const Colour& b) noexcept {
  constexpr double k25To7 = 6103515625.0;
  const auto chroma_weight = [](double c) { return std::sqrt(std::pow(c, 7) / (std::pow(c, 7) + k25To7)); };
  const double mean_c = (std::hypot(a[1], a[2]) + std::hypot(b[1], b[2])) / 2.0;
  const double g = 0.5 * (1.0 - chroma_weight(mean_c));
  const double a1 = (1.0 + g) * a[1], a2 = (1.0 + g) * b[1];
  const double c1 = std::hypot(a1, a[2]), c2 = std::hypot(a2, b[2]);
  const double h1 = hue_degrees(a1, a[2]), h2 = hue_degrees(a2, b[2]);

  double dh = h2 - h1;
  if (c1 * c2 == 0.0)
    dh = 0.0;
  else if (dh > 180.0)
    dh -= 360.0;
  else if (dh < -180.0)
    dh += 360.0;
  double mean_h = h1 + h2;
  if (c1 * c2 != 0.0) {
    if (std::fabs(h1 - h2) <= 180.0)
      mean_h /= 2.0;
    else
      mean_h = (mean_h < 360.0 ? mean_h + 360.0 : mean_h - 360.0) / 2.0;
  }

  const double dl = b[0] - a[0], dc = c2 - c1,
               dh_chord = 2.0 * std::sqrt(c1 * c2) * std::sin(radians(dh) / 2.0);
  const double mean_l = (a[0] + b[0]) / 2.0, mean_c2 = (c1 + c2) / 2.0;
  const double t = 1.0 - 0.17 * std::cos(radians(mean_h - 30.0)) + 0.24 * std::cos(radians(2.0 * mean_h)) +
                   0.32 * std::cos(radians(3.0 * mean_h + 6.0)) -
                   0.20 * std::cos(radians(4.0 * mean_h - 63.0));
  const double l50 = (mean_l - 50.0) * (mean_l - 50.0);
  const double sl = 1.0 + 0.015 * l50 / std::sqrt(20.0 + l50);
  const double sc = 1.0 + 0.045 * mean_c2, sh = 1.0 + 0.015 * mean_c2 * t;
  const double bump = (mean_h - 275.0) / 25.0;
  const double rotation = -std::sin(radians(60.0 * std::exp(-bump * bump))) * 2.0 * chroma_weight(mean_c2);
  const double l = dl / sl, c = dc / sc, h = dh_chord / sh;
  return std::sqrt(l * l + c * c + h * h + rotation * c * h);
}

bool outside_gamut(const Colour& rgb) noexcept {
  constexpr double kRounding = 1e-12;
  for (const double value : rgb)
    if (!(value >= -kRounding && value <= 1.0 + kRounding)) return true;
  return false;
}

}  // namespace aluminate::calibration
