#include "scenes/generator/model.hpp"

#include "platform/host/output_file.hpp"
#include "scenes/gltf/shading_frame.hpp"
#include "scenes/trigonometry.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace aluminate::scenes::generator {
namespace {

constexpr int kVertexBuffer = 34962, kIndexBuffer = 34963, kUnsignedByte = 5121, kUnsignedShort = 5123,
              kUnsignedInt = 5125, kFloat = 5126;

glm::dvec3 unit(const glm::dvec3& v) { return v / std::sqrt(glm::dot(v, v)); }

glm::dmat4 looking(const glm::dvec3& eye, const glm::dvec3& target) {
  const glm::dvec3 back = unit(eye - target);
  const glm::dvec3 side =
      glm::cross(std::fabs(back.y) > 0.999 ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 1, 0), back);
  const glm::dvec3 right = unit(side), up = glm::cross(back, right);
  return glm::dmat4(glm::dvec4(right, 0), glm::dvec4(up, 0), glm::dvec4(back, 0), glm::dvec4(eye, 1));
}

std::vector<double> numbers(const glm::dmat4& m) {
  std::vector<double> out;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) out.push_back(static_cast<double>(static_cast<float>(m[c][r])));
  return out;
}

}  // namespace

void Surface::append(const Surface& other, const glm::dmat4& placement) {
  const auto base = static_cast<std::uint32_t>(positions.size());
  const glm::dmat3 directions = glm::transpose(glm::inverse(glm::dmat3(placement)));
  for (const auto& p : other.positions) positions.push_back(glm::dvec3(placement * glm::dvec4(p, 1)));
  for (const auto& n : other.normals) normals.push_back(unit(directions * n));
  uv.insert(uv.end(), other.uv.begin(), other.uv.end());
  colors.insert(colors.end(), other.colors.begin(), other.colors.end());
  for (const std::uint32_t index : other.indices) indices.push_back(base + index);
}

void Surface::add_tangents() {
  const gltf::UvGradients gradients = gltf::summed_uv_gradients(positions, uv, indices);
  tangents.clear();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const glm::dvec3 along =
        gltf::unit_or_zero(gradients.along_u[i] - normals[i] * glm::dot(normals[i], gradients.along_u[i]));
    const glm::dvec3 tangent = along == glm::dvec3(0) ? gltf::any_tangent(normals[i]) : along;
    const double w = glm::dot(glm::cross(normals[i], tangent), gradients.along_v[i]) > 0 ? -1 : 1;
    tangents.push_back(glm::dvec4(tangent, w));
  }
}

void Surface::tint(const glm::dvec4& color) {
  colors.resize(positions.size(), glm::dvec4(1));
  for (auto& c : colors) c *= color;
}

Model::Model(std::string name) : name_(std::move(name)) {
  root_["asset"] = {{"version", "2.0"}, {"generator", "aluminate_scenes_make"}, {"copyright", "CC0 1.0"}};
  root_["scene"] = 0;
  root_["scenes"] = ordered_json::array({{{"name", name_}, {"nodes", ordered_json::array()}}});
}

int Model::append(const char* array, ordered_json value) {
  root_[array].push_back(std::move(value));
  return static_cast<int>(root_[array].size()) - 1;
}

void Model::use_extension(const std::string& name) {
  auto& used = root_["extensionsUsed"];
  if (std::find(used.begin(), used.end(), name) == used.end()) used.push_back(name);
}

int Model::add_texture(const std::string& what, host::Image8 image) {
  const std::string file = name_ + "_" + what + ".png";
  if (!root_.contains("samplers"))
    append("samplers", {{"magFilter", 9729}, {"minFilter", 9987}, {"wrapS", 10497}, {"wrapT", 10497}});
  const int index = append("images", {{"name", what}, {"uri", file}});
  images_.emplace_back(file, std::move(image));
  return append("textures", {{"sampler", 0}, {"source", index}});
}

int Model::add_material(ordered_json material) {
  if (material.contains("extensions"))
    for (const auto& [name, value] : material["extensions"].items()) use_extension(name);
  return append("materials", std::move(material));
}

