#include "shading/report/cubemap_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "platform/host/text_table.hpp"

namespace aluminate::report {

std::string cubemap_text(const std::vector<filter::CubeLevel>& chain) {
  using host::Align;
  host::TextTable table({{"mip"},
                         {"faces", Align::Right},
                         {"power", Align::Right},
                         {"gloss", Align::Right},
                         {"mean R", Align::Right},
                         {"G", Align::Right},
                         {"B", Align::Right},
                         {"greatest", Align::Right},
                         {"sky", Align::Right}});
  for (std::size_t k = 0; k < chain.size(); ++k) {
    const filter::CubeLevel& level = chain[k];
    glm::dvec4 sum(0.0);
    double solid_angle = 0, greatest = 0;
    for (int face = 0; face < 6; ++face)
      for (int y = 0; y < level.size; ++y)
        for (int x = 0; x < level.size; ++x) {
          const glm::dvec4& texel = level.texels[level.index(face, x, y)];
          const double weight = filter::cube_solid_angle(x, y, level.size);
          sum += texel * weight;
          solid_angle += weight;
          greatest = std::max({greatest, texel.x, texel.y, texel.z});
        }
    sum /= solid_angle;
    const double power = filter::cube_level_power(static_cast<int>(k), chain.front().size);
    table.add_row({fmt::format("{}", k), fmt::format("6 x {0}x{0}", level.size),
                   k == 0 ? "as captured" : fmt::format("{:.0f}", power),
                   fmt::format("{:.3f}", std::log2(power) / 13), fmt::format("{:.4f}", sum.x),
                   fmt::format("{:.4f}", sum.y), fmt::format("{:.4f}", sum.z),
                   fmt::format("{:.3f}", greatest), fmt::format("{:.1f} %", 100 * sum.w)});
  }
  return table.text();
}

}  // namespace aluminate::report
