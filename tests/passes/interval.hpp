// Closed intervals of binary64 for bounds that must not be tuned: every operation encloses the true result
// but for the last-bit rounding of its ends, which tests cover with their own slack.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>

namespace aluminate::test {

struct Interval {
  double low = 0, high = 0;
  constexpr Interval() = default;
  constexpr Interval(double value) : low(value), high(value) {}  // NOLINT: numbers are intervals
  constexpr Interval(double a, double b) : low(a), high(b) {}
  double width() const { return high - low; }
};
inline Interval operator+(Interval a, Interval b) { return {a.low + b.low, a.high + b.high}; }
inline Interval operator-(Interval a, Interval b) { return {a.low - b.high, a.high - b.low}; }
inline Interval operator*(Interval a, Interval b) {
  const double p[] = {a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high};
  return {*std::min_element(p, p + 4), *std::max_element(p, p + 4)};
}
/// b > 0.
inline Interval operator/(Interval a, Interval b) { return a * Interval(1 / b.high, 1 / b.low); }
inline Interval clamped(Interval a, double low, double high) {
  return {std::clamp(a.low, low, high), std::clamp(a.high, low, high)};
}
inline Interval square(Interval a) {
  const double l = a.low * a.low, h = a.high * a.high;
  return {a.low <= 0 && a.high >= 0 ? 0 : std::min(l, h), std::max(l, h)};
}
inline Interval root(Interval a) { return {std::sqrt(a.low), std::sqrt(a.high)}; }

struct Interval3 {
  std::array<Interval, 3> at{};
  Interval3() = default;
  Interval3(Interval x, Interval y, Interval z) : at{x, y, z} {}
  Interval3(const glm::dvec3& v) : at{Interval(v.x), Interval(v.y), Interval(v.z)} {}  // NOLINT
};
inline Interval dot(const Interval3& a, const Interval3& b) {
  return a.at[0] * b.at[0] + a.at[1] * b.at[1] + a.at[2] * b.at[2];
}
inline Interval length_squared(const Interval3& a) {
  return square(a.at[0]) + square(a.at[1]) + square(a.at[2]);
}
inline Interval3 over(const Interval3& a, Interval b) { return {a.at[0] / b, a.at[1] / b, a.at[2] / b}; }

}  // namespace aluminate::test
