#include "shading/report/toksvig_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "platform/host/text_table.hpp"
#include "shading/filter/dxt5_pack.hpp"

namespace aluminate::report {

std::string toksvig_text(const std::vector<filter::BakedLevel>& levels) {
  using host::Align;
  host::TextTable table({{"mip"},
                         {"texels", Align::Right},
                         {"mean length", Align::Right},
                         {"gloss", Align::Right},
                         {"filtered", Align::Right},
                         {"power", Align::Right},
                         {"factor", Align::Right},
                         {"gloss mean", Align::Right},
                         {"length mean", Align::Right},
                         {"harmonic", Align::Right}});
  for (const filter::BakeSummary& row : filter::summarize(levels)) {
    std::vector<std::string> cells{fmt::format("{}", row.level),
                                   fmt::format("{}x{}", row.width, row.height),
                                   fmt::format("{:.6f}", row.mean_length),
                                   fmt::format("{:.4f}", row.mean_gloss),
                                   fmt::format("{:.4f}", row.mean_filtered_gloss),
                                   fmt::format("{:.1f}", row.mean_filtered_power)};
    for (const double factor : row.material_factor) cells.push_back(fmt::format("{:.4f}", factor));
    table.add_row(std::move(cells));
  }
  host::TextTable errors({{"red channel of DXT5, rms error in 8-bit steps"},
                          {"gloss", Align::Right},
                          {"normal y", Align::Right},
                          {"normal x", Align::Right}});
  for (const filter::CrossTalkRow& row : filter::cross_talk(levels.front()))
    errors.add_row({std::string(row.content), fmt::format("{:.2f}", row.error.gloss),
                    fmt::format("{:.2f}", row.error.normal_y), fmt::format("{:.2f}", row.error.normal_x)});
  return table.text() + "\n" + errors.text();
}

host::Image8 toksvig_picture(const std::vector<filter::BakedLevel>& levels, bool dxt5) {
  const int width = levels.front().length.width, height = levels.front().length.height;
  const int right = levels.size() > 1 ? levels[1].length.width : 0;
  int below = 0;
  for (std::size_t i = 1; i < levels.size(); ++i) below += levels[i].length.height;
  host::Image8 picture{width + right, std::max(height, below), 4, {}};
  picture.texels.resize(4u * static_cast<std::size_t>(picture.width) *
                        static_cast<std::size_t>(picture.height));
  int top = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const int w = levels[i].length.width, h = levels[i].length.height;
    std::vector<std::uint8_t> rgba = filter::pack_texels(levels[i], levels[i].filtered_gloss);
    if (dxt5) rgba = filter::decode_dxt5(filter::encode_dxt5(rgba, w, h), w, h);
    const int left = i == 0 ? 0 : width;
    for (int y = 0; y < h; ++y)
      std::copy_n(rgba.begin() + 4 * y * w, 4 * w,
                  picture.texels.begin() + 4 * ((top + y) * picture.width + left));
    if (i > 0) top += h;
  }
  return picture;
}

}  // namespace aluminate::report
