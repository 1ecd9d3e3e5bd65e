#include "scenes/gltf/geometry.hpp"

#include "platform/host/error.hpp"
#include "scenes/gltf/accessor.hpp"
#include "scenes/gltf/shading_frame.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scenes/gltf/tinygltf.hpp"

namespace aluminate::scenes::gltf {
namespace {

constexpr double kLargestColor = 0x1p16;  // shaders hold values below 2^20

bool finite(float a) { return std::isfinite(a); }

/// Corners of strips and fans, three per triangle, all wound like the first [glTF2 3.7.2.1].
std::vector<std::uint32_t> to_triangles(const std::vector<std::uint32_t>& corners, int mode) {
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    std::vector<std::uint32_t> whole(corners);
    whole.resize(corners.size() / 3 * 3);
    return whole;
  }
  std::vector<std::uint32_t> out;
  if (corners.size() < 3) return out;
  out.reserve((corners.size() - 2) * 3);
  for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
    const std::size_t odd = i % 2;
    if (mode == TINYGLTF_MODE_TRIANGLE_STRIP)
      out.insert(out.end(), {corners[i], corners[i + 1 + odd], corners[i + 2 - odd]});
    else
      out.insert(out.end(), {corners[i + 1], corners[i + 2], corners[0]});
  }
  return out;
}

class Builder {
 public:
  Builder(Document& document, const PrimitiveSource& source, const LoadLimits& limits, Usage& usage)
      : document_(document),
        source_(source),
        limits_(limits),
        usage_(usage),
        primitive_(document.model->meshes[source.mesh].primitives[source.primitive]),
        place_(fmt::format("/meshes/{}/primitives/{}", source.mesh, source.primitive)),
        directions_(direction_map(glm::dmat3(source.world))) {}

  std::optional<Mesh> build() {
    if (!is_drawable()) return std::nullopt;
    read_positions();
    read_triangles();
    if (mesh_.indices.empty()) {
      warn("has no triangles");
      return std::nullopt;
    }
    mesh_.name = source_.name;
    mesh_.material = source_.material;
    read_uv();
    make_normals();
    make_tangents();
    read_colors();
    place_in_world();
    return std::move(mesh_);
  }

 private:
  /// Once for a primitive, however many nodes place it.
  void warn(const std::string& what) {
    document_.warnings.add(fmt::format("{} '{}': {}", place_, source_.mesh_name, what));
  }

  bool is_drawable() {
    if (!primitive_.targets.empty())
      document_.warnings.add(fmt::format("{}: morph targets were ignored", place_));
    if (primitive_.mode < TINYGLTF_MODE_TRIANGLES) {
      document_.warnings.add(fmt::format("{}: {} are not drawn", place_,
                                         primitive_.mode == TINYGLTF_MODE_POINTS ? "points" : "lines"));
      return false;
    }
    if (attribute("POSITION") >= 0) return true;
    document_.warnings.add(fmt::format("{}: has no POSITION and is not drawn", place_));
    return false;
  }

  int attribute(const char* semantic) const {
    const auto found = primitive_.attributes.find(semantic);
    return found == primitive_.attributes.end() ? -1 : found->second;
  }

  std::string attribute_place(const char* semantic) const {
    return fmt::format("{}/attributes/{}", place_, semantic);
  }

  /// Empty when the primitive has no such attribute.
  std::vector<float> read(const char* semantic, int components, Storage storage) const {
    const int accessor = attribute(semantic);
    if (accessor < 0) return {};
    if (const auto count = accessor_count(document_, accessor); count != count_)
      document_.fail(attribute_place(semantic),
                     fmt::format("has {} elements, POSITION has {}", count, count_));
    return read_floats(document_, accessor, components, storage, attribute_place(semantic));
  }

