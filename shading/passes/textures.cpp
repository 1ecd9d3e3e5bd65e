#include "shading/passes/textures.hpp"

#include "platform/host/image_file.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::passes {
namespace {

vm::Address address(scenes::Wrap wrap) {
  switch (wrap) {
    case scenes::Wrap::Clamp:
      return vm::Address::Clamp;
    case scenes::Wrap::Mirror:
      return vm::Address::Mirror;
    default:
      return vm::Address::Wrap;
  }
}

vm::Filter filter(scenes::Filter f) {
  return f == scenes::Filter::Nearest ? vm::Filter::Point : vm::Filter::Linear;
}

}  // namespace

void TextureSet::want(int image, bool srgb) {
  if (image >= 0) textures_.try_emplace({image, srgb});
}

void TextureSet::decode(const scenes::Scene& scene) {
  std::vector<std::pair<const std::pair<int, bool>, vm::Texture>*> jobs;
  for (auto& entry : textures_) jobs.push_back(&entry);
  host::parallel_for(static_cast<std::int64_t>(jobs.size()), [&](std::int64_t i) {
    auto& [key, texture] = *jobs[static_cast<std::size_t>(i)];
    const scenes::EncodedImage& encoded = scene.images[static_cast<std::size_t>(key.first)];
    const host::Image8 image = host::decode_rgba8(encoded.bytes, encoded.name);
    texture = vm::Texture::from_rgba8(image.width, image.height, image.texels, key.second, true);
  });
  for (const auto* job : jobs)
    for (const vm::MipLevel& level : job->second.levels()) texel_bytes_ += 4 * level.texel_count();
}

const vm::Texture* TextureSet::find(int image, bool srgb) const {
  const auto found = textures_.find({image, srgb});
  return found == textures_.end() ? nullptr : &found->second;
}

vm::SamplerState sampler_state(const scenes::Sampler& sampler) {
  return {.u = address(sampler.wrap_u),
          .v = address(sampler.wrap_v),
          .magnify = filter(sampler.magnify),
          .minify = filter(sampler.minify),
          .mip = filter(sampler.mip),
          .mipmapped = sampler.mipmapped};
}

}  // namespace aluminate::passes
