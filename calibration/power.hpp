// Powers of many numbers at once: a tone curve over a photograph is 72 million of them.
#pragma once

#include <cstddef>

namespace aluminate::calibration {

/// values[i] = sign(x) |x|^exponent for each finite x. Relative error below 1e-13 where |exponent log2 |x|| <= 100; beyond
/// 1000 it stays at 2^+-1000. The same bits on every vector unit: additions, multiplications and divisions of binary64 only.
void raise_to(double exponent, double* values, std::size_t count) noexcept;

}  // namespace aluminate::calibration
