// Textures as the texture unit sees them. Texels are unorm8 RGBA with a box-filtered mip chain; the filter works on
// 16-bit linear integers (sRGB is decoded before filtering), so the result of a fetch is exact and the same everywhere.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace aluminate::vm {

enum class Address : std::uint8_t { Wrap, Clamp, Mirror };
enum class Filter : std::uint8_t { Point, Linear };

struct SamplerState {
  Address u = Address::Wrap, v = Address::Wrap;
  Filter magnify = Filter::Linear, minify = Filter::Linear;
  Filter mip = Filter::Linear;
  bool mipmapped = true;
};

struct MipLevel {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;   // row-major, 4 bytes a texel, row 0 first (v = 0)
};

class Texture {
 public:
  /// rgba: width*height*4 bytes. Mips are averaged in linear light (2x2 box; odd sizes use the exact box weights) and
  /// stored back in the texture's own encoding.
  static Texture from_rgba8(int width, int height, std::span<const std::uint8_t> rgba, bool srgb, bool mipmapped);

  bool srgb() const { return srgb_; }
  const std::vector<MipLevel>& levels() const { return levels_; }

  /// What the filter reads: per texel of a level, row-major, four 16-bit linear channels, R in the low bits. Made at load
  /// so that sRGB costs nothing per fetch; 8 bytes a texel.
  const std::uint64_t* linear_texels(std::size_t level) const { return linear_.data() + linear_begin_[level]; }

 private:
  bool srgb_ = false;
  std::vector<MipLevel> levels_;
  std::vector<std::uint64_t> linear_;        // all levels, one after the other
  std::vector<std::size_t> linear_begin_;
};

/// What a sampler register is bound to for one draw.
struct SamplerBinding {
  const Texture* texture = nullptr;  // nullptr: fetches give (0, 0, 0, 1)
  SamplerState state{};
};

}  // namespace aluminate::vm
