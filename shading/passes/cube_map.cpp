#include "shading/passes/cube_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "platform/host/error.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/input_file.hpp"
#include "scenes/normalised_space.hpp"
#include "scenes/scene.hpp"
#include "scenes/view.hpp"
#include "shading/passes/renderer.hpp"
#include "shading/passes/view_rays.hpp"

namespace aluminate::passes {
namespace {

constexpr const char* kChannels[7] = {"R", "G", "B", "A", "surface.R", "surface.G", "surface.B"};

// The three pictures of a face.
struct FacePictures {
  Frame whole, black, white;
  scenes::View view;
};

FacePictures draw_face(const scenes::Scene& scene, FrameOptions options, const glm::dvec3& eye, int face) {
  constexpr glm::dvec3 kTowards[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  const scenes::NormalisedSpace space = scenes::normalised_space(scene);
  const glm::dvec3 target = eye + kTowards[face] * space.radius_world;
  options.camera = fmt::format("{},{},{}:{},{},{}:90", eye.x, eye.y, eye.z, target.x, target.y, target.z);
  FacePictures pictures;
  pictures.whole = render_frame(scene, options);
  options.dome = false;
  options.background = glm::dvec3(0);
  pictures.black = render_frame(scene, options);
  options.background = glm::dvec3(1);
  pictures.white = render_frame(scene, options);
  pictures.view = scenes::make_view(scene, space, scenes::parse_camera(options.camera), 1.0);
  return pictures;
}

glm::dvec3 captured(const Frame& frame, std::size_t pixel) {
  const float* rgb = &frame.linear[4 * pixel];
  return glm::clamp(glm::dvec3(rgb[0], rgb[1], rgb[2]), 0.0, kGreatestCaptured);
}

// Pixels of the pictures into texels of the face. Both grids are the same square seen from the same point, so
// that the middle of each finer texel is the middle of a pixel, whichever way the camera is turned.
void store_face(const FacePictures& pictures, int face, CubeMap& map) {
  const int size = map.seen.size, fine = size * kCaptureSamples;
  const ViewRays rays(pictures.view);
  for (int y = 0; y < fine; ++y)
    for (int x = 0; x < fine; ++x) {
      const glm::dvec3 d = filter::cube_direction(face, x, y, fine);
      const double ahead = glm::dot(d, rays.forward);
      const double u = glm::dot(d, rays.right) / (ahead * glm::dot(rays.right, rays.right)),
                   v = glm::dot(d, rays.up) / (ahead * glm::dot(rays.up, rays.up));
      const auto place = [fine](double ndc) {
        return static_cast<std::size_t>(std::clamp(static_cast<int>((ndc + 1) * 0.5 * fine), 0, fine - 1));
      };
      const std::size_t pixel = place(-v) * static_cast<std::size_t>(fine) + place(u);
      const glm::dvec3 surface = captured(pictures.black, pixel);
      const double sky = std::clamp(
          double{pictures.white.linear[4 * pixel]} - double{pictures.black.linear[4 * pixel]}, 0.0, 1.0);
      constexpr double kShare = 1.0 / (kCaptureSamples * kCaptureSamples);
      const std::size_t texel = map.seen.index(face, x / kCaptureSamples, y / kCaptureSamples);
      map.seen.texels[texel] += glm::dvec4(captured(pictures.whole, pixel), sky) * kShare;
      map.surface[texel] += surface * kShare;
    }
}

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw UserError(fmt::format("{}: {}", path, what),
                  "captured cube maps are made by: aluminate cubemap SCENE -o " + path);
}

}  // namespace

CubeMap capture_cube_map(const scenes::Scene& scene, const FrameOptions& options,
                         const CaptureRequest& request) {
  ALU_CHECK(filter::is_cube_size(request.face_px), "face of {} texels", request.face_px);
  CubeMap map;
  map.seen.size = request.face_px;
  const std::size_t texels =
      6 * static_cast<std::size_t>(request.face_px) * static_cast<std::size_t>(request.face_px);
  map.seen.texels.assign(texels, glm::dvec4(0));
  map.surface.assign(texels, glm::dvec3(0));
  FrameOptions of_face = options;
  of_face.width = of_face.height = request.face_px * kCaptureSamples;
  of_face.msaa = 1;
  of_face.reflections.clear();
  of_face.tonemap = Tonemap::None;
  const glm::dvec3 eye = request.at_given ? request.at : scenes::normalised_space(scene).centre;
  for (int face = 0; face < 6; ++face) store_face(draw_face(scene, of_face, eye, face), face, map);
  return map;
}

std::vector<std::uint8_t> encode_cube_map(const CubeMap& map, const std::vector<filter::CubeLevel>& chain) {
  const int width = 6 * map.seen.size, height = 2 * map.seen.size - 1;
  std::array<std::vector<float>, 7> planes;
  for (std::vector<float>& plane : planes)
    plane.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  int top = 0;
  for (std::size_t k = 0; k < chain.size(); ++k) {
    const filter::CubeLevel& level = chain[k];
    for (int face = 0; face < 6; ++face)
      for (int y = 0; y < level.size; ++y)
        for (int x = 0; x < level.size; ++x) {
          const std::size_t pixel = static_cast<std::size_t>(top + y) * static_cast<std::size_t>(width) +
                                    static_cast<std::size_t>(face * level.size + x);
          const std::size_t texel = level.index(face, x, y);
          for (int c = 0; c < 4; ++c)
            planes[static_cast<std::size_t>(c)][pixel] = static_cast<float>(level.texels[texel][c]);
          for (int c = 0; k == 0 && c < 3; ++c)
            planes[static_cast<std::size_t>(4 + c)][pixel] = static_cast<float>(map.surface[texel][c]);
        }
    top += level.size;
  }
  std::vector<host::ExrLayer> layers;
  for (std::size_t c = 0; c < planes.size(); ++c)
    layers.push_back({kChannels[c], std::span<const float>(planes[c])});
  return host::encode_exr(width, height, layers);
}

CubeMap read_cube_map(const std::string& path) {
  const host::ImageFloat image = host::read_image(path);
  const int size = image.width / 6;
  if (!filter::is_cube_size(size) || image.width != 6 * size || image.height != 2 * size - 1)
    refuse(path, fmt::format("{} x {} pixels are no captured cube map", image.width, image.height));
  std::array<std::size_t, 7> channel{};
  for (std::size_t c = 0; c < channel.size(); ++c) {
    const int found = image.channel(kChannels[c]);
    if (found < 0) refuse(path, fmt::format("no channel '{}': not a captured cube map", kChannels[c]));
    channel[c] = static_cast<std::size_t>(found);
  }
  CubeMap map;
  map.seen.size = size;
  map.seen.texels.resize(6 * static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  map.surface.resize(map.seen.texels.size());
  for (int face = 0; face < 6; ++face)
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                                  static_cast<std::size_t>(face * size + x);
        const auto value = [&](std::size_t c, double greatest) {
          const double v = image.texels[pixel * image.channels.size() + channel[c]];
          if (!(v >= 0 && v <= greatest))
            refuse(path, fmt::format("face {} texel {},{}: {} is {}, expected 0 to {}", face, x, y,
                                     kChannels[c], v, greatest));
          return v;
        };
        const std::size_t texel = map.seen.index(face, x, y);
        map.seen.texels[texel] = {value(0, kGreatestCaptured), value(1, kGreatestCaptured),
                                  value(2, kGreatestCaptured), value(3, 1)};
        map.surface[texel] = {value(4, kGreatestCaptured), value(5, kGreatestCaptured),
                              value(6, kGreatestCaptured)};
      }
  return map;
}

}  // namespace aluminate::passes
