// What a number format costs in accuracy, and what it buys in time: every format x visibility x Fresnel on every scene
// given, against the same frame in ref64, in one run.
//   accuracy [--size WxH] [--lights SPEC] [--frames K] -o FOLDER SCENE...
// Writes FOLDER/accuracy.csv (a row per case), FOLDER/accuracy.svg (error over time) and prints the table of
// docs/accuracy.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "platform/host/error.hpp"
#include "scenes/loader.hpp"
#include "shading/passes/frame.hpp"

namespace {

using namespace aluminate;

constexpr const char* kFormats[] = {"ref64", "fx40", "fx36", "fx31", "auto", "fx28", "fx24", "fx20", "q16.16", "q12.20", "q8.24"};

// Errors below this radiance are judged in display steps only: relative to nearly nothing they say nothing.
constexpr double kLeastRadiance = 1e-3;

// Display value of linear light in steps of 8 bits, not rounded.
double display_steps(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
}

struct Errors {
  double relative_max = 0, relative_mean = 0, relative_p999 = 0;
  double step_max = 0, step_mean = 0;
  double above_half = 0;  // fraction of pixels off by more than half a step
};

Errors errors_of(const passes::Frame& frame, const passes::Frame& reference) {
  Errors e;
  std::vector<double> relative;
  std::size_t pixels = 0, off = 0;
  for (std::size_t p = 0; p < reference.pixel_count(); ++p) {
    if (reference.covered[p] == 0) continue;
    ++pixels;
    double worst = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = frame.linear[4 * p + c], truth = reference.linear[4 * p + c];
      const double steps = std::abs(display_steps(value) - display_steps(truth));
      worst = std::max(worst, steps);
      e.step_mean += steps;
      if (truth > kLeastRadiance) relative.push_back(std::abs(value - truth) / truth);
    }
    e.step_max = std::max(e.step_max, worst);
    off += worst > 0.5 ? 1 : 0;
  }
  if (pixels == 0) return e;
  e.step_mean /= 3.0 * static_cast<double>(pixels);
  e.above_half = static_cast<double>(off) / static_cast<double>(pixels);
  if (relative.empty()) return e;
  std::sort(relative.begin(), relative.end());
  for (double r : relative) e.relative_mean += r;
  e.relative_mean /= static_cast<double>(relative.size());
  e.relative_max = relative.back();
  e.relative_p999 = relative[static_cast<std::size_t>(0.999 * static_cast<double>(relative.size() - 1))];
  return e;
}

struct Case {
  std::string scene, number, visibility, fresnel;
  Errors errors;
  double variant_steps = 0;  // mean distance of this visibility from schlick-smith in ref64, in steps
  std::uint64_t saturations = 0;
  double tiles_ms = 0;
};

struct Study {
  passes::FrameOptions options;
  int frames = 3;

  std::vector<Case> run(const std::string& path) const {
    const scenes::Scene scene = scenes::load_scene(path);
    std::vector<Case> cases;
    for (const brdf::FresnelTerm& fresnel : brdf::kFresnelTerms) {
      std::map<std::string, passes::Frame> truth;
      for (const brdf::VisibilityTerm& visibility : brdf::kVisibilityTerms)
        truth.emplace(visibility.name, render(scene, "ref64", visibility.name, fresnel.name).frame);
      for (const brdf::VisibilityTerm& visibility : brdf::kVisibilityTerms)
        for (const char* number : kFormats) {
          const Timed timed = render(scene, number, visibility.name, fresnel.name);
          const passes::Frame& reference = truth.at(std::string(visibility.name));
          cases.push_back({std::filesystem::path(path).stem().string(), number, std::string(visibility.name),
                           std::string(fresnel.name), errors_of(timed.frame, reference),
                           errors_of(reference, truth.at("schlick-smith")).step_mean, timed.frame.saturations,
                           timed.tiles_ms});
        }
    }
    return cases;
  }

 private:
  struct Timed {
    passes::Frame frame;
    double tiles_ms = 0;  // least of the frames: shading and rasterizing, nothing that is done once
  };

