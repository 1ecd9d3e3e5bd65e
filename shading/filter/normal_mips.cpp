#include "shading/filter/normal_mips.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "platform/host/error.hpp"

namespace aluminate::filter {
namespace {

void check_shape(const Rgba8View& map) {
  if (map.width < 1 || map.height < 1)
    throw UserError(fmt::format("normal map of {}x{} texels, expected at least 1x1", map.width, map.height));
  const auto expected = static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height) * 4;
  ALU_CHECK(map.pixels.size() == expected, "{} bytes for {}x{}", map.pixels.size(), map.width, map.height);
}

/// Texels of one axis that one output texel covers, with their share; shares add up to 1.
struct Cover {
  int first = 0;
  std::vector<double> shares;
};

std::vector<Cover> covers(int size, int half) {
  std::vector<Cover> result(static_cast<std::size_t>(half));
  for (int i = 0; i < half; ++i) {
    // In units of 1 / half of a texel everything is an integer: output i spans [i size, (i + 1) size), texel
    // j [j half, ...).
    const int from = i * size, to = (i + 1) * size;
    Cover& cover = result[static_cast<std::size_t>(i)];
    cover.first = from / half;
    for (int j = cover.first; j * half < to; ++j)
      cover.shares.push_back(static_cast<double>(std::min(to, (j + 1) * half) - std::max(from, j * half)) /
                             size);
  }
  return result;
}

template <class Value>
Level<Value> halve_any(const Level<Value>& level) {
  Level<Value> out;
  out.width = std::max(1, level.width / 2);
  out.height = std::max(1, level.height / 2);
  out.texels.reserve(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
  const std::vector<Cover> columns = covers(level.width, out.width), rows = covers(level.height, out.height);
  for (const Cover& row : rows)
    for (const Cover& column : columns) {
      Value sum(0.0);
      for (std::size_t j = 0; j < row.shares.size(); ++j)
        for (std::size_t i = 0; i < column.shares.size(); ++i)
          sum += level.at(column.first + static_cast<int>(i), row.first + static_cast<int>(j)) *
                 (row.shares[j] * column.shares[i]);
      out.texels.push_back(sum);
    }
  return out;
}

template <class Value>
std::vector<Level<Value>> chain_of(Level<Value> base) {
  std::vector<Level<Value>> levels;
  levels.push_back(std::move(base));
  while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(halve_any(levels.back()));
  return levels;
}

}  // namespace

glm::dvec3 decode_normal(std::uint8_t r, std::uint8_t g, std::uint8_t b) noexcept {
  // 2 t - 255 is odd, never 0: every texel has a direction. An all-zero texel is what tools write for "no
  // normal".
  if (r == 0 && g == 0 && b == 0) return {0, 0, 1};
  return glm::normalize(glm::dvec3(2.0 * r - 255.0, 2.0 * g - 255.0, 2.0 * b - 255.0));
}

NormalLevel decode_normal_map(const Rgba8View& map) {
  check_shape(map);
  NormalLevel level{map.width, map.height, {}};
  level.texels.reserve(map.pixels.size() / 4);
  for (std::size_t i = 0; i < map.pixels.size(); i += 4)
    level.texels.push_back(decode_normal(map.pixels[i], map.pixels[i + 1], map.pixels[i + 2]));
  return level;
}

ScalarLevel decode_channel(const Rgba8View& map, int channel) {
  check_shape(map);
  ALU_CHECK(channel >= 0 && channel < 4, "channel {}", channel);
  ScalarLevel level{map.width, map.height, {}};
  level.texels.reserve(map.pixels.size() / 4);
  for (std::size_t i = static_cast<std::size_t>(channel); i < map.pixels.size(); i += 4)
    level.texels.push_back(map.pixels[i] / 255.0);
  return level;
}

NormalLevel halve(const NormalLevel& level) { return halve_any(level); }
ScalarLevel halve(const ScalarLevel& level) { return halve_any(level); }
std::vector<NormalLevel> mip_chain(NormalLevel base) { return chain_of(std::move(base)); }
std::vector<ScalarLevel> mip_chain(ScalarLevel base) { return chain_of(std::move(base)); }

NormalLevel gaussian(const NormalLevel& level, double sigma) {
  if (!(sigma > 0.0)) return level;
  const int radius = static_cast<int>(std::ceil(3.0 * sigma));
  std::vector<double> kernel;
  double total = 0.0;
  for (int i = -radius; i <= radius; ++i) kernel.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
  for (const double weight : kernel) total += weight;
  const auto wrapped = [](int i, int size) { return ((i % size) + size) % size; };

  const auto pass = [&](const NormalLevel& in, int step_x, int step_y) {
    NormalLevel out{in.width, in.height, {}};
    out.texels.reserve(in.texels.size());
    for (int y = 0; y < in.height; ++y)
      for (int x = 0; x < in.width; ++x) {
        glm::dvec3 sum(0.0);
        for (int i = -radius; i <= radius; ++i)
          sum += in.at(wrapped(x + i * step_x, in.width), wrapped(y + i * step_y, in.height)) *
                 kernel[static_cast<std::size_t>(i + radius)];
        out.texels.push_back(sum / total);
      }
    return out;
  };
  return pass(pass(level, 1, 0), 0, 1);
}

}  // namespace aluminate::filter
