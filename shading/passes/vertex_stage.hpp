// Vertices through the VM: world-space attributes in, clip positions and varyings out. Billed like any other
// program.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/normalised_space.hpp"
#include "scenes/scene.hpp"
#include "shading/vm/executable.hpp"

namespace aluminate::passes {

/// One component of a pixel shader input that comes from the vertex shader.
struct Varying {
  std::string semantic;  // "TEXCOORD0"
  int component = 0;
  bool operator==(const Varying&) const = default;
};

/// A vertex program ready to run, with where each output goes.
struct VertexProgram {
  vm::Program program;
  vm::Executable executable;
  std::vector<double> constants;  // on the grid
};

/// Where the vertices of one mesh go: arrays of the whole frame, already at this mesh's place. varyings: one
/// run of `wanted.size()` doubles a vertex, so that interpolating a triangle reads three short runs.
struct VertexTarget {
  double *x = nullptr, *y = nullptr, *z = nullptr, *w = nullptr;  // clip space
  double* varyings = nullptr;
};

/// Shades every vertex of `mesh` on all threads. Throws UserError when `wanted` holds a varying that the
/// vertex program does not write. Adds to `counters` (shaped by the program's executable).
void shade_vertices(const VertexProgram& program, const scenes::Mesh& mesh,
                    const scenes::NormalisedSpace& space, const std::vector<Varying>& wanted,
                    const VertexTarget& target, vm::Counters& counters);

}  // namespace aluminate::passes
