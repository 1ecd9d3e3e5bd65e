// aluminate compare SCENE --a k=v,.. --b k=v,.. -o DIR: two variants of one picture, what each costs, where
// they differ.
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
  std::string scene, a, b, directory;
  double budget_ms = 0;
};

void run(const Arguments& arguments, Session& session) {
  const passes::FrameOptions common = arguments.frame.resolve();
  passes::FrameOptions options_a = common, options_b = common;
  passes::set_options(options_a, arguments.a);
  passes::set_options(options_b, arguments.b);
  if (options_a.width != options_b.width || options_a.height != options_b.height)
    throw UserError("A and B have different sizes", "give --size once, for both");

  const scenes::Scene scene = scenes::load_scene(arguments.scene);
  for (const std::string& warning : scene.warnings) host::warning(warning);
  host::make_directories(arguments.directory);
  host::OutputSet outputs;
  std::vector<host::OutputFile*> files;
  for (const std::string& name : report::comparison_file_names())
    files.push_back(&outputs.add(arguments.directory + "/" + name));

  report::Billed a = report::render_and_bill(scene, options_a, arguments.budget_ms, 1);
  report::Billed b = report::render_and_bill(scene, options_b, arguments.budget_ms, 1);
  a.name = arguments.a;
  b.name = arguments.b;
  for (const std::string& warning : a.frame.warnings) host::warning(warning);
  for (const std::string& warning : b.frame.warnings) host::warning(warning);
  const report::ImageDifference difference =
      report::compare_images(a.frame.width, a.frame.rgba8, b.frame.rgba8);
  const std::vector<report::ComparisonFile> contents = report::comparison_files(a, b, difference);
  for (std::size_t i = 0; i < files.size(); ++i) files[i]->write(contents[i].bytes);
  outputs.commit();
  fmt::print("{}\nwritten to {}: {}\n", report::compare_text(a, b, difference), arguments.directory,
             fmt::join(report::comparison_file_names(), " "));
  const bool over = arguments.budget_ms > 0 && (!a.budget.fits || !b.budget.fits);
  session.exit_code = report::hurts(a, b) || over ? kAnswerIsNo : kDone;
}

}  // namespace

void add_compare(CLI::App& app, Session& session) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "compare", "draw a scene under two variants; exit 1 when B costs more than A (HURT)");
  command->footer(
      "Example:\n  aluminate compare helmet.glb --a visibility=schlick-smith --b visibility=cheap --lights "
      "rig:4 -o out");
  command->add_option("SCENE", arguments->scene, ".gltf or .glb")->required();
  command->add_option("--a", arguments->a, "options of A, key=value,key=value (keys: the option names below)")
      ->required();
  command->add_option("--b", arguments->b, "options of B")->required();
  command
      ->add_option("-o,--output", arguments->directory, "folder for pictures, heat maps, EXR layers and JSON")
      ->required();
  command
      ->add_option("--budget", arguments->budget_ms,
                   "console milliseconds a frame may take: exit 1 when one does not fit")
      ->check(CLI::PositiveNumber)
      ->type_name("MS");
  arguments->frame.add_to(*command);
  command->callback([arguments, &session] { run(*arguments, session); });
}

}  // namespace aluminate::apps
