#include "shading/passes/toksvig.hpp"

#include <cmath>
#include <vector>

#include "platform/host/image_file.hpp"
#include "platform/host/parallel.hpp"
#include "shading/brdf/material.hpp"
#include "shading/filter/dxt5_pack.hpp"
#include "shading/filter/gloss_bake.hpp"

namespace aluminate::passes {
namespace {

host::Image8 decoded(const scenes::Scene& scene, int image) {
  const scenes::EncodedImage& encoded = scene.images[static_cast<std::size_t>(image)];
  return host::decode_rgba8(encoded.bytes, encoded.name);
}

bool same_mapping(const scenes::TextureSlot& a, const scenes::TextureSlot& b) {
  return a.uv_set == b.uv_set && a.uv_transform == b.uv_transform;
}

// Gloss under each texel of the normal map: the material's factor times its map, nearest texel, where both
// are mapped alike; the factor alone where they are not.
filter::ScalarLevel gloss_under(const scenes::Scene& scene, const scenes::Material& material, int width,
                                int height) {
  const bool specular_glossiness = material.workflow == scenes::Workflow::SpecularGlossiness;
  const scenes::TextureSlot& slot =
      specular_glossiness ? material.specular_glossiness_map : material.metallic_roughness_map;
  host::Image8 map;
  if (slot.present() && same_mapping(slot, material.normal_map)) map = decoded(scene, slot.image);
  filter::ScalarLevel gloss{width, height, {}};
  gloss.texels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const std::size_t channel = specular_glossiness ? 3 : 1;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double value = 1.0;
      if (map.width > 0) {
        const auto mx = static_cast<std::size_t>((2 * x + 1) * std::int64_t{map.width} / (2 * width)),
                   my = static_cast<std::size_t>((2 * y + 1) * std::int64_t{map.height} / (2 * height));
        value = map.texels[4 * (my * static_cast<std::size_t>(map.width) + mx) + channel] / 255.0;
      }
      gloss.texels.push_back(specular_glossiness ? brdf::clamped(material.glossiness * value)
                                                 : brdf::gloss_from_power(brdf::power_from_roughness(
                                                       material.roughness * value)));
    }
  return gloss;
}

// As the shader scales them: brdf sees unit vectors.
void scale_normals(filter::NormalLevel& normals, double scale) {
  if (scale == 1.0) return;
  for (glm::dvec3& n : normals.texels) {
    n.x *= scale;
    n.y *= scale;
    const double length = glm::length(n);
    n = length > 0 ? n / length : glm::dvec3(0, 0, 1);
  }
}

vm::MipLevel level_of(int width, int height, std::vector<std::uint8_t> rgba) {
  return {width, height, 1, std::move(rgba), {}};
}

vm::Texture factor_texture(const std::vector<filter::BakedLevel>& levels) {
  std::vector<vm::MipLevel> mips;
  for (const filter::BakedLevel& level : levels) {
    const filter::ScalarLevel factor = filter::bake_factor(level);
    std::vector<std::uint8_t> rgba;
    rgba.reserve(factor.texels.size() * 4);
    for (const double ft : factor.texels) {
      rgba.insert(rgba.end(), 4, static_cast<std::uint8_t>(std::floor(brdf::clamped(ft) * 255.0 + 0.5)));
    }
    mips.push_back(level_of(factor.width, factor.height, std::move(rgba)));
  }
  return vm::Texture::from_levels(vm::TextureShape::Flat, std::move(mips), false);
}

vm::Texture dxt5_texture(const std::vector<filter::BakedLevel>& levels) {
  std::vector<vm::MipLevel> mips;
  for (const filter::BakedLevel& level : levels) {
    const int width = level.length.width, height = level.length.height;
    const std::vector<std::uint8_t> packed = filter::pack_texels(level, level.filtered_gloss);
    mips.push_back(level_of(width, height,
                            filter::decode_dxt5(filter::encode_dxt5(packed, width, height), width, height)));
  }
  return vm::Texture::from_levels(vm::TextureShape::Flat, std::move(mips), false);
}

}  // namespace

ToksvigSet::ToksvigSet(const scenes::Scene& scene, ToksvigMode mode) : mode_(mode) {
  if (mode == ToksvigMode::Off) return;
  std::vector<const scenes::Material*> wanted;
  for (const scenes::Mesh& mesh : scene.meshes) {
    const scenes::Material* material = &scene.materials[static_cast<std::size_t>(mesh.material)];
    if (mesh.indices.empty() || material->unlit || !material->normal_map.present()) continue;
    if (baked_.try_emplace(material).second) wanted.push_back(material);
  }
  std::vector<std::shared_ptr<const Baked>> results(wanted.size());
  host::parallel_for(static_cast<std::int64_t>(wanted.size()), [&](std::int64_t i) {
    const scenes::Material& material = *wanted[static_cast<std::size_t>(i)];
    const host::Image8 map = decoded(scene, material.normal_map.image);
    filter::NormalLevel normals = filter::decode_normal_map({map.texels, map.width, map.height});
    scale_normals(normals, material.normal_scale);
    const std::vector<filter::BakedLevel> levels =
        filter::bake_gloss(normals, gloss_under(scene, material, map.width, map.height));
    auto baked = std::make_shared<Baked>();
    switch (mode_) {
      case ToksvigMode::Texture:
        baked->texture = factor_texture(levels);
        break;
      case ToksvigMode::Dxt5:
        baked->texture = dxt5_texture(levels);
        break;
      case ToksvigMode::Material:
        baked->factor = filter::material_factor(levels[std::min(kMaterialToksvigMip, levels.size() - 1)]);
        break;
      case ToksvigMode::Off:
        break;
    }
    results[static_cast<std::size_t>(i)] = std::move(baked);
  });
  for (std::size_t i = 0; i < wanted.size(); ++i) baked_[wanted[i]] = std::move(results[i]);
}

const vm::Texture* ToksvigSet::texture(const scenes::Material& material) const {
  if (mode_ != ToksvigMode::Texture && mode_ != ToksvigMode::Dxt5) return nullptr;
  const auto found = baked_.find(&material);
  return found == baked_.end() ? nullptr : &found->second->texture;
}

double ToksvigSet::factor(const scenes::Material& material) const {
  const auto found = baked_.find(&material);
  return found == baked_.end() ? 1.0 : found->second->factor;
}

}  // namespace aluminate::passes
