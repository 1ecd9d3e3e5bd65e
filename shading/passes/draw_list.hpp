// A scene as the console would be given it: programs compiled, prepared and priced, constants on the grid,
// textures decoded, draws in submission order (opaque, then alpha-tested, then blended from far to near).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "platform/console/gpu_model.hpp"
#include "rasterizer/draw.hpp"
#include "scenes/light_rig.hpp"
#include "scenes/normalised_space.hpp"
#include "scenes/scene.hpp"
#include "scenes/view.hpp"
#include "shading/cost/static_cost.hpp"
#include "shading/passes/frame.hpp"
#include "shading/passes/programs.hpp"
#include "shading/passes/textures.hpp"
#include "shading/passes/uniforms.hpp"
#include "shading/passes/vertex_stage.hpp"
#include "shading/vm/executable.hpp"

namespace aluminate::passes {

/// Where one input row of a pixel program comes from.
struct InputRow {
  enum class Kind : std::uint8_t { Varying, Face, PixelX, PixelY, Zero, One } kind = Kind::Varying;
  int varying = 0;
};

struct PixelProgram {
  vm::Program program;
  vm::Executable executable;
  cost::StaticCost cost;
  PathInfo path;  // cost of one run of one lane
  std::vector<Varying> varyings;
  std::vector<InputRow> inputs;         // one per Executable::inputs()
  int color_row[4] = {-1, -1, -1, -1};  // output rows of COLOR0
  bool straight_line = true;
};

enum class Surface : std::uint8_t { Opaque, Masked, Blended };

struct DrawState {
  const scenes::Mesh* mesh = nullptr;
  const scenes::Material* material = nullptr;
  int pixel_program = 0, vertex_program = 0;
  Surface surface = Surface::Opaque;
  std::vector<double> constants;  // of the pixel program, on the grid
  std::vector<vm::SamplerBinding> samplers;
  std::size_t first_vertex = 0;  // in the frame's vertex arrays
  std::size_t first_varying = 0;
};

struct DrawList {
  console::GpuModel gpu;
  number::NumberFormat format;
  scenes::NormalisedSpace space;
  scenes::View view;
  scenes::LightSet lights;
  TextureSet textures;
  std::vector<PixelProgram> pixel_programs;
  std::vector<VertexProgram> vertex_programs;
  std::vector<cost::StaticCost> vertex_costs;
  std::vector<DrawState> draws;
  std::vector<raster::Draw> raster_draws;  // parallel to draws
  std::vector<std::uint32_t> indices;
  std::size_t vertex_count = 0, varying_count = 0;
  std::uint64_t sanitised_constants = 0;
  std::vector<std::string> warnings;
};

/// Throws UserError for a camera, platform, shader or texture that cannot be used.
DrawList make_draw_list(const scenes::Scene& scene, const FrameOptions& options);

}  // namespace aluminate::passes
