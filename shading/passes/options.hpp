// Everything a user may choose about a frame, as values. set_option() is the only place that knows option
// names: the command line, `compare --a k=v` and checks all go through it.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "shading/brdf/fresnel.hpp"
#include "shading/brdf/visibility.hpp"

namespace aluminate::passes {

enum class Pipeline { Forward, Deferred };
enum class Tonemap { None, Reinhard, Filmic };
enum class AmbientKind { None, Flat, Sky, Hemisphere };
enum class LightLoop { Auto, Rolled, Unrolled };  // Auto: unrolled up to kUnrolledLights lights
enum class ToksvigMode { Off, Texture, Dxt5, Material };
enum class TextureStorage { Rgba8, Dxt };
enum class VmTier { Auto, Interpreter, Jit };

/// Loops of up to this many lights are unrolled by default, as console-era engines did; beyond, 512 ps_3_0
/// slots would not hold the shader.
inline constexpr int kUnrolledLights = 8;

/// Names of the skips that `--no-skip` turns off (design: what a scene does not need is skipped and counted).
/// The first eight are the rasterizer's; "mesh_bounds" leaves out draws whose bounds lie outside the view,
/// "textures" decodes only the images that a draw samples, "tile_lights" leaves bounded lights out of tiles
/// they do not reach.
inline constexpr std::string_view kSkipNames[] = {"frustum",     "facing",   "small",       "tile_hiz",
                                                  "block_hiz",   "early_z",  "empty_tiles", "occluded",
                                                  "mesh_bounds", "textures", "tile_lights", "shadow_casters"};

struct FrameOptions {
  int width = 1280, height = 720;
  int msaa = 1;  // samples a pixel, 1 or 4
  std::string camera = "auto";
  std::string lights;  // empty: "scene" when the file has lights, else "rig:4"
  AmbientKind ambient = AmbientKind::Flat;
  double ambient_value = 0.03;
  glm::dvec3 background{0.05, 0.06, 0.08};  // stored display values
  Pipeline pipeline = Pipeline::Forward;
  std::string sky = "none";    // none, 1..15, fc3 or a,b,c,d,e
  std::string time = "15:00";  // HH:MM; empty when `sun` was given
  std::string sun;             // elevation,azimuth in degrees
  glm::dvec3 polarizer{1};     // factor on what is seen of the sky
  brdf::Visibility visibility = brdf::Visibility::SchlickSmith;
  brdf::Fresnel fresnel = brdf::Fresnel::Schlick;
  Tonemap tonemap = Tonemap::None;
  std::string number = "fx31";
  std::string platform = "xenos";
  std::string shader;  // user's pixel shader; empty: forward_lit.hlsl
  std::vector<std::pair<std::string, std::string>> defines;
  LightLoop light_loop = LightLoop::Auto;
  VmTier vm = VmTier::Auto;
  std::set<std::string, std::less<>> no_skip;
  ToksvigMode toksvig = ToksvigMode::Off;
  TextureStorage textures = TextureStorage::Rgba8;
  int anisotropy = 1;  // most samples a fetch of a surface's map takes along its longer axis
  bool shadows = false;
  std::string reflections;   // captured cube map, see reflections.hpp; empty: none
  bool dome = true;          // false: the sky lights but is not drawn; captures only, no option sets it
  bool checked = false;  // name every instruction that saturated

  bool has_sky() const { return sky != "none"; }
  bool has_reflections() const { return !reflections.empty(); }
};

struct OptionInfo {
  std::string_view name, values, help;
};

/// The options set_option() knows, in the order they are documented.
const std::vector<OptionInfo>& option_table();

/// Sets one option from text. Throws UserError naming the option, what was expected, and the nearest known
/// name.
void set_option(FrameOptions& options, std::string_view key, std::string_view value);

/// "visibility=cheap,fresnel=sg" applied in order.
void set_options(FrameOptions& options, std::string_view assignments);

std::string_view to_string(Pipeline);
std::string_view to_string(Tonemap);
std::string_view to_string(LightLoop);
std::string_view to_string(ToksvigMode);
std::string_view to_string(TextureStorage);
/// "flat:0.03", "sky", "hemisphere" or "none".
std::string ambient_text(const FrameOptions& options);

}  // namespace aluminate::passes
