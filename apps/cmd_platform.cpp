// aluminate platform list | show P: the consoles, each number with its source and confidence.
#include <fmt/format.h>

#include "apps/session.hpp"
#include "platform/console/platform_file.hpp"
#include "platform/host/text_table.hpp"

namespace aluminate::apps {
namespace {

void list_platforms() {
  host::TextTable table({{"platform"},
                         {"GPU"},
                         {"year", host::Align::Right},
                         {"ALU model"},
                         {"ALU lanes/clk", host::Align::Right},
                         {"MHz", host::Align::Right}});
  for (const console::PlatformEntry& entry : console::builtin_platforms()) {
    const console::GpuModel gpu = console::load_platform(std::string(entry.id));
    table.add_row(
        {gpu.id, gpu.name, fmt::format("{}", gpu.year), std::string(console::alu_model_word(gpu.alu_model)),
         fmt::format("{}", gpu.alu.lanes_per_clk.value), fmt::format("{}", gpu.clock.core_mhz.value)});
  }
  fmt::print("{}", table.text());
}

}  // namespace

void add_platform(CLI::App& app, Session&) {
  auto name = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("platform", "list the consoles, or show one with the source of every number");
  command->require_subcommand(1);
  command->add_subcommand("list", "the built-in platforms")->callback([] { list_platforms(); });
  CLI::App* show = command->add_subcommand("show", "every figure with unit, range, source and confidence");
  show->add_option("PLATFORM", *name, "name, or your own FILE.toml")->required();
  show->callback([name] { fmt::print("{}", console::format_platform(console::load_platform(*name))); });
}

}  // namespace aluminate::apps