  Timed render(const scenes::Scene& scene, std::string_view number, std::string_view visibility,
               std::string_view fresnel) const {
    passes::FrameOptions chosen = options;
    passes::set_option(chosen, "number", number);
    passes::set_option(chosen, "visibility", visibility);
    passes::set_option(chosen, "fresnel", fresnel);
    Timed best;
    for (int i = 0; i < frames; ++i) {
      passes::Frame frame = passes::render_frame(scene, chosen);
      const double ms = frame.timing.phases_ms.at("tiles");
      if (i == 0 || ms < best.tiles_ms) best.tiles_ms = ms;
      if (i == 0) best.frame = std::move(frame);
    }
    return best;
  }
};

// One number format over all cases.
struct Row {
  Errors worst;            // maxima over the cases; the means are means
  double variant_ratio = 0;  // mean error over the mean distance of cheap from schlick-smith
  double time_ratio = 0;     // to fx31
  std::uint64_t saturations = 0;
};

Row summary(const std::vector<Case>& cases, std::string_view number) {
  Row row;
  double ms = 0, fx31_ms = 0, variant = 0;
  int count = 0, cheap = 0;
  for (const Case& c : cases) {
    if (c.number == "fx31") fx31_ms += c.tiles_ms;
    if (c.number != number) continue;
    ++count;
    ms += c.tiles_ms;
    row.saturations += c.saturations;
    row.worst.relative_max = std::max(row.worst.relative_max, c.errors.relative_max);
    row.worst.relative_p999 = std::max(row.worst.relative_p999, c.errors.relative_p999);
    row.worst.step_max = std::max(row.worst.step_max, c.errors.step_max);
    row.worst.above_half = std::max(row.worst.above_half, c.errors.above_half);
    row.worst.relative_mean += c.errors.relative_mean;
    row.worst.step_mean += c.errors.step_mean;
    if (c.visibility == "cheap") variant += c.variant_steps, ++cheap;
  }
  if (count == 0 || cheap == 0) return row;
  row.worst.relative_mean /= count;
  row.worst.step_mean /= count;
  // A scene without lights shows no difference to measure against.
  row.variant_ratio = variant > 0 ? row.worst.step_mean / (variant / cheap) : 0;
  row.time_ratio = fx31_ms > 0 ? ms / fx31_ms : 0;
  return row;
}

std::string csv(const std::vector<Case>& cases) {
  std::string text =
      "scene,number,visibility,fresnel,relative_max,relative_mean,relative_p999,step_max,step_mean,"
      "pixels_above_half_step,cheap_or_other_to_schlick_smith_steps,saturations,tiles_ms\n";
  for (const Case& c : cases)
    text += fmt::format("{},{},{},{},{:.3e},{:.3e},{:.3e},{:.3e},{:.3e},{:.5f},{:.3e},{},{:.3f}\n", c.scene, c.number,
                        c.visibility, c.fresnel, c.errors.relative_max, c.errors.relative_mean, c.errors.relative_p999,
                        c.errors.step_max, c.errors.step_mean, c.errors.above_half, c.variant_steps, c.saturations,
                        c.tiles_ms);
  return text;
}

std::string table(const std::vector<Case>& cases) {
  std::string text =
      "| format | relative max | p99.9 | mean | steps max | steps mean | pixels > 1/2 step | error / (cheap - "
      "Schlick-Smith) | saturations | time / fx31 |\n|---|---|---|---|---|---|---|---|---|---|\n";
  for (const char* number : kFormats) {
    const Row r = summary(cases, number);
    text += fmt::format("| {} | {:.1e} | {:.1e} | {:.1e} | {:.2g} | {:.1e} | {:.2f} % | {:.1e} | {} | {:.2f} |\n", number,
                        r.worst.relative_max, r.worst.relative_p999, r.worst.relative_mean, r.worst.step_max,
                        r.worst.step_mean, 100 * r.worst.above_half, r.variant_ratio, r.saturations, r.time_ratio);
  }
  return text;
}

// The formats that promise a picture no eye can tell from ref64, scene by scene: the worst of its variants.
std::string scene_table(const std::vector<Case>& cases) {
  std::string text =
      "\n| scene | format | steps max | steps mean | pixels > 1/2 step | error / (cheap - Schlick-Smith) | saturations |\n"
      "|---|---|---|---|---|---|---|\n";
  std::vector<std::string> scenes;
  for (const Case& c : cases)
    if (std::find(scenes.begin(), scenes.end(), c.scene) == scenes.end()) scenes.push_back(c.scene);
  for (const std::string& scene : scenes) {
    std::vector<Case> own;
    std::copy_if(cases.begin(), cases.end(), std::back_inserter(own), [&](const Case& c) { return c.scene == scene; });
    for (const char* number : {"fx31", "auto"}) {
      const Row r = summary(own, number);
      text += fmt::format("| {} | {} | {:.2g} | {:.1e} | {:.2f} % | {:.1e} | {} |\n", scene, number, r.worst.step_max,
                          r.worst.step_mean, 100 * r.worst.above_half, r.variant_ratio, r.saturations);
    }
  }
  return text;
}

