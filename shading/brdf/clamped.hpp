// The clamped dot product of the sources (underlined there): every cosine enters a term in [0, 1].
// In: any double, also NaN. Out: [0, 1], never NaN, so that no reference value can be NaN for a finite
// material.
#pragma once

namespace aluminate::brdf {

/// min(max(x, 0), 1); NaN gives 0, as the comparison is false. Terms call it on entry, callers need not.
[[nodiscard]] constexpr double clamped(double x) noexcept { return x > 0.0 ? (x < 1.0 ? x : 1.0) : 0.0; }

}  // namespace aluminate::brdf
