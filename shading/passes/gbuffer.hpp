// The G-buffer as memory: colours and depth rounded exactly as 32-bit render targets store them, and readable
// as textures. In: what gbuffer_fill.hlsl wrote, depth of the tile stage. Out: texels. Layout:
// shading/programs/gbuffer.hlsl.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "shading/vm/texture.hpp"
#include "shading/vm/texture_unit.hpp"

namespace aluminate::passes {

/// RGBA8, rgb through the sRGB curve, alpha linear; halves round up. Channels are clamped to [0, 1]. Returns
/// what a fetch sees: four 16-bit linear channels, R in the low bits.
std::uint64_t srgb8_texel(const std::array<double, 4>& rgba) noexcept;
/// 10 bits a channel, widened to 16 by repeating the high bits: q / 1023 within 2^-16. The two alpha bits are
/// 0.
std::uint64_t rgb10_texel(const std::array<double, 4>& rgba) noexcept;
/// The three bytes of D24, the highest in red.
std::uint64_t depth24_texel(std::uint32_t depth_d24) noexcept;

class GBuffer {
 public:
  static constexpr std::size_t kColorTargets = 4;

  GBuffer() = default;
  /// targets: 3 or 4; 0: nothing is allocated.
  GBuffer(int width, int height, int targets);

  int targets() const { return targets_; }
  /// Threads may store different pixels at the same time. color(target, channel): what the shader wrote.
  template <class Color>
  void store(std::size_t pixel, const Color& color) {
    for (std::size_t t = 0; t < static_cast<std::size_t>(targets_); ++t) {
      const std::array<double, 4> rgba{color(t, 0), color(t, 1), color(t, 2), color(t, 3)};
      color_[t].set_texel(pixel, t == kNormalTarget ? rgb10_texel(rgba) : srgb8_texel(rgba));
    }
  }
  void store_depth(std::size_t pixel, std::uint32_t depth_d24) {
    depth_.set_texel(pixel, depth24_texel(depth_d24));
  }

  const vm::Texture& color(std::size_t target) const { return color_[target]; }
  /// Point sampled. A name that is no G-buffer sampler: an empty binding.
  vm::SamplerBinding binding(std::string_view sampler) const;

 private:
  static constexpr std::size_t kNormalTarget = 1;
  int targets_ = 0;
  std::array<vm::Texture, kColorTargets> color_;
  vm::Texture depth_;
};

}  // namespace aluminate::passes
