#include "shading/report/job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "platform/console/platform_file.hpp"
#include "platform/host/error.hpp"
#include "platform/host/hash.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/input_file.hpp"
#include "scenes/scene.hpp"
#include "shading/brdf/visibility.hpp"
#include "shading/passes/renderer.hpp"
#include "shading/report/frame_cost.hpp"
#include "shading/report/heat_map.hpp"

namespace aluminate::report {
namespace {

host::ImageMetadata metadata(const Billed& billed) {
  return {{"aluminate:command", canonical_command("render", billed.origin)},
          {"aluminate:scene_hash", billed.origin.scene_hash},
          {"aluminate:platform", billed.gpu.id}};
}

host::Image8 picture(const passes::Frame& frame) { return {frame.width, frame.height, 4, frame.rgba8}; }

// Files beside the scene that can change the picture or the bill. A built-in console is known by its name.
std::vector<std::pair<std::string, std::string>> hashes_of_files(const passes::FrameOptions& options,
                                                                 const console::GpuModel& gpu) {
  std::vector<std::pair<std::string, std::string>> hashes;
  for (const std::string& file : {options.shader, options.reflections, gpu.path})
    if (!file.empty() && std::filesystem::is_regular_file(file))
      hashes.emplace_back(file, host::hash_bytes(host::read_bytes(file)).hex());
  return hashes;
}

std::vector<std::uint8_t> bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

}  // namespace

Billed bill(const scenes::Scene& scene, const passes::FrameOptions& options, passes::Frame frame,
            double budget_ms) {
  Billed billed;
  billed.name = std::string(brdf::to_string(options.visibility));
  billed.gpu = console::load_platform(options.platform);
  billed.origin = {scene.file, scene.content_hash, hashes_of_files(options, billed.gpu), options};
  billed.frame = std::move(frame);
  // As an option again: the frame describes its lights as "scene (4 lights)".
  billed.origin.options.lights = billed.frame.lights.substr(0, billed.frame.lights.find(' '));
  billed.budget = frame_budget(billed.frame, billed.gpu, budget_ms);
  return billed;
}

Billed bill(const scenes::Scene& scene, const passes::FrameOptions& options, double budget_ms) {
  return bill(scene, options, passes::render_frame(scene, options), budget_ms);
}

Billed render_and_bill(const scenes::Scene& scene, const passes::FrameOptions& options, double budget_ms,
                       int frames) {
  passes::Renderer renderer(scene, options);
  std::vector<double> frame_ms;
  passes::Frame frame;
  for (int i = 0; i < frames; ++i) {
    frame = renderer.draw(std::move(frame));
    frame_ms.push_back(frame.timing.frame_ms.front());
  }
  frame.timing.frame_ms = std::move(frame_ms);
  Billed billed = bill(scene, options, std::move(frame), budget_ms);
  billed.lights = passes::light_costs(options, billed.gpu);
  return billed;
}

void check_image_path(const std::string& path) {
  if (!path.ends_with(".png") && !path.ends_with(".exr"))
    throw UserError(fmt::format("{}: pictures are written as .png or .exr", path),
                    "give the output a name that ends in .png or .exr");
}

std::vector<std::uint8_t> encode_picture(const std::string& path, const Billed& billed) {
  const passes::Frame& frame = billed.frame;
  if (path.ends_with(".png")) return host::encode_png(picture(frame), metadata(billed));
  std::vector<float> channels[4];
  for (std::size_t c = 0; c < 4; ++c) {
    channels[c].resize(frame.pixel_count());
    for (std::size_t i = 0; i < channels[c].size(); ++i) channels[c][i] = frame.linear[i * 4 + c];
  }
  const host::ExrLayer layers[] = {
      {"R", channels[0]}, {"G", channels[1]}, {"B", channels[2]}, {"A", channels[3]}};
  return host::encode_exr(frame.width, frame.height, layers, metadata(billed));
}

std::vector<std::uint8_t> encode_cost_layers(const Billed& billed) {
  const passes::Frame& frame = billed.frame;
  std::vector<float> depth(frame.depth_d24.size());
  for (std::size_t i = 0; i < depth.size(); ++i)
    depth[i] = static_cast<float>(frame.depth_d24[i]) / 16777215.0f;
  const passes::CostPlanes& cost = frame.cost;
  const auto layer = [](const char* name, const std::vector<std::uint32_t>& values) {
    return host::ExrLayer{name, std::span<const std::uint32_t>(values)};
  };
  const host::ExrLayer layers[] = {
      layer("cost.alu_words", cost.alu_words), layer("cost.alu_slots", cost.alu_slots),
      layer("cost.fetches", cost.fetches),     layer("cost.fetch_cyc", cost.fetch_cyc),
      layer("cost.overdraw", cost.overdraw),   layer("cost.helpers", cost.helpers),
      layer("cost.path", cost.path),           {"depth.Z", std::span<const float>(depth)}};
  return host::encode_exr(frame.width, frame.height, layers, metadata(billed));
}

std::vector<std::string> comparison_file_names() {
  return {"a.png",      "b.png",      "difference.png", "cost_a.png", "cost_b.png", "cost_difference.png",
          "cost_a.exr", "cost_b.exr", "compare.json"};
}

std::vector<ComparisonFile> comparison_files(const Billed& a, const Billed& b,
                                             const ImageDifference& difference) {
  const int width = a.frame.width, height = a.frame.height;
  const auto& words_a = a.frame.cost.alu_words;
  const auto& words_b = b.frame.cost.alu_words;
  // One scale for both, so that the two maps can be laid side by side; the dearest percent is clipped, else a
  // few pixels of sliver triangles would leave the rest in one colour. The legend counts them.
  const std::uint32_t scale =
      std::max(distribution(words_a, a.frame.covered).p99, distribution(words_b, b.frame.covered).p99);
  const int gain = difference.p99_step > 0 ? std::max(1, 255 / difference.p99_step) : 1;
  const std::string unit = fmt::format("ALU words per pixel on {}", a.gpu.name);
  std::vector<ComparisonFile> files;
  files.push_back({"a.png", encode_picture("a.png", a)});
  files.push_back({"b.png", encode_picture("b.png", b)});
  files.push_back(
      {"difference.png", host::encode_png(difference_image(width, height, a.frame.rgba8, b.frame.rgba8, gain),
                                          {{"aluminate:gain", fmt::format("{}", gain)}})});
  files.push_back(
      {"cost_a.png", host::encode_png(heat_map(width, height, words_a, scale, unit + ", " + a.name))});
  files.push_back(
      {"cost_b.png", host::encode_png(heat_map(width, height, words_b, scale, unit + ", " + b.name))});
  files.push_back({"cost_difference.png",
                   host::encode_png(difference_heat_map(width, height, words_a, words_b,
                                                        unit + fmt::format(", {} - {}", b.name, a.name)))});
  files.push_back({"cost_a.exr", encode_cost_layers(a)});
  files.push_back({"cost_b.exr", encode_cost_layers(b)});
  files.push_back({"compare.json", bytes_of(compare_json(a, b, difference))});
  return files;
}

}  // namespace aluminate::report
