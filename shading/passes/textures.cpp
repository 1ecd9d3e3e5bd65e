#include "shading/passes/textures.hpp"

#include "platform/host/image_file.hpp"
#include "platform/host/parallel.hpp"
#include "shading/filter/block_texels.hpp"

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

// Each level as it comes back from its blocks; bytes grows by theirs.
vm::Texture through_blocks(const vm::Texture& texture, bool is_normal, std::uint64_t& bytes) {
  const std::vector<std::uint8_t>& codes = texture.levels().front().codes8;
  bool is_opaque = true;
  for (std::size_t i = 3; i < codes.size(); i += 4) is_opaque = is_opaque && codes[i] == 255;
  const filter::BlockFormat format = is_normal   ? filter::BlockFormat::Dxt5nm
                                     : is_opaque ? filter::BlockFormat::Dxt1
                                                 : filter::BlockFormat::Dxt5;
  std::vector<vm::MipLevel> levels;
  for (const vm::MipLevel& level : texture.levels()) {
    levels.push_back({level.width,
                      level.height,
                      1,
                      filter::through_blocks(level.codes8, level.width, level.height, format),
                      {}});
    bytes += filter::block_bytes(level.width, level.height, format);
  }
  return vm::Texture::from_levels(vm::TextureShape::Flat, std::move(levels), texture.srgb());
}

}  // namespace

void TextureSet::want(int image, TextureUse use) {
  if (image >= 0) textures_.try_emplace({image, use});
}

void TextureSet::decode(const scenes::Scene& scene, TextureStorage storage) {
  std::vector<std::pair<const std::pair<int, TextureUse>, Entry>*> jobs;
  for (auto& entry : textures_) jobs.push_back(&entry);
  host::parallel_for(static_cast<std::int64_t>(jobs.size()), [&](std::int64_t i) {
    auto& [key, entry] = *jobs[static_cast<std::size_t>(i)];
    const scenes::EncodedImage& encoded = scene.images[static_cast<std::size_t>(key.first)];
    const host::Image8 image = host::decode_rgba8(encoded.bytes, encoded.name);
    const bool srgb = key.second == TextureUse::Color;
    entry.texture = vm::Texture::from_rgba8(image.width, image.height, image.texels, srgb, true);
    if (storage == TextureStorage::Dxt) {
      const bool is_normal = key.second == TextureUse::Normal;
      entry.texture = through_blocks(entry.texture, is_normal, entry.stored_bytes);
    } else {
      for (const vm::MipLevel& level : entry.texture.levels()) entry.stored_bytes += 4 * level.texel_count();
    }
  });
  for (const auto* job : jobs) {
    stored_bytes_ += job->second.stored_bytes;
    for (const vm::MipLevel& level : job->second.texture.levels()) rgba8_bytes_ += 4 * level.texel_count();
  }
}

const vm::Texture* TextureSet::find(int image, TextureUse use) const {
  const auto found = textures_.find({image, use});
  return found == textures_.end() ? nullptr : &found->second.texture;
}

vm::SamplerState sampler_state(const scenes::Sampler& sampler, int anisotropy) {
  return {.u = address(sampler.wrap_u),
          .v = address(sampler.wrap_v),
          .magnify = filter(sampler.magnify),
          .minify = filter(sampler.minify),
          .mip = filter(sampler.mip),
          .mipmapped = sampler.mipmapped,
          .max_anisotropy = anisotropy};
}

}  // namespace aluminate::passes
