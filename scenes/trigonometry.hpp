// Sine and cosine as literal sequences of correctly rounded IEEE operations. Scene set-up reaches pixels, and
// libm's sin and cos may differ between C libraries; these have the same bits everywhere. Error below 1.5 ulp
// of 1 for |x| <= 2^20.
#pragma once

#include <cmath>
#include <initializer_list>

namespace aluminate::scenes {

inline constexpr double kPi = 3.141592653589793;

struct SinCos {
  double sin = 0, cos = 1;
};

/// x in radians, |x| <= 2^20. NaN gives NaN.
inline SinCos sin_cos(double x) noexcept {
  // Cody-Waite: pi/2 = high + low; the fma keeps x - k*high exact to one rounding even where it nearly
  // cancels.
  constexpr double kHalfPiHigh = 1.5707963267948966, kHalfPiLow = 6.123233995736766e-17;
  const double k = std::nearbyint(x * (2 / kPi));
  const double r = std::fma(-k, kHalfPiLow, std::fma(-k, kHalfPiHigh, x));  // |r| <= pi/4 + rounding
  const double q = r * r;
  // Taylor in q, Horner: the first term left out is r^19/19! < 9e-20 and r^18/18! < 2.1e-18 at pi/4.
  const auto horner = [q](std::initializer_list<double> divisors) {
    double sum = 1;
    for (const double d : divisors) sum = std::fma(-q / d, sum, 1.0);
    return sum;
  };
  const double s = r * horner({17. * 16, 15. * 14, 13. * 12, 11. * 10, 9. * 8, 7. * 6, 5. * 4, 3. * 2});
  const double c = horner({16. * 15, 14. * 13, 12. * 11, 10. * 9, 8. * 7, 6. * 5, 4. * 3, 2. * 1});
  const double quarter = k - 4 * std::floor(k / 4);  // 0, 1, 2, 3
  if (quarter == 0) return {s, c};
  if (quarter == 1) return {c, -s};
  if (quarter == 2) return {-s, -c};
  return quarter == 3 ? SinCos{-c, s} : SinCos{s, c};
}

}  // namespace aluminate::scenes
