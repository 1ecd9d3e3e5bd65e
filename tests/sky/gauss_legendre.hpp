// A second quadrature for the sky tests: composite five-point Gauss-Legendre, graded by sin^2 towards both
// ends so that square roots there do no harm. Shares nothing with the rule under test.
#pragma once

#include <cmath>
#include <numbers>

namespace aluminate::sky {

template <class Value, class Function>
Value gauss_legendre(const Function& f, double a, double b, int panels) {
  constexpr double kNodes[] = {-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831,
                               0.9061798459386640};
  constexpr double kWeights[] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                 0.4786286704993665, 0.2369268850561891};
  Value sum{};
  const double width = std::numbers::pi / 2.0 / panels;
  for (int i = 0; i < panels; ++i)
    for (int k = 0; k < 5; ++k) {
      const double u = (i + 0.5 + 0.5 * kNodes[k]) * width;
      sum += f(a + (b - a) * std::sin(u) * std::sin(u)) *
             (kWeights[k] * 0.5 * width * (b - a) * std::sin(2.0 * u));
    }
  return sum;
}

}  // namespace aluminate::sky
