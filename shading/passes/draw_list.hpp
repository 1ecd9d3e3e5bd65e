// A scene as the console would be given it: programs compiled, prepared and priced, constants on the grid,
// textures decoded, draws in submission order (opaque, then alpha-tested, then what is not lit by a G-buffer,
// then blended from far to near).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "platform/console/gpu_model.hpp"
#include "rasterizer/draw.hpp"
#include "rasterizer/interpolate.hpp"
#include "scenes/light_rig.hpp"
#include "scenes/normalised_space.hpp"
#include "scenes/scene.hpp"
#include "scenes/view.hpp"
#include "shading/cost/static_cost.hpp"
#include "shading/passes/frame.hpp"
#include "shading/passes/programs.hpp"
#include "shading/passes/reflections.hpp"
#include "shading/passes/textures.hpp"
#include "shading/passes/uniforms.hpp"
#include "shading/passes/vertex_stage.hpp"
#include "shading/vm/executable.hpp"

namespace aluminate::passes {

inline constexpr std::size_t kMaxTargets = 4;

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
  std::vector<InputRow> inputs;  // one per Executable::inputs()
  std::vector<raster::AttributeRow> attributes;  // those of them that are varyings
  /// Output rows of COLOR0..3 by target and component; -1: not written.
  std::array<std::array<int, 4>, kMaxTargets> color_row{};
  bool straight_line = true;
};
/// assumptions: what its fetches are priced as; surfaces sample mipmapped textures, screen passes read one texel.
PixelProgram make_pixel_program(vm::Program program, const number::NumberFormat& format,
                                const console::GpuModel& gpu,
                                const cost::Assumptions& assumptions = {
                                    .filter = cost::FilterAssumption::Trilinear});

/// The passes of a frame, in the order they are reported.
enum class Pass : std::uint8_t { Gbuffer, Sun, Lights, Dome, Forward };
inline constexpr std::size_t kPassCount = 5;
std::string_view to_string(Pass pass);

enum class Surface : std::uint8_t { Opaque, Masked, Blended };

struct DrawState {
  const scenes::Mesh* mesh = nullptr;
  const scenes::Material* material = nullptr;
  int pixel_program = 0, vertex_program = 0;
  Surface surface = Surface::Opaque;
  Pass pass = Pass::Forward;
  std::vector<double> constants;  // of the pixel program, on the grid
  double constant_bound = 0;      // the greatest magnitude among them
  std::vector<vm::SamplerBinding> samplers;
  std::size_t first_vertex = 0;  // in the frame's vertex arrays
  std::size_t first_varying = 0;
};

/// A screen-filling draw over the G-buffer as the console would make it; billed, see light_plan.hpp for what
/// runs.
struct ScreenDraw {
  std::string name;  // "ambient + rig 0..3", "lamp 5"
  Pass pass = Pass::Sun;
  int pixel_program = 0;
  bool blended = true;  // added to what is in the light buffer
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
  std::vector<Pass> vertex_passes;  // which pass a vertex program belongs to
  std::vector<DrawState> draws;
  std::vector<ScreenDraw> screen_draws;
  std::unique_ptr<scenes::Mesh> dome;  // of the dome's draw: one triangle, uv in NDC
  ShadowPlan shadows;
  std::unique_ptr<vm::Texture> shadow_atlas;  // where `shadows` is drawn; null without
  std::unique_ptr<ToksvigSet> toksvig;
  std::unique_ptr<Reflections> reflections;  // draws point into it; null without
  FrameUniforms uniforms;
  int gbuffer_targets = 0;                 // 32-bit colour targets; 0: no G-buffer
  std::vector<raster::Draw> raster_draws;  // parallel to draws
  std::vector<std::uint32_t> indices;
  std::size_t vertex_count = 0, varying_count = 0;
  std::uint64_t sanitised_constants = 0;
  std::vector<std::string> warnings;
};

/// What a sampler that belongs to the frame and to no material reads; no value for other names.
std::optional<vm::SamplerBinding> frame_sampler(const DrawList& list, std::string_view name);

/// Throws UserError for a camera, platform, shader or texture that cannot be used.
DrawList make_draw_list(const scenes::Scene& scene, const FrameOptions& options);

}  // namespace aluminate::passes
