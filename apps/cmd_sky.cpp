// aluminate sky table | sh9 | dome: the CIE sky as numbers and as a picture.
#include <fmt/format.h>

#include "apps/session.hpp"
#include "platform/host/error.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/output_file.hpp"
#include "shading/report/sky_report.hpp"
#include "shading/sky/dome.hpp"

namespace aluminate::apps {
namespace {

struct Arguments {
  report::SkyRequest request;
  std::string inputs, output, zenith = "1", horizon = "1", post_process = "1";
  std::string json;
  int width = 1024;
};

void add_sky_options(CLI::App& command, const std::shared_ptr<Arguments>& a) {
  command.add_option("--sky", a->request.sky, "CIE type 1..15, fc3, or a,b,c,d,e");
  command.add_option("--sun-zenith", a->request.sun_zenith_deg, "degrees from the zenith")->type_name("DEG");
  command.add_option("--zenith-color", a->zenith, "gradient at the zenith, linear R,G,B");
  command.add_option("--horizon-color", a->horizon, "gradient at the horizon, linear R,G,B");
  command.add_option("--relative", a->request.relative,
                     "luminance relative to the sun or the zenith: sun|zenith");
}

void read_colors(Arguments& a) {
  a.request.zenith_color = report::parse_color("--zenith-color", a.zenith);
  a.request.horizon_color = report::parse_color("--horizon-color", a.horizon);
}

void write_table(const Arguments& a) {
  host::OutputFile output(a.output);
  output.write(report::sky_table(report::parse_csv(host::read_text(a.inputs), a.inputs), a.inputs,
                                 sky::parse_sky(a.request.sky)));
  output.commit();
}

void write_dome(Arguments& a) {
  read_colors(a);
  if (!a.output.ends_with(".exr"))
    throw UserError(fmt::format("{}: the dome is written as .exr", a.output), "luminance exceeds 1");
  const sky::DomeImageOptions options{.width = a.width,
                                      .height = a.width / 2,
                                      .post_process = report::parse_color("--polarizer", a.post_process)};
  const std::vector<float> rgb = sky::dome_image(report::make_sky(a.request), options);
  std::vector<float> channels[3];
  for (std::size_t i = 0; i < rgb.size(); ++i) channels[i % 3].push_back(rgb[i]);
  const host::ExrLayer layers[] = {{"R", std::span<const float>(channels[0])},
                                   {"G", std::span<const float>(channels[1])},
                                   {"B", std::span<const float>(channels[2])}};
  host::write_exr(a.output, options.width, options.height, layers);
}

void write_sh9(Arguments& a) {
  read_colors(a);
  if (a.json.empty()) {
    fmt::print("{}", report::sh9_text(a.request));
  } else if (a.json == "-") {
    fmt::print("{}", report::sh9_json(a.request));
  } else {
    host::write_file(a.json, report::sh9_json(a.request));
  }
}

}  // namespace

void add_sky(CLI::App& app, Session&) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("sky", "the CIE sky as a table, as SH coefficients, as an image");
  command->require_subcommand(1);
  CLI::App* table = command->add_subcommand("table", "relative luminance for a CSV of angles");
  table->add_option("--sky", a->request.sky, "CIE type 1..15, fc3, or a,b,c,d,e");
  table->add_option("--inputs", a->inputs, "CSV: sun_zenith_deg,view_zenith_deg,azimuth_from_sun_deg")
      ->required();
  table->add_option("-o,-F,--output", a->output, "CSV with L_over_L_zenith,L_over_L_sun added")->required();
  table->callback([a] { write_table(*a); });
  CLI::App* sh9 = command->add_subcommand("sh9", "nine coefficients x rgb");
  add_sky_options(*sh9, a);
  sh9->add_option("--json", a->json, "as JSON, to a file or ('-' or nothing) to stdout")
      ->expected(0, 1)
      ->default_str("-");
  sh9->callback([a] { write_sh9(*a); });
  CLI::App* dome = command->add_subcommand("dome", "latitude-longitude image, linear, zenith on top");
  add_sky_options(*dome, a);
  dome->add_option("-o,--output", a->output, "picture, .exr")->required();
  dome->add_option("--width", a->width, "pixels; the height is half")->check(CLI::Range(2, 16384));
  dome->add_option("--polarizer", a->post_process, "per-channel factor on the dome, never on its light");
  dome->callback([a] { write_dome(*a); });
}

}  // namespace aluminate::apps
