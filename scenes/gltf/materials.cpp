#include "scenes/gltf/materials.hpp"

#include "platform/host/error.hpp"
#include "scenes/image_header.hpp"
#include "scenes/trigonometry.hpp"

#include <algorithm>
#include <cmath>

#include "scenes/gltf/tinygltf.hpp"

namespace aluminate::scenes::gltf {
namespace {

using tinygltf::Value;

constexpr double kMostEmissive = 0x1p16;  // shaders hold values below 2^20

/// Member of an extension object; a null Value when absent.
const Value& member(const Value& object, const char* key) {
  static const Value kNothing;
  return object.IsObject() && object.Has(key) ? object.Get(key) : kNothing;
}

double number_or(const Value& value, double fallback) {
  return value.IsNumber() ? value.GetNumberAsDouble() : fallback;
}

template <int N>
glm::vec<N, double> vector_or(const Value& value, glm::vec<N, double> fallback) {
  if (!value.IsArray() || value.ArrayLen() != N) return fallback;
  for (int i = 0; i < N; ++i) fallback[i] = number_or(value.Get(i), fallback[i]);
  return fallback;
}

template <int N>
glm::vec<N, double> vector_or(const std::vector<double>& values, glm::vec<N, double> fallback) {
  if (values.size() != N) return fallback;
  for (int i = 0; i < N; ++i) fallback[i] = values[static_cast<std::size_t>(i)];
  return fallback;
}

Wrap wrap_mode(int gl_name) {
  if (gl_name == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::Clamp;
  return gl_name == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::Mirror : Wrap::Repeat;
}

Sampler sampler_of(const tinygltf::Sampler& source) {
  Sampler sampler;
  sampler.wrap_u = wrap_mode(source.wrapS);
  sampler.wrap_v = wrap_mode(source.wrapT);
  if (source.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST) sampler.magnify = Filter::Nearest;
  switch (source.minFilter) {  // -1: not given, trilinear
    case TINYGLTF_TEXTURE_FILTER_NEAREST:
      sampler.minify = Filter::Nearest;
      sampler.mipmapped = false;
      break;
    case TINYGLTF_TEXTURE_FILTER_LINEAR:
      sampler.mipmapped = false;
      break;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST:
      sampler.minify = Filter::Nearest;
      sampler.mip = Filter::Nearest;
      break;
    case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_NEAREST:
      sampler.mip = Filter::Nearest;
      break;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_LINEAR:
      sampler.minify = Filter::Nearest;
      break;
    default:
      break;
  }
  return sampler;
}

/// uv' = translation * rotation * scale * uv [KHRTextureTransform]. The rotation is the counter-clockwise
/// one of the extension's text as seen with v downwards, u' = u cos + v sin, v' = v cos - u sin; the GLSL
/// listing beside that text has the other sign, and importers follow the text.
glm::dmat3x2 uv_matrix(const Value& transform) {
  const auto offset = vector_or<2>(member(transform, "offset"), glm::dvec2(0));
  const auto scale = vector_or<2>(member(transform, "scale"), glm::dvec2(1));
  const SinCos r = sin_cos(number_or(member(transform, "rotation"), 0));
  return glm::dmat3x2{glm::dvec2(r.cos, -r.sin) * scale.x, glm::dvec2(r.sin, r.cos) * scale.y, offset};
}

class Reader {
 public:
  Reader(Document& document, const std::vector<EncodedImage>& images)
      : document_(document), model_(*document.model), images_(images) {}

  Material read(std::size_t index) {
    const tinygltf::Material& source = model_.materials[index];
    place_ = fmt::format("/materials/{}", index);
    Material material;
    material.name = source.name.empty() ? fmt::format("material {}", index) : shown_name(source.name);
    name_ = material.name;
    read_metallic_roughness(source, material);
    const auto& extensions = source.extensions;
    if (const auto found = extensions.find("KHR_materials_pbrSpecularGlossiness"); found != extensions.end())
      read_specular_glossiness(found->second, material);
    material.unlit = extensions.contains("KHR_materials_unlit");
    material.normal_map = slot(source.normalTexture, "normalTexture");
    material.normal_scale = source.normalTexture.scale;
    material.occlusion_map = slot(source.occlusionTexture, "occlusionTexture");
    material.occlusion_strength =
        clamped(source.occlusionTexture.strength, 0, 1, "occlusionTexture/strength");
    read_emissive(source, material);
    if (source.alphaMode == "MASK") material.alpha_mode = AlphaMode::Mask;
    if (source.alphaMode == "BLEND") material.alpha_mode = AlphaMode::Blend;
    material.alpha_cutoff = clamped(source.alphaCutoff, 0, kMostEmissive, "alphaCutoff");
    material.double_sided = source.doubleSided;
    return material;
  }

 private:
  void read_metallic_roughness(const tinygltf::Material& source, Material& material) {
    const auto& pbr = source.pbrMetallicRoughness;
    material.base_color = vector_or<4>(pbr.baseColorFactor, glm::dvec4(1));
    for (int i = 0; i < 4; ++i)
      material.base_color[i] = clamped(material.base_color[i], 0, 1, "baseColorFactor");
    material.metallic = clamped(pbr.metallicFactor, 0, 1, "metallicFactor");
    material.roughness = clamped(pbr.roughnessFactor, 0, 1, "roughnessFactor");
    material.base_color_map = slot(pbr.baseColorTexture, "pbrMetallicRoughness/baseColorTexture");
    material.metallic_roughness_map =
        slot(pbr.metallicRoughnessTexture, "pbrMetallicRoughness/metallicRoughnessTexture");
  }

  void read_specular_glossiness(const Value& source, Material& material) {
    material.workflow = Workflow::SpecularGlossiness;
    material.base_color = vector_or<4>(member(source, "diffuseFactor"), glm::dvec4(1));
    material.specular = vector_or<3>(member(source, "specularFactor"), glm::dvec3(1));
    for (int i = 0; i < 4; ++i)
      material.base_color[i] = clamped(material.base_color[i], 0, 1, "diffuseFactor");
    for (int i = 0; i < 3; ++i) material.specular[i] = clamped(material.specular[i], 0, 1, "specularFactor");
    material.glossiness = clamped(number_or(member(source, "glossinessFactor"), 1), 0, 1, "glossinessFactor");
    material.base_color_map = slot(member(source, "diffuseTexture"), "diffuseTexture");
    material.specular_glossiness_map =
        slot(member(source, "specularGlossinessTexture"), "specularGlossinessTexture");
    material.metallic_roughness_map = {};
  }

  void read_emissive(const tinygltf::Material& source, Material& material) {
    material.emissive = vector_or<3>(source.emissiveFactor, glm::dvec3(0));
    if (const auto found = source.extensions.find("KHR_materials_emissive_strength");
        found != source.extensions.end())
      material.emissive *= number_or(member(found->second, "emissiveStrength"), 1);
    for (int i = 0; i < 3; ++i)
      material.emissive[i] = clamped(material.emissive[i], 0, kMostEmissive, "emissiveFactor");
    // A factor of zero makes the map invisible: it is not loaded.
    if (material.emissive != glm::dvec3(0))
      material.emissive_map = slot(source.emissiveTexture, "emissiveTexture");
  }

  double clamped(double value, double low, double high, const char* what) {
    if (value >= low && value <= high) return value;
    document_.warnings.add(fmt::format("{} '{}': {} = {} lies outside {} to {} and was clamped", place_,
                                       name_, what, value, low, high));
    return value > high ? high : low;  // NaN (infinity times zero) becomes low
  }

  template <typename Info>  // TextureInfo, NormalTextureInfo and OcclusionTextureInfo share these members
                            // only
  TextureSlot slot(const Info& info, const char* use) {
    const auto found = info.extensions.find("KHR_texture_transform");
    return slot(info.index, info.texCoord, found == info.extensions.end() ? Value() : found->second, use);
  }

  TextureSlot slot(const Value& info, const char* use) {
    if (!info.IsObject()) return {};
    return slot(static_cast<int>(number_or(member(info, "index"), -1)),
                static_cast<int>(number_or(member(info, "texCoord"), 0)),
                member(member(info, "extensions"), "KHR_texture_transform"), use);
  }

  TextureSlot slot(int texture_index, int uv_set, const Value& transform, const char* use) {
    TextureSlot result;
    if (texture_index < 0) return result;
    const auto& texture = model_.textures.at(static_cast<std::size_t>(texture_index));
    const std::string place = fmt::format("{}/{}", place_, use);
    result.uv_set = static_cast<int>(number_or(member(transform, "texCoord"), uv_set));
    result.uv_transform = uv_matrix(transform);
    if (texture.sampler >= 0)
      result.sampler = sampler_of(model_.samplers.at(static_cast<std::size_t>(texture.sampler)));
    if (result.uv_set > 1) {
      document_.warnings.add(
          fmt::format("{} '{}': uses uv set {}; only 0 and 1 are read, the texture was ignored", place, name_,
                      result.uv_set));
      return {};
    }
    if (texture.source < 0) {
      const std::string extension =
          texture.extensions.empty() ? "no image"
                                     : "only a " + shown_name(texture.extensions.begin()->first) + " image";
      document_.warnings.add(fmt::format("{} '{}': /textures/{} has {}, the texture was ignored", place,
                                         name_, texture_index, extension));
      return {};
    }
    if (!usable(texture.source)) {
      document_.warnings.add(
          fmt::format("{} '{}': /images/{} is not PNG or JPEG ({}), the texture was ignored", place, name_,
                      texture.source, image_type(texture.source)));
      return {};
    }
    result.image = texture.source;
    return result;
  }

  ImageKind kind(int image) const {
    return read_image_header(images_.at(static_cast<std::size_t>(image)).bytes).kind;
  }

  std::string image_type(int image) const {
    const ImageKind found = kind(image);
    return found == ImageKind::Unknown ? "data URI of a type that is not read"
                                       : std::string(image_kind_name(found));
  }

  /// A used image that is no image at all is an error, not something to paper over.
  bool usable(int image) const {
    const ImageHeader header = read_image_header(images_.at(static_cast<std::size_t>(image)).bytes);
    const bool is_read = header.kind == ImageKind::Png || header.kind == ImageKind::Jpeg;
    const std::string place = fmt::format("/images/{}", image);
    if (header.kind == ImageKind::Unknown && !images_[static_cast<std::size_t>(image)].bytes.empty())
      document_.fail(place, "is neither PNG nor JPEG", "glTF textures are PNG or JPEG files");
    if (is_read && (header.width_px == 0 || header.height_px == 0))
      document_.fail(place, "its header is cut off or damaged");
    return is_read;
  }

  Document& document_;
  const tinygltf::Model& model_;
  const std::vector<EncodedImage>& images_;
  std::string place_, name_;
};

}  // namespace

std::vector<EncodedImage> take_images(Document& document) {
  std::vector<EncodedImage> images;
  for (auto& source : document.model->images) {
    EncodedImage image;
    const std::string& label = source.name.empty() ? source.uri : source.name;
    image.name = fmt::format("{} image {}{}", document.file, images.size(),
                             label.empty() ? "" : " '" + shown_name(label) + "'");
    image.bytes = std::move(source.image);
    images.push_back(std::move(image));
  }
  return images;
}

std::vector<Material> read_materials(Document& document, const std::vector<EncodedImage>& images) {
  Reader reader(document, images);
  std::vector<Material> materials;
  for (std::size_t i = 0; i < document.model->materials.size(); ++i) materials.push_back(reader.read(i));
  return materials;
}

}  // namespace aluminate::scenes::gltf
