// aluminate scene list | info FILE | validate FILE: what is in a scene, and what is wrong with it.
#include <fmt/format.h>

#include "apps/session.hpp"
#include "platform/host/text_table.hpp"
#include "scenes/catalogue.hpp"
#include "scenes/loader.hpp"
#include "scenes/scene_info.hpp"

namespace aluminate::apps {
namespace {

void list_scenes() {
  host::TextTable table({{"scene"}, {"file"}, {"what it shows"}});
  for (const scenes::SampleScene& sample : scenes::sample_scenes())
    table.add_row({std::string(sample.name), std::string(sample.file), std::string(sample.description)});
  fmt::print("{}", table.text());
}

void show_info(const std::string& file, bool json) {
  const scenes::SceneInfo info = scenes::scene_info(scenes::load_scene(file));
  fmt::print("{}", json ? scenes::scene_info_json(info) : scenes::scene_info_text(info));
}

void validate(const std::string& file, Session& session) {
  const std::vector<std::string> warnings = scenes::validate_scene(file);
  for (const std::string& warning : warnings) fmt::print("{}\n", warning);
  if (warnings.empty()) fmt::print("{}: no warnings\n", file);
  session.exit_code = warnings.empty() ? kDone : kAnswerIsNo;
}

}  // namespace

void add_scene(CLI::App& app, Session& session) {
  struct Arguments {
    std::string file;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("scene", "list the sample scenes, describe or validate a scene");
  command->require_subcommand(1);
  command->add_subcommand("list", "the scenes that come with aluminate")->callback([] { list_scenes(); });
  CLI::App* info = command->add_subcommand("info", "triangles, materials, images, cameras, lights, warnings");
  info->add_option("FILE", arguments->file, ".gltf or .glb")->required();
  info->add_flag("--json", arguments->json, "as JSON");
  info->callback([arguments] { show_info(arguments->file, arguments->json); });
  CLI::App* check =
      command->add_subcommand("validate", "every warning, one a line; exit 0 clean, 1 with warnings");
  check->add_option("FILE", arguments->file, ".gltf or .glb")->required();
  check->callback([arguments, &session] { validate(arguments->file, session); });
}

}  // namespace aluminate::apps
