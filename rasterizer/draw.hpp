// What the rasterizer is given: clip-space positions as the vertex programs left them, and draws in submission order.
// It knows neither materials nor attributes; a draw is named by its position in the list.
#pragma once

#include <cstdint>
#include <span>

#include "rasterizer/limits.hpp"
#include "rasterizer/skip.hpp"
#include "rasterizer/viewport.hpp"

namespace aluminate::raster {

/// Homogeneous positions, one array per component, equal sizes. Direct3D clip space: inside is -w <= x <= w,
/// -w <= y <= w, 0 <= z <= w, y up. The depth test is LESS against a buffer cleared to the far plane, so a surface exactly
/// on it (z = w) is inside and still not seen, as in Direct3D and OpenGL with these settings. Any binary64 value is legal input; NaN and infinities drop their triangles.
struct ClipPositions {
  std::span<const double> x, y, z, w;
};

enum class CullMode : std::uint8_t { None, Back, Front };  // front = counter-clockwise with y up (glTF)

enum class DrawClass : std::uint8_t {
  Opaque,   // coverage is the triangle's, shading has no say: visibility first, each visible pixel is shaded once
  InOrder,  // the shader decides coverage or colour depends on order: alpha test, blending, data-dependent flow
};

struct Draw {
  std::uint32_t first_index = 0;     // into FrameInput::indices
  std::uint32_t triangle_count = 0;  // 3 indices each
  std::uint32_t first_vertex = 0;    // added to every index
  CullMode cull = CullMode::Back;
  DrawClass draw_class = DrawClass::Opaque;
  bool depth_write = true;           // Opaque draws must write depth
  bool outside = false;              // the caller has proved that nothing of it is in the view volume: its positions are not
                                     // read, its triangles only counted
  bool execute_billed = false;       // InOrder: the shader also runs quads the console shades in vain (its cost depends
                                     // on data, so that the bill needs the execution); such quads come with visible = 0
};

/// One frame. Every span must stay alive and unchanged as long as the Frame made from it is used.
/// Opaque draws come before InOrder draws; the order of the list is the order the console would see.
struct FrameInput {
  Viewport viewport;
  ClipPositions positions;
  std::span<const std::uint32_t> indices;
  std::span<const Draw> draws;
  SkipSet skips;                     // defaults to all on
  int samples = 1;                   // per pixel: 1 or 4 (samples.hpp)
};

/// Position in submission order over all draws, or a fragment of a clipped triangle (limits.hpp). 0xffffffff = none.
using TriangleId = std::uint32_t;

}  // namespace aluminate::raster
