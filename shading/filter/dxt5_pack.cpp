#include "shading/filter/dxt5_pack.hpp"

#include <squish.h>

#include <cmath>
#include <numbers>

#include "platform/host/error.hpp"

namespace aluminate::filter {
namespace {

std::uint8_t unorm8(double value) {
  return static_cast<std::uint8_t>(std::floor(brdf::clamped(value) * 255.0 + 0.5));
}

/// splitmix64, so that the noise is the same everywhere.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

template <class Content>
ScalarLevel gloss_of(const BakedLevel& level, const Content& content) {
  ScalarLevel gloss{level.length.width, level.length.height, {}};
  for (int y = 0; y < gloss.height; ++y)
    for (int x = 0; x < gloss.width; ++x) gloss.texels.push_back(content(x, y));
  return gloss;
}

}  // namespace

std::vector<std::uint8_t> pack_texels(const BakedLevel& level, const ScalarLevel& gloss) {
  ALU_CHECK(gloss.texels.size() == level.normal.texels.size(), "{} gloss texels, {} normals",
            gloss.texels.size(), level.normal.texels.size());
  std::vector<std::uint8_t> rgba;
  rgba.reserve(gloss.texels.size() * 4);
  for (std::size_t i = 0; i < gloss.texels.size(); ++i) {
    const glm::dvec3& mean = level.normal.texels[i];
    const double length = glm::length(mean);
    const glm::dvec3 n = length > 0.0 ? mean / length : glm::dvec3(0, 0, 1);
    rgba.insert(rgba.end(),
                {unorm8(gloss.texels[i]), unorm8(0.5 * n.y + 0.5), std::uint8_t{0}, unorm8(0.5 * n.x + 0.5)});
  }
  return rgba;
}

std::vector<std::uint8_t> encode_dxt5(const std::vector<std::uint8_t>& rgba, int width, int height,
                                      ChannelWeights weights) {
  ALU_CHECK(rgba.size() == 4u * static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
            "{} bytes for {}x{}", rgba.size(), width, height);
  constexpr int kFlags =
      squish::kDxt5 | squish::kColourIterativeClusterFit;  // never weighted by alpha: alpha is a normal
  std::vector<std::uint8_t> blocks(
      static_cast<std::size_t>(squish::GetStorageRequirements(width, height, kFlags)));
  squish::CompressImage(rgba.data(), width, height, blocks.data(), kFlags, weights.data());
  return blocks;
}

std::vector<std::uint8_t> decode_dxt5(const std::vector<std::uint8_t>& blocks, int width, int height) {
  ALU_CHECK(
      blocks.size() == static_cast<std::size_t>(squish::GetStorageRequirements(width, height, squish::kDxt5)),
      "{} bytes of blocks for {}x{}", blocks.size(), width, height);
  std::vector<std::uint8_t> rgba(4u * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  squish::DecompressImage(rgba.data(), width, height, blocks.data(), squish::kDxt5);
  return rgba;
}

PackError pack_error(const std::vector<std::uint8_t>& packed, const std::vector<std::uint8_t>& decoded) {
  ALU_CHECK(packed.size() == decoded.size() && !packed.empty(), "{} and {} bytes", packed.size(),
            decoded.size());
  std::array<double, 4> squares{};
  for (std::size_t i = 0; i < packed.size(); ++i) {
    const double difference = static_cast<double>(packed[i]) - static_cast<double>(decoded[i]);
    squares[i % 4] += difference * difference;
  }
  const auto rms = [&](std::size_t channel) {
    return std::sqrt(squares[channel] / (static_cast<double>(packed.size()) / 4.0));
  };
  return {rms(0), rms(1), rms(3)};
}

std::vector<CrossTalkRow> cross_talk(const BakedLevel& level, ChannelWeights weights) {
  const int width = level.length.width, height = level.length.height;
  const auto wave = [](double x, double texels) { return std::sin(2.0 * std::numbers::pi * x / texels); };
  const std::pair<std::string_view, ScalarLevel> contents[] = {
      {"none", gloss_of(level, [](int, int) { return 0.0; })},
      {"smooth", gloss_of(level, [&](int x, int y) { return 0.6 + 0.2 * wave(x, width) * wave(y, height); })},
      {"filtered", level.filtered_gloss},
      {"detailed", gloss_of(level,
                            [&](int x, int y) {
                              return 0.5 + 0.2 * wave(x + 0.37 * y, 5.3) + 0.15 * wave(y - 0.21 * x, 3.7);
                            })},
      {"noise", gloss_of(level,
                         [&](int x, int y) {
                           const auto index =
                               static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(width) +
                               static_cast<std::uint64_t>(x);
                           return static_cast<double>(mixed(index) >> 56) / 255.0;
                         })},
  };
  std::vector<CrossTalkRow> rows;
  for (const auto& [name, gloss] : contents) {
    const std::vector<std::uint8_t> packed = pack_texels(level, gloss);
    rows.push_back(
        {name, pack_error(packed, decode_dxt5(encode_dxt5(packed, width, height, weights), width, height))});
  }
  return rows;
}

}  // namespace aluminate::filter
