// Mip chains. Each level is an exact box over the level above, so odd sizes weigh three texels instead of
// dropping one.
#include "shading/vm/texture.hpp"

#include <algorithm>

#include "platform/host/error.hpp"
#include "shading/vm/srgb.hpp"

namespace aluminate::vm {
namespace {

constexpr int kGreatestSize = 1 << 14;  // texel coordinates with 8 fraction bits stay below 2^23

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
  return {
      2 * i,
      3,
      {static_cast<std::uint64_t>(n - i), static_cast<std::uint64_t>(n), static_cast<std::uint64_t>(i + 1)},
      static_cast<std::uint64_t>(size)};
}

// Round half up.
std::uint64_t divide_rounded(std::uint64_t sum, std::uint64_t total) {
  return (2 * sum + total) / (2 * total);
}

// 8-bit sRGB code of every 16-bit linear value.
const std::vector<std::uint8_t>& srgb_codes() {
  static const std::vector<std::uint8_t> kCodes = [] {
    std::vector<std::uint8_t> codes(65536);
    for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = srgb_encode8(static_cast<double>(i) / 65535.0);
    return codes;
  }();
  return kCodes;
}

class Halver {
 public:
  Halver(const MipLevel& from, TextureShape shape, bool srgb)
      : from_(from),
        to_{std::max(1, from.width / 2), std::max(1, from.height / 2), from.slices},
        shape_(shape),
        srgb_(srgb) {
    if (shape == TextureShape::Volume) to_.slices = std::max(1, from.slices / 2);
  }

  MipLevel run() {
    if (from_.codes16.empty()) {
      to_.codes8.resize(to_.texel_count() * 4);
      if (shape_ != TextureShape::Volume && from_.width % 2 == 0 && from_.height % 2 == 0) {
        srgb_ ? halve_even<true>() : halve_even<false>();
      } else {
        halve(from_.codes8, to_.codes8);
      }
    } else {
      to_.codes16.resize(to_.texel_count() * 4);
      halve(from_.codes16, to_.codes16);
    }
    return std::move(to_);
  }

 private:
  // The usual case: four texels of equal weight.
  template <bool kSrgb>
  void halve_even() {
    const std::uint8_t* const encode = kSrgb ? srgb_codes().data() : nullptr;
    const std::size_t row = 4 * static_cast<std::size_t>(from_.width);
    const std::size_t target_row = row / 2;
    const auto rows = static_cast<std::size_t>(to_.height) * static_cast<std::size_t>(to_.slices);
    for (std::size_t y = 0; y < rows; ++y) {
      const std::uint8_t* const top = from_.codes8.data() + 2 * y * row;
      const std::uint8_t* const bottom = top + row;
      std::uint8_t* const to = to_.codes8.data() + y * target_row;
      for (std::size_t x = 0; x < target_row; x += 4)
        for (std::size_t c = 0; c < 4; ++c) {
          const std::size_t i = 2 * x + c;
          if (kSrgb && c < 3) {
            const std::uint32_t sum = std::uint32_t{srgb_decode16(top[i])} + srgb_decode16(top[i + 4]) +
                                      srgb_decode16(bottom[i]) + srgb_decode16(bottom[i + 4]);
            to[x + c] = encode[(sum + 2) / 4];
          } else {
            to[x + c] = static_cast<std::uint8_t>((top[i] + top[i + 4] + bottom[i] + bottom[i + 4] + 2) / 4);
          }
        }
    }
  }

  template <class Codes>
  void halve(const Codes& from, Codes& to) {
    std::size_t out = 0;
    for (int z = 0; z < to_.slices; ++z) {
      const BoxTap slices =
          shape_ == TextureShape::Volume ? box_tap(from_.slices, z) : BoxTap{z, 1, {1, 0, 0}, 1};
      for (int y = 0; y < to_.height; ++y) {
        const BoxTap rows = box_tap(from_.height, y);
        for (int x = 0; x < to_.width; ++x)
          for (std::size_t c = 0; c < 4; ++c)
            to[out++] =
                static_cast<typename Codes::value_type>(mean(from, slices, rows, box_tap(from_.width, x), c));
      }
    }
  }

  template <class Codes>
  std::uint64_t mean(const Codes& from, const BoxTap& slices, const BoxTap& rows, const BoxTap& columns,
                     std::size_t channel) {
    const bool encoded = srgb_ && channel < 3;
    std::uint64_t sum = 0;  // <= 65535 * 2^14 * 2^14 * 2^14 < 2^58
    for (int k = 0; k < slices.taps; ++k)
      for (int j = 0; j < rows.taps; ++j)
        for (int i = 0; i < columns.taps; ++i) {
          const auto slice = static_cast<std::size_t>(slices.first + k),
                     row = static_cast<std::size_t>(rows.first + j);
          const std::size_t texel =
              (slice * static_cast<std::size_t>(from_.height) + row) * static_cast<std::size_t>(from_.width) +
              static_cast<std::size_t>(columns.first + i);
          const std::uint64_t code = from[4 * texel + channel];
          sum += slices.weight[static_cast<std::size_t>(k)] * rows.weight[static_cast<std::size_t>(j)] *
                 columns.weight[static_cast<std::size_t>(i)] *
                 (encoded ? std::uint64_t{srgb_decode16(static_cast<std::uint8_t>(code))} : code);
        }
    const std::uint64_t average = divide_rounded(sum, slices.total * rows.total * columns.total);
    return encoded ? srgb_codes()[average] : average;
  }

