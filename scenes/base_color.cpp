#include "scenes/base_color.hpp"

#include "platform/host/error.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/suggest.hpp"
#include "scenes/gltf/container.hpp"
#include "scenes/gltf/document.hpp"
#include "scenes/image_header.hpp"
#include "scenes/loader.hpp"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "scenes/gltf/tinygltf.hpp"

namespace aluminate::scenes {
namespace {

using nlohmann::json;
using Bytes = std::vector<std::uint8_t>;

std::string mime_type(std::span<const std::uint8_t> image, const std::string& name) {
  const ImageKind kind = read_image_header(image).kind;
  if (kind == ImageKind::Png) return "image/png";
  if (kind == ImageKind::Jpeg) return "image/jpeg";
  throw UserError({name}, fmt::format("expected a PNG or JPEG, found {}", image_kind_name(kind)),
                  "those are the pictures a glTF material can hold");
}

std::size_t append(json& root, const char* array, json value) {
  root[array].push_back(std::move(value));
  return root[array].size() - 1;
}

/// Puts bytes behind the others and returns the number of their view.
std::size_t add_view(json& root, Bytes& bin, std::span<const std::uint8_t> bytes) {
  bin.resize((bin.size() + 3) / 4 * 4, 0);
  const std::size_t offset = bin.size();
  bin.insert(bin.end(), bytes.begin(), bytes.end());
  return append(root, "bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes.size()}});
}

/// All buffers one behind the other, and every picture that lay outside: the file then needs no other.
Bytes gather(json& root, const tinygltf::Model& model, const std::string& file) {
  Bytes bin;
  std::vector<std::size_t> starts;
  for (const tinygltf::Buffer& buffer : model.buffers) {
    bin.resize((bin.size() + 3) / 4 * 4, 0);
    starts.push_back(bin.size());
    bin.insert(bin.end(), buffer.data.begin(), buffer.data.end());
  }
  if (root.contains("bufferViews"))
    for (json& view : root["bufferViews"]) {
      const auto buffer = view.at("buffer").get<std::size_t>();
      view["byteOffset"] = view.value("byteOffset", std::size_t{0}) + starts.at(buffer);
      view["buffer"] = 0;
    }
  if (root.contains("images"))
    for (std::size_t i = 0; i < root["images"].size(); ++i) {
      json& image = root["images"][i];
      if (!image.contains("uri")) continue;
      const auto& bytes = model.images.at(i).image;
      image["mimeType"] = mime_type(bytes, file);
      image["bufferView"] = add_view(root, bin, bytes);
      image.erase("uri");
    }
  return bin;
}

std::string material_list(const json& root) {
  std::string text;
  for (std::size_t i = 0; i < root["materials"].size() && i < 12; ++i)
    text += fmt::format("{}{} {}", i > 0 ? ", " : "", i,
                        gltf::shown_name(root["materials"][i].value("name", std::string("(no name)"))));
  return text + (root["materials"].size() > 12 ? ", ..." : "");
}

std::size_t chosen_material(json& root, const std::string& wanted, const std::string& file) {
  if (!root.contains("materials") || root["materials"].empty()) {
    if (!wanted.empty())
      throw UserError({file}, fmt::format("there is no material '{}': the file has none", wanted),
                      "leave out --material");
    root["materials"] = json::array({json::object()});
    for (json& mesh : root["meshes"])
      for (json& primitive : mesh["primitives"]) primitive["material"] = 0;
    return 0;
  }
  const json& materials = root["materials"];
  if (wanted.empty()) {
    if (materials.size() == 1) return 0;
    throw UserError({file}, fmt::format("the file has {} materials", materials.size()),
                    "choose one with --material: " + material_list(root));
  }
  std::vector<std::size_t> named;
  for (std::size_t i = 0; i < materials.size(); ++i)
    if (materials[i].value("name", std::string()) == wanted) named.push_back(i);
  if (named.size() == 1) return named[0];
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
  if (named.empty() && error == std::errc{} && end == wanted.data() + wanted.size() &&
      number < materials.size())
    return number;
  throw UserError({file},
                  named.empty() ? fmt::format("there is no material '{}'", wanted)
                                : fmt::format("more than one material is named '{}'", wanted),
                  "the materials are: " + material_list(root));
}

/// Where a material keeps its colour, in either workflow.
struct Slot {
  json* owner;
  const char* texture;
  const char* factor;
  bool glossy;  // KHR_materials_pbrSpecularGlossiness, which stores 1 - roughness
};

Slot color_slot(json& material) {
  constexpr const char* kOther = "KHR_materials_pbrSpecularGlossiness";
  if (material.contains("extensions") && material["extensions"].contains(kOther))
    return {&material["extensions"][kOther], "diffuseTexture", "diffuseFactor", true};
  json& usual = material["pbrMetallicRoughness"];
  usual["metallicFactor"] = 0.0;
  return {&usual, "baseColorTexture", "baseColorFactor", false};
}

void check_coordinates(const json& root, std::size_t material, int set, const std::string& file) {
  for (const json& mesh : root.value("meshes", json::array()))
    for (const json& primitive : mesh.at("primitives"))
      if (primitive.value("material", std::size_t{~std::size_t{0}}) == material &&
          primitive.at("attributes").contains(fmt::format("TEXCOORD_{}", set)))
        return;
  throw UserError(
      {file}, fmt::format("no mesh with material {} has texture coordinates (TEXCOORD_{})", material, set),
      "unwrap it in the modelling program first");
}

}  // namespace

std::vector<std::uint8_t> with_base_color(const std::filesystem::path& scene,
                                          std::span<const std::uint8_t> image, const std::string& image_name,
                                          const BaseColor& base_color) {
  const std::string file = scene.string();
  const std::string kind = mime_type(image, image_name);
  if (base_color.roughness && !(*base_color.roughness >= 0.0 && *base_color.roughness <= 1.0))
    throw UserError(fmt::format("roughness {}", *base_color.roughness), "expected 0 to 1");
  const LoadLimits limits;
  (void)load_scene(scene, limits);  // every check of a file that may be hostile
  const gltf::Document document = gltf::read_document(scene, limits);
  const Bytes bytes = host::read_bytes(file);
  json root = gltf::parse_json(gltf::open_container(bytes, file), file, limits);

  Bytes bin = gather(root, *document.model, file);
  const std::size_t index = chosen_material(root, base_color.material, file);
  const Slot slot = color_slot(root["materials"][index]);
  json& map = (*slot.owner)[slot.texture];
  json& factor = (*slot.owner)[slot.factor];
  json texture = json::object();
  if (map.is_object()) {
    const json& old = root["textures"].at(map.at("index").get<std::size_t>());
    if (old.contains("sampler")) texture["sampler"] = old["sampler"];
  } else {
    map = json::object();
  }
  check_coordinates(root, index, map.value("texCoord", 0), file);
  factor = {1.0, 1.0, 1.0, factor.is_array() ? factor.at(3).get<double>() : 1.0};
  if (base_color.roughness)
    (*slot.owner)[slot.glossy ? "glossinessFactor" : "roughnessFactor"] =
        slot.glossy ? 1.0 - *base_color.roughness : *base_color.roughness;
  const std::size_t view = add_view(root, bin, image);
  texture["source"] = append(root, "images", {{"bufferView", view}, {"mimeType", kind}});
  map["index"] = append(root, "textures", std::move(texture));
  root["buffers"] = json::array({{{"byteLength", bin.size()}}});
  return gltf::glb_bytes(root, bin, file);
}

}  // namespace aluminate::scenes
