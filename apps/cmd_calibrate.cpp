// aluminate calibrate PHOTO -o OUT: a photograph with a ColorChecker becomes an albedo. Exit 0 done; --batch:
// 1 when a photograph was refused.
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "apps/session.hpp"
#include "calibration/calibrate.hpp"
#include "calibration/calibration_files.hpp"
#include "platform/host/error.hpp"
#include "platform/host/log.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::apps {
namespace {

using namespace calibration;

struct Arguments {
  std::string photo, corners, fit = "auto", chart = "after-2014", encoding = "srgb", output_encoding = "srgb",
                              finder = "auto";
  std::vector<double> vignette, lateral;
  CalibrationOptions options;
  CalibrationOutputs outputs;
  std::string batch_ending = ".png";
  bool batch = false;
  int threads = 0;
};

void resolve(Arguments& a) {
  host::set_thread_count(a.threads);
  if (!a.corners.empty()) a.options.corners = parse_corners(a.corners);
  a.options.finder = parse_chart_finder(a.finder);
  a.options.fit = parse_fit_kind(a.fit);
  a.options.edition = parse_edition(a.chart);
  a.options.input_encoding = parse_encoding(a.encoding);
  a.options.format.encoding = parse_encoding(a.output_encoding);
  for (std::size_t i = 0; i < a.vignette.size(); ++i) a.options.vignette[i] = a.vignette[i];
  for (std::size_t i = 0; i < a.lateral.size(); ++i) a.options.lateral[i] = a.lateral[i];
}

void run(Arguments& a, Session& session) {
  resolve(a);
  if (a.batch) {
    if (a.outputs.image.empty()) throw UserError("--batch needs a folder to write to", "give it with -o");
    const std::vector<BatchItem> items =
        calibrate_folder(a.photo, a.outputs.image, a.batch_ending, a.options, session.command);
    fmt::print("{}", batch_text(items));
    for (const BatchItem& item : items)
      if (!item.done) session.exit_code = kAnswerIsNo;
    return;
  }
  const bool json_to_stdout = a.outputs.json == "-";
  if (json_to_stdout) a.outputs.json.clear();
  const Calibration done = calibrate(a.photo, a.options, a.outputs, session.command);
  fmt::print("{}", json_to_stdout ? calibration_json(done, session.command) : summary_text(done));
  for (const std::string& warning : done.warnings) host::warning(warning);
}

}  // namespace

void add_calibrate(CLI::App& app, Session& session) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("calibrate", "correct a photograph with a ColorChecker to diffuse albedo");
  command->add_option("PHOTO", a->photo, "picture or camera raw; with --batch a folder")->required();
  command->add_option("-o,--output", a->outputs.image,
                      "corrected picture (.png, .tif, .exr); with --batch a folder");
  command->add_option("--corners", a->corners,
                      "centres of dark skin, bluish green, black, white: x,y;x,y;x,y;x,y (default: found)");
  command->add_option("--finder", a->finder, "how the chart is found: auto|grid|opencv");
  command->add_option("--chart", a->chart, "the chart's colours: after-2014|before-2014");
  command->add_option("--fit", a->fit, "auto|affine-poly-affine|linear|root-poly|tone-linear");
  command->add_option("--degree", a->options.degree, "of affine-poly-affine (1..5) or root-poly (1..3)");
  command->add_option("--encoding", a->encoding, "what integer codes of PHOTO mean: srgb|linear");
  command->add_option("--bayer", a->options.bayer,
                      "PHOTO is a mosaic with this pattern: RGGB|BGGR|GRBG|GBRG");
  command->add_option("--lens", a->options.lens,
                      "auto (lensfun, from a raw file), poly3:k1, poly5:k1,k2, ptlens:a,b,c, acm:k1,..,k5, "
                      "acm-fisheye:k1,k2");
  command->add_option("--focal-px", a->options.focal_px, "focal length in px, for acm");
  command->add_option("--vignette", a->vignette, "darkening 1 + k1 r^2 + k2 r^4 + k3 r^6: k1,k2,k3")
      ->delimiter(',')
      ->expected(1, 3);
  command->add_option("--lateral", a->lateral, "radius of red and of blue relative to green: r,b")
      ->delimiter(',')
      ->expected(2);
  command->add_option("--parallel", a->options.parallel,
                      "PHOTO was taken with crossed polarisers; this one with parallel ones");
  command->add_option("--leakage", a->options.leakage,
                      "share of polarised light that the crossed polarisers pass, 0 .. 0.5");
  command->add_option("--specular", a->outputs.specular, "write the specular part of a polarised pair");
  command->add_option("--output-encoding", a->output_encoding, "of integer outputs: srgb|linear");
  command->add_option("--bits", a->options.format.bits, "of a .png: 8 or 16");
  command->add_option("--json", a->outputs.json, "write patches, transform and errors; - for stdout");
  command->add_option("--cube", a->outputs.cube,
                      "write a 3D lookup table for OpenColorIO and image editors (.cube)");
  command->add_option("--cube-size", a->options.cube_size, "points a side, 2..129");
  command->add_option("--report", a->outputs.report, "write a page for people (.html, .png)");
  command->add_option("--material", a->outputs.material,
                      "write a glTF square with the albedo, for 'aluminate render'");
  command->add_flag("--batch", a->batch, "every picture in the folder PHOTO; one that fails stops no other");
  command->add_option("--batch-ending", a->batch_ending, "kind of the outputs: .png|.tif|.exr");
  command->add_option("--threads", a->threads, "0: all cores");
  command->callback([a, &session] { run(*a, session); });
}

}  // namespace aluminate::apps
