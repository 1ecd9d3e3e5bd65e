// Textures as the texture unit sees them: flat, cube or volume, unorm8 RGBA or unorm16, with a mip chain. The
// filter works on 16-bit linear integers (sRGB is decoded before filtering), so the result of a fetch is
// exact and the same everywhere.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace aluminate::vm {

enum class Address : std::uint8_t { Wrap, Clamp, Mirror };
enum class Filter : std::uint8_t { Point, Linear };

struct SamplerState {
  Address u = Address::Wrap, v = Address::Wrap;  // cube maps: faces always end at their edge
  Filter magnify = Filter::Linear, minify = Filter::Linear;
  Filter mip = Filter::Linear;
  bool mipmapped = true;
  Address w = Address::Wrap;  // volumes
  int max_anisotropy = 1;     // 1 .. kMostProbes; flat textures whose minification filter is linear
};

/// Most samples along the longer axis of a pixel's footprint.
inline constexpr int kMostProbes = 16;

enum class TextureShape : std::uint8_t { Flat, Cube, Volume };

/// Codes of one level, row-major, 4 channels a texel, row 0 first (v = 0), slice after slice: one slice if
/// flat, six faces +x -x +y -y +z -z, or the depth of a volume. Either codes8 or codes16 is filled, the same
/// one in all levels.
struct MipLevel {
  int width = 0, height = 0, slices = 1;
  std::vector<std::uint8_t> codes8{};
  std::vector<std::uint16_t> codes16{};

  std::size_t texel_count() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
           static_cast<std::size_t>(slices);
  }
};

class Texture {
 public:
  /// rgba: width*height*4 bytes. Mips are averaged in linear light (2x2 box; odd sizes use the exact box
  /// weights) and stored back in the texture's own encoding.
  static Texture from_rgba8(int width, int height, std::span<const std::uint8_t> rgba, bool srgb,
                            bool mipmapped);
  /// One level of any shape; mipmapped: the others are boxes over it. Cube: square, 6 slices. srgb: codes8
  /// only. At most 2^14 texels along an axis.
  static Texture from_level(TextureShape shape, MipLevel level, bool srgb, bool mipmapped);
  /// A whole chain made elsewhere (filtered normals, prefiltered reflections): each level half the one
  /// before, rounded down.
  static Texture from_levels(TextureShape shape, std::vector<MipLevel> levels, bool srgb);

  /// A surface drawn into and read back: flat, one level of 16-bit linear channels, zero until set_texel()
  /// writes them.
  static Texture render_target(int width, int height);
  /// texel: index in level 0; rgba: four 16-bit channels, R in the low bits. Different texels may be written
  /// by different threads.
  void set_texel(std::size_t texel, std::uint64_t rgba) noexcept;

  TextureShape shape() const { return shape_; }
  bool srgb() const { return srgb_; }
  const std::vector<MipLevel>& levels() const { return levels_; }

  /// 16-bit linear value of a channel of a texel; texel = index in the level.
  std::uint16_t linear16(std::size_t level, std::size_t texel, std::size_t channel) const;

  /// What the fast filter reads of sRGB and 16-bit textures: per texel of a level four 16-bit channels, R in
  /// the low bits, each linear16 - 32768 as a signed number, so that a pair can be weighed by one signed
  /// multiply-add. Made at load, 8 bytes a texel. Other textures are read as their 8-bit codes and have none.
  const std::uint64_t* filter_texels(std::size_t level) const {
    return texels_.data() + texels_begin_[level];
  }
  bool has_filter_texels() const { return !texels_.empty(); }

 private:
  void make_filter_texels();

  TextureShape shape_ = TextureShape::Flat;
  bool srgb_ = false;
  std::vector<MipLevel> levels_;
  std::vector<std::uint64_t> texels_;  // all levels, one after the other
  std::vector<std::size_t> texels_begin_;
};

/// What a sampler register is bound to for one draw.
struct SamplerBinding {
  const Texture* texture = nullptr;  // nullptr: fetches give (0, 0, 0, 1)
  SamplerState state{};
};

}  // namespace aluminate::vm
