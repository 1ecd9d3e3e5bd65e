// aluminate cost SHADER|VARIANT..: what a shader costs on a console before anything runs.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <thread>

#include "apps/session.hpp"
#include "platform/host/interrupt.hpp"
#include "shading/report/cost_report.hpp"
#include "shading/report/cost_watch.hpp"

namespace aluminate::apps {

void add_cost(CLI::App& app, Session&) {
  struct Arguments {
    FrameArguments frame;
    report::CostRequest request;
    std::string format = "text";
    bool trilinear = false, loose = false, watch = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("cost", "static cost of shaders and variants on a console");
  command->footer(
      "Examples:\n  aluminate cost schlick-smith cheap --light-loop rolled\n  aluminate cost my_shader.hlsl "
      "--platform rsx --listing");
  command
      ->add_option("SUBJECT", arguments->request.subjects,
                   "shader files, visibility names or key=value variants of the shipped shader")
      ->required();
  command->add_flag("--listing", arguments->request.listing, "instruction by instruction, as scheduled");
  command->add_option("--format", arguments->format, "text, json, tsv, markdown or fxc360");
  command->add_option("--stage", arguments->request.stage, "stage of a shader file")
      ->check(CLI::IsMember({"pixel", "vertex"}));
  command->add_option("--entry", arguments->request.entry, "entry point of a shader file");
  command->add_flag("--trilinear", arguments->trilinear,
                    "count trilinear fetches as such; the period's estimate assumes bilinear");
  command->add_flag("--loose", arguments->loose, "ignore the third-source pairing rule (sensitivity only)");
  command->add_flag("--watch", arguments->watch,
                    "price again when a file or its includes change; Ctrl-C ends");
  arguments->frame.add_to(*command, {"platform", "lights", "fresnel", "light-loop", "D"});
  command->callback([arguments] {
    report::CostRequest& request = arguments->request;
    request.options = arguments->frame.resolve();
    request.format = cost::parse_format(arguments->format);
    if (arguments->trilinear) request.assumptions.filter = cost::FilterAssumption::Trilinear;
    if (arguments->loose) request.assumptions.pairing = cost::PairingRule::Loose;
    if (!arguments->watch) {
      fmt::print("{}", report::cost_report(request));
      return;
    }
    report::watch_cost(request, {.print =
                                     [](const std::string& text) {
                                       fmt::print("{}\n", text);
                                       std::fflush(stdout);
                                     },
                                 .wait =
                                     [] {
                                       std::this_thread::sleep_for(std::chrono::milliseconds(200));
                                       host::throw_if_interrupted();
                                       return true;
                                     }});
  });
}

}  // namespace aluminate::apps