  void read_positions() {
    const std::uint64_t count = accessor_count(document_, attribute("POSITION"));
    take(usage_.vertices, count, limits_.vertices, "vertices");
    count_ = count;
    const std::vector<float> values = read("POSITION", 3, Storage::Quantised);
    local_.resize(count_);
    for (std::size_t i = 0; i < count_; ++i)
      local_[i] = glm::dvec3(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
  }

  void take(std::uint64_t& used, std::uint64_t more, std::uint64_t limit, const char* what) const {
    if (more > limit - used)
      document_.fail(place_, fmt::format("the scene holds more than {} {}", limit, what),
                     "split or simplify the scene");
    used += more;
  }

  void read_triangles() {
    std::vector<std::uint32_t> corners;
    if (primitive_.indices >= 0) {
      take_triangles(accessor_count(document_, primitive_.indices));
      corners = read_indices(document_, primitive_.indices, count_, place_ + "/indices");
    } else {
      take_triangles(count_);
      corners.resize(count_);
      std::iota(corners.begin(), corners.end(), 0u);
    }
    if (primitive_.mode == TINYGLTF_MODE_TRIANGLES && corners.size() % 3 != 0)
      warn(fmt::format("{} corners are no whole number of triangles, the last {} were dropped",
                       corners.size(), corners.size() % 3));
    mesh_.indices = to_triangles(corners, primitive_.mode);
  }

  void take_triangles(std::uint64_t corners) {
    const bool list = primitive_.mode == TINYGLTF_MODE_TRIANGLES;
    take(usage_.indices, list ? corners : corners < 3 ? 0 : 3 * (corners - 2), limits_.indices, "indices");
  }

  void read_uv() {
    if (source_.needs.uv0) mesh_.uv0 = read_uv_set("TEXCOORD_0");
    if (source_.needs.uv1) mesh_.uv1 = read_uv_set("TEXCOORD_1");
  }

  std::vector<glm::vec2> read_uv_set(const char* semantic) {
    const std::vector<float> values = read(semantic, 2, Storage::Quantised);
    std::vector<glm::vec2> uv(count_, glm::vec2(0));
    if (values.empty()) {
      warn(fmt::format("its material's textures need {}, which it has not: (0, 0) was used", semantic));
      return uv;
    }
    std::size_t broken = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const bool good = finite(values[2 * i]) && finite(values[2 * i + 1]);
      if (good)
        uv[i] = glm::vec2(values[2 * i], values[2 * i + 1]);
      else
        ++broken;
    }
    if (broken > 0) warn(fmt::format("{} {} values are not finite: (0, 0) was used", broken, semantic));
    return uv;
  }

