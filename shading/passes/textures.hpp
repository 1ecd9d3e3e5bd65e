// The textures a frame samples: decoded once, only those that a draw's program really reads.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scenes/scene.hpp"
#include "shading/passes/options.hpp"
#include "shading/vm/program.hpp"
#include "shading/vm/texture.hpp"

namespace aluminate::passes {

/// What an image is to the shader: it decides its encoding and how it would be compressed.
enum class TextureUse : std::uint8_t { Color, Data, Normal };  // sRGB; linear; linear, a direction in xyz

class TextureSet {
 public:
  /// Notes that an image will be sampled. Nothing is decoded yet.
  void want(int image, TextureUse use);
  /// Decodes everything wanted, in parallel. Dxt: every level goes through the blocks a console would have
  /// loaded, DXT1 without and DXT5 with alpha, normals as DXT5nm (x in alpha, y in green, no z). Throws
  /// UserError naming the image that cannot be decoded.
  void decode(const scenes::Scene& scene, TextureStorage storage);
  /// nullptr for a slot without image.
  const vm::Texture* find(int image, TextureUse use) const;

  /// Bytes of all levels as stored on the console, of their bytes as RGBA8. 1 for no texture.
  double share() const {
    return rgba8_bytes_ == 0 ? 1.0 : static_cast<double>(stored_bytes_) / static_cast<double>(rgba8_bytes_);
  }
  std::size_t decoded() const { return textures_.size(); }

 private:
  struct Entry {
    vm::Texture texture;
    std::uint64_t stored_bytes = 0;
  };
  std::map<std::pair<int, TextureUse>, Entry> textures_;
  std::uint64_t stored_bytes_ = 0, rgba8_bytes_ = 0;
};

/// One texel, no mips: targets read back.
inline constexpr vm::SamplerState kPointSampler{.u = vm::Address::Clamp,
                                                .v = vm::Address::Clamp,
                                                .magnify = vm::Filter::Point,
                                                .minify = vm::Filter::Point,
                                                .mip = vm::Filter::Point,
                                                .mipmapped = false};
vm::SamplerState sampler_state(const scenes::Sampler& sampler, int anisotropy = 1);

}  // namespace aluminate::passes
