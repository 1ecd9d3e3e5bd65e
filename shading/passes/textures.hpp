// The textures a frame samples: decoded once, only those that a draw's program really reads.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scenes/scene.hpp"
#include "shading/vm/program.hpp"
#include "shading/vm/texture.hpp"

namespace aluminate::passes {

class TextureSet {
 public:
  /// Notes that (image, encoding) will be sampled. Nothing is decoded yet.
  void want(int image, bool srgb);
  /// Decodes everything wanted, in parallel. Throws UserError naming the image that cannot be decoded.
  void decode(const scenes::Scene& scene);
  /// nullptr for a slot without image.
  const vm::Texture* find(int image, bool srgb) const;

  std::uint64_t texel_bytes() const { return texel_bytes_; }
  std::size_t decoded() const { return textures_.size(); }

 private:
  std::map<std::pair<int, bool>, vm::Texture> textures_;
  std::uint64_t texel_bytes_ = 0;
};

/// One texel, no mips: targets read back.
inline constexpr vm::SamplerState kPointSampler{.u = vm::Address::Clamp,
                                                .v = vm::Address::Clamp,
                                                .magnify = vm::Filter::Point,
                                                .minify = vm::Filter::Point,
                                                .mip = vm::Filter::Point,
                                                .mipmapped = false};
vm::SamplerState sampler_state(const scenes::Sampler& sampler);

}  // namespace aluminate::passes
