// aluminate scene list | info FILE | validate FILE | material FILE: what is in a scene, what is wrong with
// it, and a measured albedo into one of its materials.
#include <fmt/format.h>

#include "apps/session.hpp"
#include "platform/host/error.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/output_file.hpp"
#include "platform/host/text_table.hpp"
#include "scenes/base_color.hpp"
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

struct MaterialArguments {
  std::string file, image, output;
  double roughness = -1;  // as it is
  scenes::BaseColor base_color;
};

void write_material(MaterialArguments& a) {
  if (!a.output.ends_with(".glb")) throw UserError({a.output}, "expected an output that ends in .glb");
  if (a.roughness != -1) a.base_color.roughness = a.roughness;
  host::OutputFile file(a.output);
  file.write(scenes::with_base_color(a.file, host::read_bytes(a.image), a.image, a.base_color));
  file.commit();
}

void add_material(CLI::App& command) {
  auto a = std::make_shared<MaterialArguments>();
  CLI::App* material = command.add_subcommand(
      "material",
      "a picture, such as a calibrated albedo, as the base colour of one of the scene's materials");
  material->add_option("FILE", a->file, ".gltf or .glb")->required();
  material->add_option("--base-color", a->image, "PNG or JPEG, sRGB")->required();
  material->add_option("-o,--output", a->output, ".glb, with everything in it")->required();
  material->add_option("--material", a->base_color.material, "name or number (default: the only one)");
  material->add_option("--roughness", a->roughness, "0..1 (default: as it is)");
  material->callback([a] { write_material(*a); });
}

}  // namespace

void add_scene(CLI::App& app, Session& session) {
  struct Arguments {
    std::string file;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("scene", "list the sample scenes, describe, validate or repaint a scene");
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
  add_material(*command);
}

}  // namespace aluminate::apps
