// Draws that cannot be seen because the bounds of their mesh lie outside the view: their vertices are not
// shaded, their triangles only counted. The bill keeps both.
#pragma once

#include "shading/passes/draw_list.hpp"

namespace aluminate::passes {

/// Sets Draw::outside where every position lies beyond one side of the view volume, with room for the
/// rounding of the vertex program. Draws that hold a position that is not finite are left alone, and all are
/// where the number format could saturate on the way.
void mark_draws_outside(DrawList& list);

/// What a straight-line vertex program would have counted for the vertices of a draw that is outside.
void count_unshaded_vertices(std::size_t vertices, vm::Counters& counters);

}  // namespace aluminate::passes