int Model::add_view(const void* bytes, std::size_t size, int target) {
  const std::size_t offset = bin_.size();
  bin_.resize(offset + (size + 3) / 4 * 4, 0);
  std::memcpy(bin_.data() + offset, bytes, size);
  return append("bufferViews",
                {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}, {"target", target}});
}

ordered_json Model::add_surface(const Surface& surface) {
  const std::size_t count = surface.positions.size();
  ordered_json attributes;
  const auto add_floats = [&](const char* semantic, const char* type, const std::vector<float>& values) {
    const int view = add_view(values.data(), values.size() * sizeof(float), kVertexBuffer);
    attributes[semantic] = append(
        "accessors", {{"bufferView", view}, {"componentType", kFloat}, {"count", count}, {"type", type}});
  };
  const auto floats = [](const auto& vectors) {
    std::vector<float> out;
    for (const auto& v : vectors)
      for (int i = 0; i < v.length(); ++i) out.push_back(static_cast<float>(v[i]));
    return out;
  };
  const std::vector<float> positions = floats(surface.positions);
  add_floats("POSITION", "VEC3", positions);
  auto& accessor = root_["accessors"].back();
  std::vector<float> low(3, std::numeric_limits<float>::max()), high(3, -std::numeric_limits<float>::max());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    low[i % 3] = std::min(low[i % 3], positions[i]);
    high[i % 3] = std::max(high[i % 3], positions[i]);
  }
  accessor["min"] = low;
  accessor["max"] = high;
  add_floats("NORMAL", "VEC3", floats(surface.normals));
  if (!surface.tangents.empty()) add_floats("TANGENT", "VEC4", floats(surface.tangents));
  if (!surface.uv.empty()) add_floats("TEXCOORD_0", "VEC2", floats(surface.uv));
  if (!surface.colors.empty()) {
    std::vector<std::uint8_t> bytes;
    for (const auto& c : surface.colors)
      for (int i = 0; i < 4; ++i)
        bytes.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(c[i], 0.0, 1.0) * 255)));
    const int view = add_view(bytes.data(), bytes.size(), kVertexBuffer);
    attributes["COLOR_0"] = append("accessors", {{"bufferView", view},
                                                 {"componentType", kUnsignedByte},
                                                 {"normalized", true},
                                                 {"count", count},
                                                 {"type", "VEC4"}});
  }
  int view = 0;
  const bool is_short = count <= 65535;
  if (is_short) {
    const std::vector<std::uint16_t> narrow(surface.indices.begin(), surface.indices.end());
    view = add_view(narrow.data(), narrow.size() * sizeof(std::uint16_t), kIndexBuffer);
  } else {
    view = add_view(surface.indices.data(), surface.indices.size() * sizeof(std::uint32_t), kIndexBuffer);
  }
  const int indices = append("accessors", {{"bufferView", view},
                                           {"componentType", is_short ? kUnsignedShort : kUnsignedInt},
                                           {"count", surface.indices.size()},
                                           {"type", "SCALAR"}});
  return {{"attributes", attributes}, {"indices", indices}};
}

int Model::add_mesh(const std::string& name, const ordered_json& primitive, int material) {
  ordered_json with_material = primitive;
  with_material["material"] = material;
  return append("meshes", {{"name", name}, {"primitives", ordered_json::array({with_material})}});
}

void Model::place(const std::string& name, int mesh, const glm::dmat4& placement) {
  ordered_json node = {{"name", name}, {"mesh", mesh}};
  if (placement != glm::dmat4(1)) node["matrix"] = numbers(placement);
  add_root(node);
}

void Model::add_root(const ordered_json& node) {
  const int index = append("nodes", node);  // first: it may move the members of root_
  root_["scenes"][0]["nodes"].push_back(index);
}

void Model::add_camera(const std::string& name, const glm::dvec3& eye, const glm::dvec3& target,
                       double fovy_degrees, double near_plane) {
  const int camera =
      append("cameras", {{"name", name},
                         {"type", "perspective"},
                         {"perspective", {{"yfov", fovy_degrees * (kPi / 180)}, {"znear", near_plane}}}});
  add_root({{"name", name}, {"camera", camera}, {"matrix", numbers(looking(eye, target))}});
}

