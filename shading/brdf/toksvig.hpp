// Specular anti-aliasing: what the length of an averaged normal says about the lobe's power. In: |na|, the
// length of the mean of unit normals, un-normalised, [0, 1]; power m. Out: Toksvig's factor ft, the filtered
// power m' = ft m, adjusted gloss. m' replaces m everywhere: exponent, normalisation and the a(m) of
// visibility [Hill11]. Lengths must come from float normals: 8 bits are far too coarse at a high power
// (254/255 at m = 8192 already gives ft = 0.030).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "shading/brdf/blinn_phong.hpp"
#include "shading/brdf/clamped.hpp"

namespace aluminate::brdf {

/// [Toksvig04] [Hill11] ft = |na| / (|na| + m (1 - |na|)), the factor by which the power falls, in [0, 1].
/// (The published slides print it as the power itself, which would then never exceed 1.) 1 at |na| = 1; 0 at
/// |na| = 0 for m > 0; |na| = 0 with m = 0 counts as 0. Lengths outside [0, 1], which quantised normals have,
/// are clamped.
[[nodiscard]] inline double toksvig_factor(double length, double m) noexcept {
  const double l = clamped(length);
  return l > 0.0 ? l / (l + m * (1.0 - l)) : 0.0;
}

/// [Hill11] m' = ft m, 0 <= m' <= m.
[[nodiscard]] inline double filtered_power(double length, double m) noexcept {
  return toksvig_factor(length, m) * m;
}

/// [Hill11] sigma^2 = (1 - |na|) / |na|, the variance of the slopes under the footprint; infinite at |na| =
/// 0.
[[nodiscard]] inline double normal_variance(double length) noexcept {
  const double l = clamped(length);
  return l > 0.0 ? (1.0 - l) / l : std::numeric_limits<double>::infinity();
}

/// [Hill11] m' = m / (1 + m sigma^2): filtered_power in terms of variance, so that variances of several
/// sources may be added.
[[nodiscard]] inline double filtered_power_from_variance(double variance, double m) noexcept {
  return std::isinf(variance) ? 0.0 : m / (1.0 + m * variance);
}

/// [McAuley12] Gloss with the filter applied: log2(ft m) / 13 = g + log2(ft) / 13, clamped to [0, 1]. The
/// clamp at 0 keeps m' >= 1, so a completely averaged normal (ft = 0) gives gloss 0. What the export writes
/// into the red channel.
[[nodiscard]] inline double filtered_gloss(double length, double gloss) noexcept {
  const double ft = toksvig_factor(length, power_from_gloss(gloss));
  return ft > 0.0 ? clamped(gloss + std::log2(ft) / kLog2MaxPower) : 0.0;
}

/// Power a stored factor was made for when one texture serves many materials; about 100 uses the 8 bits well
/// [Hill11].
inline constexpr double kFixedPower = 100.0;

/// [Hill11] Factor for power m from the factor for `fixed_m`: ft' = ft / lerp(m / fixed_m, 1, ft). An
/// identity, not an approximation; with m and fixed_m exchanged it is its own inverse. ft in [0, 1], fixed_m
/// > 0.
[[nodiscard]] inline double convert_toksvig_factor(double factor, double fixed_m, double m) noexcept {
  const double ratio = m / fixed_m;
  const double below = ratio + (1.0 - ratio) * factor;
  return below > 0.0 ? factor / below
                     : 1.0;  // below = 0: m = 0 and ft = 0, a constant lobe that no filter changes
}

/// |na| from a factor for power m > 0: |na| = ft m / (1 + ft (m - 1)), the inverse of toksvig_factor.
[[nodiscard]] inline double length_from_toksvig_factor(double factor, double m) noexcept {
  return factor * m / (1.0 - factor + factor * m);
}

/// [Fisher53] Mean length of unit vectors with a von Mises-Fisher distribution of concentration k >= 0: coth
/// k - 1/k. Below k = 0.02 the series k/3 - k^3/45 + 2 k^5/945 (next term < 3e-16) avoids the cancellation.
[[nodiscard]] inline double vmf_mean_length(double k) noexcept {
  if (k < 0.02) return k * (1.0 / 3.0 - k * k * (1.0 / 45.0 - k * k * (2.0 / 945.0)));
  return 1.0 / std::tanh(k) - 1.0 / k;
}

/// [Hill11] What filtering should do to such a distribution: convolving two Gaussians adds variances,
/// m' ~ 1 / (1/m + 1/k). Toksvig's m' agrees within 1 / k for large k, which is the check of the factor.
[[nodiscard]] inline double vmf_filtered_power(double k, double m) noexcept {
  return 1.0 / (1.0 / m + 1.0 / k);
}

/// Which mean a per-material Toksvig value is. They differ by up to 25 times on one normal map, so the choice
/// has a name.
enum class ToksvigMean : std::uint8_t { Factor, Gloss, Length, Harmonic };

struct ToksvigMeanName {
  ToksvigMean id;
  std::string_view name;
  std::string_view meaning;
};
inline constexpr std::array<ToksvigMeanName, 4> kToksvigMeans{{
    {ToksvigMean::Factor, "factor", "arithmetic mean of ft over texels (default)"},
    {ToksvigMean::Gloss, "gloss", "geometric mean of ft: mean of unclamped adjusted gloss"},
    {ToksvigMean::Length, "length", "ft of the mean length"},
    {ToksvigMean::Harmonic, "harmonic", "harmonic mean of ft: mean of variance"},
}};
[[nodiscard]] constexpr std::string_view to_string(ToksvigMean mean) noexcept {
  return kToksvigMeans[static_cast<std::size_t>(mean)].name;
}
[[nodiscard]] constexpr std::optional<ToksvigMean> parse_toksvig_mean(std::string_view name) noexcept {
  for (const ToksvigMeanName& row : kToksvigMeans)
    if (row.name == name) return row.id;
  return std::nullopt;
}

/// [McAuley12] One factor for a whole material, from the lengths of one filtered mip: the form that shipped.
/// No lengths: 1. Any length of 0 makes the gloss and harmonic means 0.
[[nodiscard]] inline double mean_toksvig_factor(std::span<const double> lengths, double m,
                                                ToksvigMean mean) noexcept {
  if (lengths.empty()) return 1.0;
  double sum = 0.0;
  for (const double length : lengths) {
    const double ft = toksvig_factor(length, m);
    switch (mean) {
      case ToksvigMean::Factor:
        sum += ft;
        break;
      case ToksvigMean::Gloss:
        sum += std::log2(ft);
        break;  // log2(0) = -inf, exp2(-inf) = 0
      case ToksvigMean::Length:
        sum += clamped(length);
        break;
      case ToksvigMean::Harmonic:
        sum += 1.0 / ft;
        break;  // 1/0 = inf, 1/inf = 0
    }
  }
  const double average = sum / static_cast<double>(lengths.size());
  switch (mean) {
    case ToksvigMean::Factor:
      return average;
    case ToksvigMean::Gloss:
      return std::exp2(average);
    case ToksvigMean::Length:
      return toksvig_factor(average, m);
    case ToksvigMean::Harmonic:
      return 1.0 / average;
  }
  return average;
}

}  // namespace aluminate::brdf
