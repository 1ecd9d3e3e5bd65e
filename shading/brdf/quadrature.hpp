// Double-exponential quadrature for the reference integrals: furnace, sky projection. In: a function smooth
// inside an interval. Out: its integral. Endpoints may hold kinks, square roots or poles just outside; the
// inside may not, so callers split at every kink they know of. Never used on a path to a pixel.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace aluminate::brdf {

/// [Takahasi74] tanh-sinh rule: x = a + (b - a) / (1 + exp(-pi sinh t)), trapezoid in t, step halved until
/// two levels agree to `tolerance` absolute plus the same relative. Convergence is quadratic, so the returned
/// level is far better than the agreement that stopped it. Value must support + Value, * double and
/// magnitude(Value); double is covered below. At least 3 levels (about 50 points), at most 7 (about 800).
template <class Value, class Function, class Magnitude>
[[nodiscard]] Value integrate(const Function& f, double a, double b, double tolerance,
                              const Magnitude& magnitude) {
  Value sum{};
  if (!(b > a)) return sum;
  constexpr double kReach = 3.2;  // weights beyond are below 1e-15 of the middle's
  const auto add = [&](double t) {
    const double e = std::exp(-std::numbers::pi * std::sinh(t));
    const double fraction = 1.0 / (1.0 + e);  // of the interval, from a
    const double weight = std::numbers::pi * std::cosh(t) * e * fraction * fraction;
    sum = sum + f(a + (b - a) * fraction) * weight;
  };
  double step = 0.4;
  const int half_count = static_cast<int>(kReach / step);
  for (int i = -half_count; i <= half_count; ++i) add(i * step);
  Value previous = sum * (step * (b - a));
  for (int level = 1, count = half_count; level <= 7; ++level) {
    count *= 2;
    step *= 0.5;
    for (int i = -count + 1; i < count; i += 2) add(i * step);
    const Value current = sum * (step * (b - a));
    if (level >= 2 && magnitude(current + previous * -1.0) <= tolerance * (1.0 + magnitude(current)))
      return current;
    previous = current;
  }
  return previous;
}

/// The scalar case.
template <class Function>
[[nodiscard]] double integrate(const Function& f, double a, double b, double tolerance = 1e-9) {
  return integrate<double>(f, a, b, tolerance, [](double x) { return std::fabs(x); });
}

}  // namespace aluminate::brdf
