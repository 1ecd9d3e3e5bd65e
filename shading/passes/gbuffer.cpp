#include "shading/passes/gbuffer.hpp"

#include "shading/passes/textures.hpp"
#include "shading/vm/srgb.hpp"

namespace aluminate::passes {
namespace {

// round(v * greatest), halves up; NaN counts as 0.
std::uint64_t unorm(double v, int greatest) noexcept {
  const double clamped = v > 0.0 ? (v < 1.0 ? v : 1.0) : 0.0;
  return static_cast<std::uint64_t>(clamped * greatest + 0.5);
}

}  // namespace

std::uint64_t srgb8_texel(const std::array<double, 4>& rgba) noexcept {
  std::uint64_t texel = unorm(rgba[3], 255) * 257 << 48;
  for (std::size_t c = 0; c < 3; ++c)
    texel |= std::uint64_t{vm::srgb_decode16(vm::srgb_encode8(rgba[c]))} << 16 * c;
  return texel;
}

std::uint64_t rgb10_texel(const std::array<double, 4>& rgba) noexcept {
  std::uint64_t texel = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::uint64_t code = unorm(rgba[c], 1023);
    texel |= (code << 6 | code >> 4) << 16 * c;
  }
  return texel;
}

std::uint64_t depth24_texel(std::uint32_t depth_d24) noexcept {
  const auto byte = [depth_d24](int shift) { return std::uint64_t{depth_d24 >> shift & 0xff} * 257; };
  return byte(16) | byte(8) << 16 | byte(0) << 32;
}

GBuffer::GBuffer(int width, int height, int targets) : targets_(targets) {
  if (targets == 0) return;
  for (std::size_t t = 0; t < static_cast<std::size_t>(targets); ++t)
    color_[t] = vm::Texture::render_target(width, height);
  depth_ = vm::Texture::render_target(width, height);
}

vm::SamplerBinding GBuffer::binding(std::string_view sampler) const {
  static constexpr std::string_view kSamplers[kColorTargets] = {"gbuffer_diffuse", "gbuffer_normal",
                                                                "gbuffer_specular", "gbuffer_emissive"};
  for (std::size_t t = 0; t < static_cast<std::size_t>(targets_); ++t)
    if (sampler == kSamplers[t]) return {&color_[t], kPointSampler};
  if (sampler == "gbuffer_depth") return {&depth_, kPointSampler};
  return {};
}

}  // namespace aluminate::passes
