#include "rasterizer/screen_vertex.hpp"

namespace aluminate::raster {

void project_vertices(const ScreenMap& map, const ClipPositions& positions, std::size_t begin, std::size_t end,
                      ScreenVertex* out) {
  for (std::size_t i = begin; i < end; ++i)
    out[i] = project_vertex(map, positions.x[i], positions.y[i], positions.z[i], positions.w[i]);
}

}  // namespace aluminate::raster