  const MipLevel& from_;
  MipLevel to_;
  TextureShape shape_;
  bool srgb_;
};

void check_level(TextureShape shape, const MipLevel& level, bool srgb) {
  ALU_CHECK(level.width > 0 && level.height > 0 && level.slices > 0 && level.width <= kGreatestSize &&
                level.height <= kGreatestSize && level.slices <= kGreatestSize,
            "texture of {} x {} x {}", level.width, level.height, level.slices);
  ALU_CHECK(shape != TextureShape::Flat || level.slices == 1, "flat texture of {} slices", level.slices);
  ALU_CHECK(shape != TextureShape::Cube || (level.slices == 6 && level.width == level.height),
            "cube of {} faces of {} x {}", level.slices, level.width, level.height);
  const std::size_t codes = level.codes16.empty() ? level.codes8.size() : level.codes16.size();
  ALU_CHECK(codes == level.texel_count() * 4 && (level.codes8.empty() || level.codes16.empty()),
            "{} codes for {} texels", codes, level.texel_count());
  ALU_CHECK(!srgb || level.codes16.empty(), "sRGB with {} 16-bit codes", level.codes16.size());
}

bool can_halve(TextureShape shape, const MipLevel& level) {
  return level.width > 1 || level.height > 1 || (shape == TextureShape::Volume && level.slices > 1);
}

}  // namespace

std::uint16_t Texture::linear16(std::size_t level, std::size_t texel, std::size_t channel) const {
  const MipLevel& mip = levels_[level];
  if (!mip.codes16.empty()) return mip.codes16[4 * texel + channel];
  const std::uint8_t code = mip.codes8[4 * texel + channel];
  return srgb_ && channel < 3 ? srgb_decode16(code) : static_cast<std::uint16_t>(code * 257);
}

void Texture::make_filter_texels() {
  if (!srgb_ && levels_.front().codes16.empty()) return;
  // The two encodings of a channel, code by code.
  std::array<std::uint64_t, 256> plain{}, encoded{};
  for (std::size_t code = 0; code < 256; ++code) {
    plain[code] = (code * 257) ^ 0x8000;
    encoded[code] = std::uint64_t{srgb_decode16(static_cast<std::uint8_t>(code))} ^ 0x8000;
  }
  std::size_t total = 0;
  for (const MipLevel& level : levels_) total += level.texel_count();
  texels_.resize(total);
  texels_begin_.clear();
  std::uint64_t* to = texels_.data();
  for (const MipLevel& level : levels_) {
    texels_begin_.push_back(static_cast<std::size_t>(to - texels_.data()));
    const std::size_t count = level.texel_count();
    if (level.codes16.empty()) {
      const std::uint8_t* from = level.codes8.data();
      for (std::size_t i = 0; i < count; ++i, from += 4)
        *to++ = encoded[from[0]] | encoded[from[1]] << 16 | encoded[from[2]] << 32 | plain[from[3]] << 48;
    } else {
      const std::uint16_t* from = level.codes16.data();
      const auto word = [](std::uint16_t value) { return std::uint64_t{value} ^ 0x8000; };
      for (std::size_t i = 0; i < count; ++i, from += 4)
        *to++ = word(from[0]) | word(from[1]) << 16 | word(from[2]) << 32 | word(from[3]) << 48;
    }
  }
}

Texture Texture::from_rgba8(int width, int height, std::span<const std::uint8_t> rgba, bool srgb,
                            bool mipmapped) {
  return from_level(TextureShape::Flat, {width, height, 1, {rgba.begin(), rgba.end()}}, srgb, mipmapped);
}

Texture Texture::from_level(TextureShape shape, MipLevel level, bool srgb, bool mipmapped) {
  check_level(shape, level, srgb);
  std::vector<MipLevel> levels;
  levels.push_back(std::move(level));
  while (mipmapped && can_halve(shape, levels.back()))
    levels.push_back(Halver(levels.back(), shape, srgb).run());
  return from_levels(shape, std::move(levels), srgb);
}

Texture Texture::from_levels(TextureShape shape, std::vector<MipLevel> levels, bool srgb) {
  ALU_CHECK(!levels.empty(), "{} levels", levels.size());
  for (std::size_t i = 0; i < levels.size(); ++i) {
    check_level(shape, levels[i], srgb);
    if (i == 0) continue;
    const MipLevel &above = levels[i - 1], &level = levels[i];
    const int slices = shape == TextureShape::Volume ? std::max(1, above.slices / 2) : above.slices;
    ALU_CHECK(level.width == std::max(1, above.width / 2) && level.height == std::max(1, above.height / 2) &&
                  level.slices == slices && level.codes16.empty() == above.codes16.empty(),
              "level {} of {} x {} x {}", i, level.width, level.height, level.slices);
  }
  Texture texture;
  texture.shape_ = shape;
  texture.srgb_ = srgb;
  texture.levels_ = std::move(levels);
  texture.make_filter_texels();
  return texture;
}

Texture Texture::render_target(int width, int height) {
  MipLevel level{width, height, 1, {}, {}};
  level.codes16.resize(level.texel_count() * 4);
  return from_level(TextureShape::Flat, std::move(level), false, false);
}

void Texture::set_texel(std::size_t texel, std::uint64_t rgba) noexcept {
  for (std::size_t c = 0; c < 4; ++c)
    levels_[0].codes16[4 * texel + c] = static_cast<std::uint16_t>(rgba >> 16 * c);
  texels_[texel] = rgba ^ 0x8000800080008000u;  // see filter_texels()
}

}  // namespace aluminate::vm
