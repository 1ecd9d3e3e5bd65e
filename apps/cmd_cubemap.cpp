// aluminate cubemap SCENE -o OUT.exr: the surroundings of a point, filtered by gloss, for `render
// --reflections`.
#include <fmt/format.h>

#include <vector>

#include "apps/session.hpp"
#include "platform/host/error.hpp"
#include "platform/host/log.hpp"
#include "platform/host/output_file.hpp"
#include "scenes/loader.hpp"
#include "shading/passes/cube_map.hpp"
#include "shading/report/cubemap_report.hpp"

namespace aluminate::apps {
namespace {

struct Arguments {
  std::string scene, output;
  std::vector<double> at;  // nothing or three
  passes::CaptureRequest request;
  FrameArguments frame;
};

void run(Arguments& a) {
  const passes::FrameOptions options = a.frame.resolve();
  if (!a.output.ends_with(".exr"))
    throw UserError(fmt::format("{}: cube maps are written as .exr", a.output), "light exceeds 1");
  if (!filter::is_cube_size(a.request.face_px))
    throw UserError(fmt::format("--face: expected 16, 32, 64 or 128, got {}", a.request.face_px));
  if (!a.at.empty()) {
    a.request.at = {a.at[0], a.at[1], a.at[2]};
    a.request.at_given = true;
  }
  host::OutputFile output(a.output);
  const scenes::Scene scene = scenes::load_scene(a.scene);
  for (const std::string& warning : scene.warnings) host::warning(warning);
  const passes::CubeMap map = passes::capture_cube_map(scene, options, a.request);
  const auto chain = filter::prefilter(map.seen);
  output.write(passes::encode_cube_map(map, chain));
  output.commit();
  fmt::print("{}", report::cubemap_text(chain));
}

}  // namespace

void add_cubemap(CLI::App& app, Session&) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("cubemap", "capture the surroundings of a point as a cube map");
  command->footer(
      "Example:\n  aluminate cubemap scenes/samples/beach_hut.gltf --sky fc3 --ambient sky -o hut_cube.exr\n"
      "  aluminate render scenes/samples/beach_hut.gltf --sky fc3 --ambient sky --reflections hut_cube.exr "
      "-o hut.png");
  command->add_option("SCENE", a->scene, ".gltf or .glb")->required();
  command->add_option("-o,--output", a->output, "six faces side by side, levels one below the other, .exr")
      ->required();
  command->add_option("--at", a->at, "point to look around from, world units (the middle of the scene)")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  command->add_option("--face", a->request.face_px, "texels along an edge: 16, 32, 64 or 128 (64)")
      ->type_name("N");
  a->frame.add_to(*command, {"lights", "ambient", "sky", "time", "sun", "polarizer", "background", "pipeline",
                             "visibility", "fresnel", "toksvig", "shadows", "number", "shader", "vm", "D"});
  command->callback([a] { run(*a); });
}

}  // namespace aluminate::apps
