// aluminate pixel SCENE X,Y: who touched a pixel, what it cost, and each instruction with its value.
#include <fmt/format.h>

#include <cstdio>

#include "apps/session.hpp"
#include "platform/host/error.hpp"
#include "platform/host/log.hpp"
#include "scenes/loader.hpp"
#include "shading/passes/inspect.hpp"

namespace aluminate::apps {
namespace {

struct Arguments {
  FrameArguments frame;
  std::string scene, position;
};

void run(const Arguments& arguments) {
  int x = 0, y = 0, read = 0;
  if (std::sscanf(arguments.position.c_str(), "%d,%d%n", &x, &y, &read) != 2 ||
      static_cast<std::size_t>(read) != arguments.position.size())
    throw UserError(fmt::format("expected a pixel X,Y, got '{}'", arguments.position), "for example 640,360");
  const passes::FrameOptions options = arguments.frame.resolve();
  const scenes::Scene scene = scenes::load_scene(arguments.scene);
  for (const std::string& warning : scene.warnings) host::warning(warning);
  fmt::print("{}", passes::pixel_text(passes::inspect_pixel(scene, options, x, y)));
}

}  // namespace

void add_pixel(CLI::App& app, Session&) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("pixel", "every draw that touched a pixel, each instruction with its value");
  command->footer("Example:\n  aluminate pixel scenes/samples/material_wall.gltf 640,360 --visibility cheap");
  command->add_option("SCENE", arguments->scene, ".gltf or .glb")->required();
  command->add_option("PIXEL", arguments->position, "X,Y from 0,0 at the top left")->required();
  arguments->frame.add_to(*command);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace aluminate::apps
