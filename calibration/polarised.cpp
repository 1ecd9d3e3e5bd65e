#include "calibration/polarised.hpp"

#include <algorithm>
#include <utility>

#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::calibration {

Separated separate_polarised(Photo cross, Photo parallel, double leakage) {
  if (cross.width != parallel.width || cross.height != parallel.height) {
    throw UserError(fmt::format("the crossed photograph has {} x {} px, the parallel one {} x {}",
                                cross.width, cross.height, parallel.width, parallel.height),
                    "take both from a tripod with the same camera");
  }
  if (!(leakage >= 0.0 && leakage < 0.5))
    throw UserError(fmt::format("a leakage of {} is outside of 0 .. 0.5", leakage));
  // Each result takes the memory of one photograph.
  Separated result;
  auto crossed = std::exchange(cross.rgb_lin, {});
  result.specular = cross;
  result.specular.rgb_lin = std::move(parallel.rgb_lin);
  result.diffuse = std::move(cross);
  result.diffuse.rgb_lin = std::move(crossed);
  const std::size_t row = 3 * static_cast<std::size_t>(parallel.width);
  host::parallel_for(
      parallel.height,
      [&](std::int64_t y) {
        for (std::size_t i = static_cast<std::size_t>(y) * row; i < (static_cast<std::size_t>(y) + 1) * row;
             ++i) {
          const double c = static_cast<double>(result.diffuse.rgb_lin[i]),
                       p = static_cast<double>(result.specular.rgb_lin[i]);
          const double specular = (p - c) / (1.0 - 2.0 * leakage);
          result.diffuse.rgb_lin[i] = static_cast<float>(2.0 * (c - leakage * specular));
          result.specular.rgb_lin[i] = static_cast<float>(std::max(specular, 0.0));
        }
      },
      16);
  for (std::size_t c = 0; c < 3; ++c) {  // D = 2 c: limits move along
    result.diffuse.clip_high[c] *= 2.0;
    result.specular.clip_high[c] = std::min(result.specular.clip_high[c], parallel.clip_high[c]);
  }
  return result;
}

}  // namespace aluminate::calibration
