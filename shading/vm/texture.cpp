// Mip chains. Each level is an exact box over the level above, so odd sizes weigh three texels instead of dropping one.
#include "shading/vm/texture.hpp"

#include <algorithm>
#include <array>

#include "platform/host/error.hpp"
#include "shading/vm/srgb.hpp"

namespace aluminate::vm {
namespace {

// One axis of the box: target texel i of n covers [i*size/n, (i+1)*size/n) of the source, n = max(1, size/2).
// size = 2n: two texels of weight 1. size = 2n+1: texels 2i, 2i+1, 2i+2 with weights n-i, n, i+1 (of 2n+1).
struct BoxTap {
  int first = 0, taps = 0;
  std::array<std::uint64_t, 3> weight{};
  std::uint64_t total = 0;
};

BoxTap box_tap(int size, int i) {
  if (size == 1) return {0, 1, {1, 0, 0}, 1};
  const int n = size / 2;
  if (size % 2 == 0) return {2 * i, 2, {1, 1, 0}, 2};
  return {2 * i, 3, {static_cast<std::uint64_t>(n - i), static_cast<std::uint64_t>(n), static_cast<std::uint64_t>(i + 1)},
          static_cast<std::uint64_t>(size)};
}

// Round half up.
std::uint64_t divide_rounded(std::uint64_t sum, std::uint64_t total) { return (2 * sum + total) / (2 * total); }

MipLevel halve(const MipLevel& from, bool srgb) {
  MipLevel to{std::max(1, from.width / 2), std::max(1, from.height / 2), {}};
  to.rgba.resize(static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height) * 4);
  std::size_t out = 0;
  for (int y = 0; y < to.height; ++y) {
    const BoxTap rows = box_tap(from.height, y);
    for (int x = 0; x < to.width; ++x) {
      const BoxTap columns = box_tap(from.width, x);
      std::array<std::uint64_t, 4> sum{};  // <= 65535 * 2^15 * 2^15 < 2^46
      for (int j = 0; j < rows.taps; ++j)
        for (int i = 0; i < columns.taps; ++i) {
          const std::size_t texel = static_cast<std::size_t>(rows.first + j) * static_cast<std::size_t>(from.width) +
                                    static_cast<std::size_t>(columns.first + i);
          const std::uint64_t weight = rows.weight[static_cast<std::size_t>(j)] * columns.weight[static_cast<std::size_t>(i)];
          for (std::size_t c = 0; c < 4; ++c) {
            const std::uint8_t code = from.rgba[4 * texel + c];
            sum[c] += weight * (srgb && c < 3 ? srgb_decode16(code) : code);
          }
        }
      const std::uint64_t total = rows.total * columns.total;
      for (std::size_t c = 0; c < 4; ++c) {
        const std::uint64_t mean = divide_rounded(sum[c], total);
        to.rgba[out++] = srgb && c < 3 ? srgb_encode8(static_cast<double>(mean) / 65535.0) : static_cast<std::uint8_t>(mean);
      }
    }
  }
  return to;
}

}  // namespace

Texture Texture::from_rgba8(int width, int height, std::span<const std::uint8_t> rgba, bool srgb, bool mipmapped) {
  constexpr int kGreatestSize = 1 << 14;  // texel coordinates with 8 fraction bits stay below 2^23
  ALU_CHECK(width > 0 && height > 0 && width <= kGreatestSize && height <= kGreatestSize, "texture of {} x {}", width, height);
  ALU_CHECK(rgba.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4, "{} bytes for {} x {}",
            rgba.size(), width, height);
  Texture texture;
  texture.srgb_ = srgb;
  texture.levels_.push_back({width, height, {rgba.begin(), rgba.end()}});
  while (mipmapped && (texture.levels_.back().width > 1 || texture.levels_.back().height > 1))
    texture.levels_.push_back(halve(texture.levels_.back(), srgb));
  for (const MipLevel& level : texture.levels_) {
    texture.linear_begin_.push_back(texture.linear_.size());
    for (std::size_t i = 0; i < level.rgba.size(); i += 4) {
      std::uint64_t texel = 0;
      for (std::size_t c = 0; c < 4; ++c) {
        const std::uint8_t code = level.rgba[i + c];
        const std::uint64_t linear = srgb && c < 3 ? srgb_decode16(code) : std::uint64_t{code} * 257;
        texel |= linear << (16 * c);
      }
      texture.linear_.push_back(texel);
    }
  }
  return texture;
}

}  // namespace aluminate::vm