  void make_normals() {
    const std::vector<float> values = read("NORMAL", 3, Storage::FloatOrSnorm);
    std::vector<glm::dvec3> sums;
    if (values.empty()) sums = summed_face_normals(local_, mesh_.indices);
    mesh_.normals.resize(count_);
    world_normals_.resize(count_);
    std::size_t broken = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      glm::dvec3 normal(0);
      if (!values.empty()) {
        normal = unit_or_zero(glm::dvec3(values[3 * i], values[3 * i + 1], values[3 * i + 2]));
        if (normal == glm::dvec3(0)) {
          ++broken;
          if (sums.empty()) sums = summed_face_normals(local_, mesh_.indices);
        }
      }
      if (normal == glm::dvec3(0)) normal = unit_or_zero(sums[i]);
      normal = unit_or_zero(directions_.normals * normal);
      // Vertices of no or only degenerate triangles: any direction does.
      world_normals_[i] = normal == glm::dvec3(0) ? glm::dvec3(0, 1, 0) : normal;
      mesh_.normals[i] = glm::vec3(world_normals_[i]);
    }
    if (broken > 0) warn(fmt::format("{} normals are zero or not finite: the faces' were used", broken));
  }

  void make_tangents() {
    mesh_.tangents.resize(count_);
    const std::vector<float> given =
        source_.needs.tangents ? read("TANGENT", 4, Storage::FloatOrSnorm) : std::vector<float>{};
    if (!given.empty()) return take_tangents(given);
    const std::vector<glm::vec2>& uv = source_.needs.tangent_uv_set == 0 ? mesh_.uv0 : mesh_.uv1;
    if (source_.needs.tangents && !uv.empty()) return generate_tangents(uv);
    for (std::size_t i = 0; i < count_; ++i)
      mesh_.tangents[i] = glm::vec4(glm::vec3(any_tangent(world_normals_[i])), 1);
  }

  void take_tangents(const std::vector<float>& given) {
    std::size_t broken = 0;
    const double mirror = directions_.mirrors ? -1 : 1;
    for (std::size_t i = 0; i < count_; ++i) {
      const glm::dvec3 local = unit_or_zero(glm::dvec3(given[4 * i], given[4 * i + 1], given[4 * i + 2]));
      if (local == glm::dvec3(0) || !finite(given[4 * i + 3])) ++broken;
      const double w = given[4 * i + 3] < 0 ? -mirror : mirror;
      mesh_.tangents[i] = glm::vec4(glm::vec3(orthogonal_tangent(local, i)), static_cast<float>(w));
    }
    if (broken > 0) warn(fmt::format("{} tangents are zero or not finite and were replaced", broken));
  }

  void generate_tangents(const std::vector<glm::vec2>& uv) {
    std::vector<glm::dvec2> sampled(count_);
    for (std::size_t i = 0; i < count_; ++i)
      sampled[i] = source_.needs.tangent_uv_transform * glm::dvec3(uv[i], 1);
    const UvGradients gradients = summed_uv_gradients(local_, sampled, mesh_.indices);
    for (std::size_t i = 0; i < count_; ++i) {
      const glm::dvec3 tangent = orthogonal_tangent(gradients.along_u[i], i);
      const glm::dvec3 bitangent = directions_.tangents * gradients.along_v[i];
      const double w = glm::dot(glm::cross(world_normals_[i], tangent), bitangent) < 0 ? -1 : 1;
      mesh_.tangents[i] = glm::vec4(glm::vec3(tangent), static_cast<float>(w));
    }
  }

  /// A local direction in the world, made orthogonal to the vertex's normal; any tangent when nothing is left
  /// of it.
  glm::dvec3 orthogonal_tangent(const glm::dvec3& local, std::size_t vertex) const {
    const glm::dvec3& normal = world_normals_[vertex];
    const glm::dvec3 direction = unit_or_zero(directions_.tangents * local);
    const glm::dvec3 rest = direction - normal * glm::dot(normal, direction);
    // Below 1e-6 the remainder is mostly rounding error of the subtraction (1e-16 of a unit vector, floats
    // given to 1e-7).
    return glm::dot(rest, rest) > 1e-12 ? unit_or_zero(rest) : any_tangent(normal);
  }

  void read_colors() {
    const int accessor = attribute("COLOR_0");
    if (accessor < 0) return;
    const int components = accessor_components(document_, accessor) == 3 ? 3 : 4;
    const std::vector<float> values = read("COLOR_0", components, Storage::FloatOrUnorm);
    mesh_.colors.assign(count_, glm::vec4(1));
    std::size_t broken = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      for (int c = 0; c < components; ++c) {
        const float value = values[i * static_cast<std::size_t>(components) + static_cast<std::size_t>(c)];
        if (value >= 0 && value <= kLargestColor)
          mesh_.colors[i][c] = value;
        else
          ++broken;
      }
    }
    if (broken > 0)
      warn(fmt::format("{} COLOR_0 components are negative, not finite or above {}: 1 was used", broken,
                       kLargestColor));
  }

  void place_in_world() {
    if (directions_.mirrors)
      for (std::size_t i = 0; i + 2 < mesh_.indices.size(); i += 3)
        std::swap(mesh_.indices[i + 1], mesh_.indices[i + 2]);
    std::size_t broken = 0;
    for (glm::dvec3& p : local_) {
      p = glm::dvec3(source_.world * glm::dvec4(p, 1));
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) ++broken;
    }
    if (broken > 0)
      warn(fmt::format("{} positions are not finite: triangles that use them are not drawn", broken));
    mesh_.positions = std::move(local_);
  }

  Document& document_;
  const PrimitiveSource& source_;
  const LoadLimits& limits_;
  Usage& usage_;
  const tinygltf::Primitive& primitive_;
  const std::string place_;
  const DirectionMap directions_;
  Mesh mesh_;
  std::size_t count_ = 0;
  std::vector<glm::dvec3> local_, world_normals_;
};

}  // namespace

MaterialNeeds needs_of(const Material& material) {
  MaterialNeeds needs;
  for (const TextureSlot* slot :
       {&material.base_color_map, &material.metallic_roughness_map, &material.specular_glossiness_map,
        &material.normal_map, &material.occlusion_map, &material.emissive_map}) {
    if (!slot->present()) continue;
    (slot->uv_set == 0 ? needs.uv0 : needs.uv1) = true;
  }
  needs.tangents = material.normal_map.present();
  needs.tangent_uv_set = material.normal_map.uv_set;
  needs.tangent_uv_transform = material.normal_map.uv_transform;
  return needs;
}

std::optional<Mesh> build_mesh(Document& document, const PrimitiveSource& source, const LoadLimits& limits,
                               Usage& usage) {
  return Builder(document, source, limits, usage).build();
}

}  // namespace aluminate::scenes::gltf
