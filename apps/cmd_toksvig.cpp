// aluminate toksvig NORMAL_MAP -o OUT.png: gloss filtered by a normal map, for every mip.
#include <fmt/format.h>

#include "apps/session.hpp"
#include "platform/host/error.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/output_file.hpp"
#include "shading/report/toksvig_report.hpp"

namespace aluminate::apps {
namespace {

struct Arguments {
  std::string map, output;
  double gloss = -1, sigma = 0;
  bool dxt5 = false;
};

void run(const Arguments& a) {
  if (!a.output.ends_with(".png"))
    throw UserError(fmt::format("{}: the filtered map is written as .png", a.output));
  host::OutputFile output(a.output);
  const host::Image8 map = host::read_image_rgba8(a.map);
  const filter::Rgba8View view{map.texels, map.width, map.height};
  filter::NormalLevel normals = filter::decode_normal_map(view);
  filter::ScalarLevel gloss = filter::decode_channel(view, 3);
  if (a.gloss >= 0) std::fill(gloss.texels.begin(), gloss.texels.end(), a.gloss);
  const auto levels = filter::bake_gloss(normals, gloss, {.footprint_sigma = a.sigma});
  output.write(host::encode_png(report::toksvig_picture(levels, a.dxt5)));
  output.commit();
  fmt::print("{}", report::toksvig_text(levels));
}

}  // namespace

void add_toksvig(CLI::App& app, Session&) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("toksvig", "filter gloss by a normal map, for every mip");
  command->footer("Example:\n  aluminate toksvig rock_normal.png --gloss 0.7 -o rock_filtered.png");
  command->add_option("NORMAL_MAP", a->map, "normal in rgb, artists' gloss in alpha")->required();
  command->add_option("-o,--output", a->output, "R filtered gloss, G normal y, A normal x; all mips, .png")
      ->required();
  command->add_option("--gloss", a->gloss, "one gloss instead of the map's alpha")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--sigma", a->sigma, "Gaussian footprint in texels, on every mip (0: boxes alone)")
      ->check(CLI::Range(0.0, 16.0));
  command->add_flag("--dxt5", a->dxt5, "write the texels as they come back from DXT5");
  command->callback([a] { run(*a); });
}

}  // namespace aluminate::apps