// Mean error in steps (log) over time; the band is the distance of the two visibilities: a format inside it cannot tell
// them apart.
std::string svg(const std::vector<Case>& cases) {
  constexpr double kWidth = 720, kHeight = 420, kLeft = 80, kRight = 20, kTop = 30, kBottom = 50;
  constexpr double kLeast = -10, kMost = 2;  // log10 of steps
  double slowest = 1;
  for (const char* number : kFormats) slowest = std::max(slowest, summary(cases, number).time_ratio);
  const double span = 1.15 * slowest;
  const auto x = [&](double ratio) { return kLeft + (kWidth - kLeft - kRight) * ratio / span; };
  const auto y = [&](double steps) {
    const double l = std::clamp(std::log10(std::max(steps, 1e-300)), kLeast, kMost);
    return kTop + (kHeight - kTop - kBottom) * (kMost - l) / (kMost - kLeast);
  };
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"12\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
      kWidth, kHeight);
  double variant = 0;
  int count = 0;
  for (const Case& c : cases)
    if (c.visibility == "cheap" && c.number == "ref64") variant += c.variant_steps, ++count;
  variant /= std::max(count, 1);
  text += fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"#f6dcdc\"/>\n"
      "<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"#933\">error above the difference of cheap and Schlick-Smith</text>\n",
      kLeft, kTop, kWidth - kLeft - kRight, y(variant) - kTop, kLeft + 8, kTop + 16);
  for (int decade = static_cast<int>(kLeast); decade <= static_cast<int>(kMost); decade += 2) {
    const double at = y(std::pow(10.0, decade));
    text += fmt::format("<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"#ddd\"/>"
                        "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">1e{}</text>\n",
                        kLeft, kWidth - kRight, at, at, kLeft - 6, at + 4, decade);
  }
  for (double tick = 0; tick <= span; tick += 0.5)
    text += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:.1f}</text>\n", x(tick),
                        kHeight - kBottom + 18, tick);
  text += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">time of the tiles, fx31 = 1</text>\n"
                      "<text transform=\"translate(18,{:.1f}) rotate(-90)\" text-anchor=\"middle\">mean error, 8-bit steps "
                      "(none: bottom)</text>\n",
                      (kLeft + kWidth - kRight) / 2, kHeight - 12, (kTop + kHeight - kBottom) / 2);
  for (const char* number : kFormats) {
    const Row r = summary(cases, number);
    text += fmt::format("<circle cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"4\" fill=\"#246\"/>"
                        "<text x=\"{2:.1f}\" y=\"{3:.1f}\">{4}</text>\n",
                        x(r.time_ratio), y(r.worst.step_mean), x(r.time_ratio) + 7, y(r.worst.step_mean) + 4, number);
  }
  return text + "</svg>\n";
}

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw UserError({path.string()}, "cannot be written", "choose a folder that can");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("accuracy of every number format against ref64, and its time");
  std::string size = "320x180", lights = "rig:4", folder;
  std::vector<std::string> paths;
  Study study;
  app.add_option("--size", size, "WxH");
  app.add_option("--lights", lights, "as in aluminate render");
  app.add_option("--frames", study.frames, "renderings a case; the fastest is timed")->check(CLI::Range(1, 100));
  app.add_option("-o", folder, "folder for accuracy.csv and accuracy.svg")->required();
  app.add_option("SCENE", paths, "glTF files")->required();
  CLI11_PARSE(app, argc, argv);
  try {
    passes::set_option(study.options, "size", size);
    passes::set_option(study.options, "lights", lights);
    std::filesystem::create_directories(folder);
    std::vector<Case> cases;
    for (const std::string& path : paths)
      for (Case& c : study.run(path)) cases.push_back(std::move(c));
    write(std::filesystem::path(folder) / "accuracy.csv", csv(cases));
    write(std::filesystem::path(folder) / "accuracy.svg", svg(cases));
    fmt::print("{}{}", table(cases), scene_table(cases));
  } catch (const UserError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
