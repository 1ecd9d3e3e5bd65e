// aluminate diff A B [-o D.png]: where two pictures differ, exactly. Exit 0 equal, 1 different.
#include <fmt/format.h>

#include <cstdio>

#include "apps/session.hpp"
#include "platform/host/error.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/output_file.hpp"
#include "shading/report/difference_page.hpp"
#include "shading/report/heat_map.hpp"
#include "shading/report/statistics.hpp"

namespace aluminate::apps {
namespace {

struct Arguments {
  std::string a, b, output, html;
};

void run(const Arguments& arguments, Session& session) {
  const host::Image8 a = host::read_image_rgba8(arguments.a);
  const host::Image8 b = host::read_image_rgba8(arguments.b);
  if (a.width != b.width || a.height != b.height) {
    throw UserError(fmt::format("sizes differ: {} is {}x{}, {} is {}x{}", arguments.a, a.width, a.height,
                                arguments.b, b.width, b.height),
                    "diff compares pictures of one size");
  }
  const report::ImageDifference d = report::compare_images(a.width, a.texels, b.texels);
  if (!arguments.output.empty()) {
    const int gain = d.max_step > 0 ? std::max(1, 255 / d.max_step) : 1;
    host::write_png(arguments.output, report::difference_image(a.width, a.height, a.texels, b.texels, gain));
  }
  if (!arguments.html.empty())
    host::write_file(arguments.html, report::difference_page({.title = arguments.a + " and " + arguments.b,
                                                              .name_a = arguments.a,
                                                              .name_b = arguments.b,
                                                              .command = "",
                                                              .accept = "",
                                                              .width = a.width,
                                                              .height = a.height,
                                                              .a = a.texels,
                                                              .b = b.texels}));
  fmt::print("{}", report::difference_text(d, a.width, a.texels, b.texels));
  session.exit_code = d.same() ? kDone : kAnswerIsNo;
}

}  // namespace

void add_diff(CLI::App& app, Session& session) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("diff", "compare two pictures: exit 0 equal, 1 different");
  command->add_option("A", arguments->a, "first picture")->required();
  command->add_option("B", arguments->b, "second picture")->required();
  command->add_option("-o,--output", arguments->output, "write the difference, scaled up to be seen (PNG)");
  command->add_option("--html", arguments->html,
                      "write a page with both pictures, a slider, blinking and values");
  command->callback([arguments, &session] { run(*arguments, session); });
}

}  // namespace aluminate::apps