void Model::add_light(const std::string& name, const std::string& kind, const glm::dvec3& color,
                      double intensity, const glm::dvec3& from, const glm::dvec3& to, double range) {
  use_extension("KHR_lights_punctual");
  ordered_json light = {
      {"name", name}, {"type", kind}, {"color", {color.r, color.g, color.b}}, {"intensity", intensity}};
  if (range > 0) light["range"] = range;
  auto& lights = root_["extensions"]["KHR_lights_punctual"]["lights"];
  lights.push_back(light);
  ordered_json node = {{"name", name}};
  node["matrix"] = numbers(kind == "point" ? moved(from) : looking(from, to));
  node["extensions"]["KHR_lights_punctual"]["light"] = lights.size() - 1;
  add_root(node);
}

void Model::write(const std::filesystem::path& folder) const {
  ordered_json root = root_;
  root["buffers"] = ordered_json::array({{{"byteLength", bin_.size()}, {"uri", name_ + ".bin"}}});
  const std::string text = root.dump(1) + "\n";
  const auto save = [&](const std::string& file, const std::vector<std::uint8_t>& bytes) {
    host::write_file((folder / file).string(), std::span<const std::uint8_t>(bytes));
  };
  save(name_ + ".gltf", std::vector<std::uint8_t>(text.begin(), text.end()));
  save(name_ + ".bin", bin_);
  for (const auto& [file, image] : images_) save(file, host::encode_png(image));
}

ordered_json pbr_material(const std::string& name, const glm::dvec4& base_color, double metallic,
                          double roughness, int base_color_texture, int normal_texture,
                          int metallic_roughness_texture) {
  ordered_json pbr = {{"baseColorFactor", {base_color.r, base_color.g, base_color.b, base_color.a}},
                      {"metallicFactor", metallic},
                      {"roughnessFactor", roughness}};
  if (base_color_texture >= 0) pbr["baseColorTexture"] = {{"index", base_color_texture}};
  if (metallic_roughness_texture >= 0)
    pbr["metallicRoughnessTexture"] = {{"index", metallic_roughness_texture}};
  ordered_json material = {{"name", name}, {"pbrMetallicRoughness", pbr}};
  if (normal_texture >= 0) material["normalTexture"] = {{"index", normal_texture}};
  return material;
}

glm::dmat4 moved(const glm::dvec3& offset) {
  glm::dmat4 m(1);
  m[3] = glm::dvec4(offset, 1);
  return m;
}

glm::dmat4 turned_y(double degrees) {
  const SinCos a = sin_cos(degrees * (kPi / 180));
  return glm::dmat4(glm::dvec4(a.cos, 0, -a.sin, 0), glm::dvec4(0, 1, 0, 0), glm::dvec4(a.sin, 0, a.cos, 0),
                    glm::dvec4(0, 0, 0, 1));
}

glm::dmat4 turned_x(double degrees) {
  const SinCos a = sin_cos(degrees * (kPi / 180));
  return glm::dmat4(glm::dvec4(1, 0, 0, 0), glm::dvec4(0, a.cos, a.sin, 0), glm::dvec4(0, -a.sin, a.cos, 0),
                    glm::dvec4(0, 0, 0, 1));
}

glm::dmat4 turned_z(double degrees) {
  const SinCos a = sin_cos(degrees * (kPi / 180));
  return glm::dmat4(glm::dvec4(a.cos, a.sin, 0, 0), glm::dvec4(-a.sin, a.cos, 0, 0), glm::dvec4(0, 0, 1, 0),
                    glm::dvec4(0, 0, 0, 1));
}

glm::dmat4 scaled(const glm::dvec3& factors) {
  glm::dmat4 m(1);
  for (int i = 0; i < 3; ++i) m[i] *= factors[i];
  return m;
}

}  // namespace aluminate::scenes::generator
