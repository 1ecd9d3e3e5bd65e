// aluminate render SCENE -o IMG [--cost COST.exr] [--json F] [--frames K] [--budget MS]: a picture and its
// bill.
#include <fmt/format.h>

#include "apps/session.hpp"
#include "platform/host/error.hpp"
#include "platform/host/log.hpp"
#include "platform/host/output_file.hpp"
#include "scenes/loader.hpp"
#include "shading/report/job.hpp"

namespace aluminate::apps {
namespace {

struct Arguments {
  FrameArguments frame;
  std::string scene, image, cost, json;
  int frames = 1;
  double budget_ms = 0;
};

void run(const Arguments& arguments, Session& session) {
  report::check_image_path(arguments.image);
  if (!arguments.cost.empty() && !arguments.cost.ends_with(".exr"))
    throw UserError(fmt::format("{}: cost layers are written as .exr", arguments.cost));
  const passes::FrameOptions options = arguments.frame.resolve();
  host::OutputSet outputs;
  host::OutputFile& image = outputs.add(arguments.image);
  host::OutputFile* cost = arguments.cost.empty() ? nullptr : &outputs.add(arguments.cost);
  host::OutputFile* json =
      arguments.json.empty() || arguments.json == "-" ? nullptr : &outputs.add(arguments.json);

  const scenes::Scene scene = scenes::load_scene(arguments.scene);
  for (const std::string& warning : scene.warnings) host::warning(warning);
  const report::Billed billed =
      report::render_and_bill(scene, options, arguments.budget_ms, arguments.frames);
  for (const std::string& warning : billed.frame.warnings) host::warning(warning);

  image.write(report::encode_picture(arguments.image, billed));
  if (cost) cost->write(report::encode_cost_layers(billed));
  if (json) json->write(report::render_json(billed));
  outputs.commit();
  fmt::print("{}", arguments.json == "-" ? report::render_json(billed) : report::render_text(billed));
  if (arguments.budget_ms > 0 && !billed.budget.fits) session.exit_code = kAnswerIsNo;
}

}  // namespace

void add_render(CLI::App& app, Session& session) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("render", "draw a scene and write its bill");
  command->footer(
      "Examples:\n  aluminate render scenes/samples/material_wall.gltf -o wall.png\n"
      "  aluminate render helmet.glb -o helmet.png --lights rig:4 --cost helmet_cost.exr --json helmet.json");
  command->add_option("SCENE", arguments->scene, ".gltf or .glb")->required();
  command
      ->add_option("-o,--output", arguments->image, "picture: .png (display values) or .exr (linear light)")
      ->required();
  command->add_option("--cost", arguments->cost, "per-pixel cost layers, .exr");
  command->add_option("--json", arguments->json, "the bill as JSON ('-': on stdout instead of the table)");
  command->add_option("--frames", arguments->frames, "render K times and report the times")
      ->check(CLI::Range(1, 1000))
      ->type_name("K");
  command
      ->add_option("--budget", arguments->budget_ms,
                   "console milliseconds the frame may take: exit 1 when it does not fit")
      ->check(CLI::PositiveNumber)
      ->type_name("MS");
  arguments->frame.add_to(*command);
  command->callback([arguments, &session] { run(*arguments, session); });
}

}  // namespace aluminate::apps
