#include "shading/passes/reflections.hpp"

#include <algorithm>
#include <cmath>

#include "shading/sky/sun.hpp"

namespace aluminate::passes {
namespace {

double snapped(double x) { return std::nearbyint(x * 0x1p20) * 0x1p-20; }

void light_sky(const sky::Sky& sky, const glm::dvec3& polarizer, CubeMap& map) {
  const int size = map.seen.size;
  for (int face = 0; face < 6; ++face)
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const std::size_t i = map.seen.index(face, x, y);
        glm::dvec4& texel = map.seen.texels[i];
        if (texel.w == 0.0) continue;
        const glm::dvec3 seen =
            sky::extended_radiance(sky, sky::world_to_z_up(filter::cube_direction(face, x, y, size)));
        for (int c = 0; c < 3; ++c)
          texel[c] =
              std::min(map.surface[i][c] + texel.w * snapped(seen[c]) * polarizer[c], kGreatestCaptured);
      }
}

std::uint16_t code(double value) { return static_cast<std::uint16_t>(value * 65535.0 + 0.5); }

}  // namespace

Reflections make_reflections(CubeMap map, const std::optional<SkySetup>& sky, const glm::dvec3& polarizer) {
  if (sky) light_sky(sky->sky, polarizer, map);
  // Filtered values are means: none exceeds the greatest of the capture but by rounding.
  double greatest = 0;
  for (const glm::dvec4& texel : map.seen.texels) greatest = std::max({greatest, texel.x, texel.y, texel.z});
  double range = 1;
  while (range < greatest) range *= 2;
  const int size = map.seen.size;
  std::vector<vm::MipLevel> levels;
  for (const filter::CubeLevel& level : filter::prefilter(std::move(map.seen))) {
    vm::MipLevel mip{level.size, level.size, 6, {}, {}};
    mip.codes16.reserve(4 * level.texels.size());
    for (const glm::dvec4& texel : level.texels)
      for (int c = 0; c < 4; ++c)
        mip.codes16.push_back(code(std::min(texel[c] / (c < 3 ? range : 1.0), 1.0)));
    levels.push_back(std::move(mip));
  }
  return {vm::Texture::from_levels(vm::TextureShape::Cube, std::move(levels), false),
          {range, filter::cube_level_bias(size), 0, 0}};
}

Reflections load_reflections(const std::string& path, const std::optional<SkySetup>& sky,
                             const glm::dvec3& polarizer) {
  return make_reflections(read_cube_map(path), sky, polarizer);
}

}  // namespace aluminate::passes
