#include "shading/report/document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "platform/host/hash.hpp"
#include "platform/host/parallel.hpp"
#include "platform/host/text_table.hpp"
#include "shading/brdf/fresnel.hpp"
#include "shading/brdf/visibility.hpp"

namespace aluminate::report {
namespace {

using nlohmann::ordered_json;

constexpr int kSchema = 1;

struct Plane {
  const char* key;    // JSON
  const char* title;  // text
  std::vector<std::uint32_t> passes::CostPlanes::*values;
};
constexpr Plane kPlanes[] = {{"alu_words", "ALU words/px", &passes::CostPlanes::alu_words},
                             {"alu_slots", "ALU slots/px", &passes::CostPlanes::alu_slots},
                             {"fetches", "fetches/px", &passes::CostPlanes::fetches},
                             {"fetch_cyc", "fetch cycles/px", &passes::CostPlanes::fetch_cyc},
                             {"overdraw", "overdraw", &passes::CostPlanes::overdraw},
                             {"helpers", "helper lanes/px", &passes::CostPlanes::helpers}};

Distribution distribution_of(const passes::Frame& frame, const Plane& plane) {
  return distribution(frame.cost.*plane.values, frame.covered);
}

ordered_json options_json(const passes::FrameOptions& o, const passes::Frame& frame) {
  ordered_json defines = ordered_json::object();
  for (const auto& [name, value] : o.defines) defines[name] = value;
  return {{"size", fmt::format("{}x{}", o.width, o.height)},
          {"msaa", o.msaa},
          {"camera", o.camera},
          {"lights", frame.lights},
          {"ambient", passes::ambient_text(o)},
          {"pipeline", passes::to_string(o.pipeline)},
          {"visibility", brdf::to_string(o.visibility)},
          {"fresnel", brdf::to_string(o.fresnel)},
          {"tonemap", passes::to_string(o.tonemap)},
          {"number", o.number},
          {"platform", o.platform},
          {"shader", o.shader},
          {"light_loop", passes::to_string(o.light_loop)},
          {"defines", defines}};
}

ordered_json header(const std::string& verb, const Origin& origin) {
  ordered_json inputs = {{"scene", origin.scene_file}, {"scene_hash", origin.scene_hash}};
  for (const auto& [file, hash] : origin.file_hashes) inputs["file_hashes"][file] = hash;
  return {{"schema", kSchema},
          {"tool", {{"name", "aluminate"}, {"version", ALUMINATE_VERSION}}},
          {"command", canonical_command(verb, origin)},
          {"inputs", std::move(inputs)}};
}

ordered_json timing_json(const passes::Frame& frame) {
  std::vector<double> sorted = frame.timing.frame_ms;
  std::sort(sorted.begin(), sorted.end());
  ordered_json phases = ordered_json::object();
  for (const auto& [name, ms] : frame.timing.phases_ms) phases[name] = ms;
  return {{"threads", host::thread_count()},
          {"frames", sorted.size()},
          {"frame_ms_min", sorted.empty() ? 0.0 : sorted.front()},
          {"frame_ms_median", sorted.empty() ? 0.0 : sorted[sorted.size() / 2]},
          {"phases_ms", phases}};
}

// Milliseconds each unit would take alone, at its derated rate.
ordered_json units_json(const std::array<double, console::kUnitCount>& ms) {
  ordered_json units = ordered_json::object();
  for (std::size_t unit = 0; unit < ms.size(); ++unit)
    units[std::string(console::unit_name(static_cast<console::Unit>(unit)))] = ms[unit];
  return units;
}

ordered_json cost_json(const Billed& billed) {
  ordered_json passes = ordered_json::array();
  for (std::size_t i = 0; i < billed.frame.passes.size(); ++i) {
    const passes::PassTotals& pass = billed.frame.passes[i];
    const console::PassTime& time = billed.budget.passes[i];
    passes.push_back({{"name", pass.name},
                      {"pixels", pass.pixels},
                      {"quads", pass.quads},
                      {"helper_lanes", pass.helper_lanes},
                      {"alu_words", pass.alu_words},
                      {"alu_slots", pass.alu_slots},
                      {"fetches", pass.fetches},
                      {"fetch_cyc", pass.fetch_cyc},
                      {"vertices", pass.vertices},
                      {"vertex_words", pass.vertex_words},
                      {"triangles", pass.triangles},
                      {"bytes", std::llround(time.memory_bytes)},
                      {"ms", time.derated},
                      {"peak_ms", time.peak},
                      {"units_ms", units_json(time.derated_ms)},
                      {"bound", console::unit_name(time.bound)}});
  }
  ordered_json sensitivity = ordered_json::array();
  for (const console::SensitivityRow& row : billed.budget.sensitivity)
    sensitivity.push_back({{"figure", row.figure},
                           {"confidence", console::confidence_word(row.confidence)},
                           {"low", row.low},
                           {"value", row.value},
                           {"high", row.high},
                           {"frame_ms_at_low", row.ms_at_low},
                           {"frame_ms_at_high", row.ms_at_high},
                           {"flips", row.flips}});
  return {{"platform", billed.gpu.id},
          {"passes", passes},
          {"frame_ms", billed.budget.derated_ms},
          {"frame_peak_ms", billed.budget.peak_ms},
          {"budget_ms", billed.budget.budget_ms},
          {"fits", billed.budget.fits},
          {"verdict", console::verdict_word(billed.budget.verdict)},
          {"sentence", billed.budget.sentence},
          {"sensitivity", sensitivity}};
}

ordered_json per_pixel_json(const passes::Frame& frame) {
  ordered_json result = ordered_json::object();
  for (const Plane& plane : kPlanes) {
    const Distribution d = distribution_of(frame, plane);
    result[plane.key] = {
        {"mean", d.mean()}, {"p95", d.p95}, {"max", d.max}, {"total", d.total}, {"pixels", d.pixels}};
  }
  return result;
}

ordered_json lights_json(const passes::LightCosts& lights) {
  ordered_json rows = ordered_json::array();
  for (const cost::LightCost& light : lights.rows)
    rows.push_back({{"loop", light.loop},
                    {"convention", light.convention},
                    {"alu_words", light.alu_words},
                    {"alu_slots", light.alu_slots},
                    {"fetches", light.fetches}});
  return rows;
}

ordered_json body_json(const Billed& billed) {
  const passes::Frame& frame = billed.frame;
  ordered_json programs = ordered_json::array();
  for (const passes::PathInfo& path : frame.paths)
    programs.push_back({{"program", path.program},
                        {"alu_words", path.alu_words},
                        {"alu_slots", path.alu_slots},
                        {"fetches", path.fetches},
                        {"fetch_cyc", path.fetch_cyc}});
  ordered_json saturated = ordered_json::array();
  for (const passes::Saturation& s : frame.saturated_instructions)
    saturated.push_back({{"place", s.place}, {"instruction", s.instruction}, {"lanes", s.lanes}});
  return {{"options", options_json(billed.origin.options, frame)},
          {"image", {{"width", frame.width}, {"height", frame.height}, {"hash", image_hash(frame)}}},
          {"cost", cost_json(billed)},
          {"per_pixel", per_pixel_json(frame)},
          {"per_light", lights_json(billed.lights)},
          {"programs", programs},
          {"skipped", frame.skipped},
          {"dropped_triangles", frame.dropped},
          {"saturations", frame.saturations},
          {"saturated_instructions", saturated},
          {"warnings", frame.warnings}};
}

std::string pass_table(const Billed& billed) {
  using host::Align;
  host::TextTable table({{"pass"},
                         {"pixels", Align::Right},
                         {"quads", Align::Right},
                         {"helper lanes", Align::Right},
                         {"ALU words", Align::Right},
                         {"fetches", Align::Right},
                         {"fetch cyc", Align::Right},
                         {"ms", Align::Right},
                         {"bound"}});
  for (std::size_t i = 0; i < billed.frame.passes.size(); ++i) {
    const passes::PassTotals& pass = billed.frame.passes[i];
    table.add_row({pass.name, fmt::format("{}", pass.pixels), fmt::format("{}", pass.quads),
                   fmt::format("{}", pass.helper_lanes), fmt::format("{}", pass.alu_words),
                   fmt::format("{}", pass.fetches), fmt::format("{}", pass.fetch_cyc),
                   fmt::format("{:.3f}", billed.budget.passes[i].derated),
                   std::string(console::unit_name(billed.budget.passes[i].bound))});
  }
  return table.text();
}

std::string mean_text(double mean) { return fmt::format("{:.2f}", mean); }

// The uncertain figures that move the frame most, one a line.
std::string sensitivity_text(const console::FrameBudget& budget) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, budget.sensitivity.size()); ++i) {
    const console::SensitivityRow& row = budget.sensitivity[i];
    text += fmt::format("  {} ({}) {} .. {}: {:.2f} .. {:.2f} ms{}\n", row.figure,
                        console::confidence_word(row.confidence), row.low, row.high, row.ms_at_low,
                        row.ms_at_high, row.flips ? ", FLIPS the verdict" : "");
  }
  return text;
}

// "helped" in lower case, "HURT" in capitals: a regression must catch the eye without colour.
std::string change_word(double a, double b) { return b < a ? "helped" : b > a ? "HURT" : "same"; }
std::string change_text(double a, double b) {
  if (a == b) return "=";
  return a != 0 ? fmt::format("{:+.2f} ({:+.1f} %)", b - a, 100.0 * (b - a) / a)
                : fmt::format("{:+.2f}", b - a);
}

void add_comparison(host::TextTable& table, const std::string& what, double a, double b, bool whole) {
  const auto text = [&](double v) { return whole ? fmt::format("{:.0f}", v) : fmt::format("{:.2f}", v); };
  table.add_row({what, text(a), text(b), change_text(a, b), change_word(a, b)});
}

}  // namespace

std::string image_hash(int width, int height, std::span<const std::uint8_t> rgba8) {
  return host::Hasher()
      .add_u32(static_cast<std::uint32_t>(width))
      .add_u32(static_cast<std::uint32_t>(height))
      .add(rgba8)
      .finish()
      .hex();
}

std::string image_hash(const passes::Frame& frame) {
  return image_hash(frame.width, frame.height, frame.rgba8);
}

std::string canonical_command(const std::string& verb, const Origin& origin) {
  const passes::FrameOptions& o = origin.options;
  std::string text = fmt::format(
      "aluminate {} {} --size {}x{} --camera {} --lights {} --ambient {} --pipeline {} --visibility {} "
      "--fresnel {} --tonemap {} --number {} --platform {} --light-loop {}",
      verb, origin.scene_file, o.width, o.height, o.camera, o.lights, passes::ambient_text(o),
      passes::to_string(o.pipeline), brdf::to_string(o.visibility), brdf::to_string(o.fresnel),
      passes::to_string(o.tonemap), o.number, o.platform, passes::to_string(o.light_loop));
  if (o.msaa != 1) text += fmt::format(" --msaa {}", o.msaa);
  if (o.has_sky()) {
    text += " --sky " + o.sky + (o.sun.empty() ? " --time " + o.time : " --sun " + o.sun);
    if (o.polarizer != glm::dvec3(1.0))
      text += fmt::format(" --polarizer {},{},{}", o.polarizer.r, o.polarizer.g, o.polarizer.b);
  }
  if (o.textures != passes::TextureStorage::Rgba8)
    text += fmt::format(" --textures {}", passes::to_string(o.textures));
  if (o.anisotropy > 1) text += fmt::format(" --anisotropy {}", o.anisotropy);
  if (o.toksvig != passes::ToksvigMode::Off)
    text += fmt::format(" --toksvig {}", passes::to_string(o.toksvig));
  if (o.shadows) text += " --shadows on";
  if (o.has_reflections()) text += " --reflections " + o.reflections;
  if (!o.shader.empty()) text += " --shader " + o.shader;
  for (const auto& [name, value] : o.defines) text += fmt::format(" -D {}={}", name, value);
  return text;
}

std::string render_json(const Billed& billed) {
  ordered_json document = header("render", billed.origin);
  document.update(body_json(billed));
  document["timing"] = timing_json(billed.frame);
  return document.dump(2) + "\n";
}

std::string render_text(const Billed& billed) {
  std::string text = pass_table(billed);
  using host::Align;
  host::TextTable pixels({{"executed, helper lanes included"},
                          {"mean", Align::Right},
                          {"p95", Align::Right},
                          {"max", Align::Right}});
  for (const Plane& plane : kPlanes) {
    const Distribution d = distribution_of(billed.frame, plane);
    pixels.add_row({plane.title, mean_text(d.mean()), fmt::format("{}", d.p95), fmt::format("{}", d.max)});
  }
  text += "\n" + pixels.text();
  for (const cost::LightCost& light : billed.lights.rows)
    text += fmt::format("one more light: {:.0f} words, {} slots ({})\n", light.alu_words, light.alu_slots,
                        light.convention);
  text += fmt::format("\n{}\n{}", billed.gpu.name, console::format_budget(billed.budget));
  for (const auto& [reason, count] : billed.frame.dropped)
    if (count) text += fmt::format("{} triangles dropped: {}\n", count, reason);
  if (billed.frame.saturations) text += fmt::format("{} results saturated\n", billed.frame.saturations);
  for (const passes::Saturation& s : billed.frame.saturated_instructions)
    text += fmt::format("  {}: {}  {} lanes\n", s.place, s.instruction, s.lanes);
  return text;
}

std::string compare_json(const Billed& a, const Billed& b, const ImageDifference& d) {
  ordered_json document = header("compare", a.origin);
  document["a"] = body_json(a);
  document["a"]["name"] = a.name;
  document["b"] = body_json(b);
  document["b"]["name"] = b.name;
  ordered_json delta = ordered_json::object();
  for (const Plane& plane : kPlanes) {
    const Distribution da = distribution_of(a.frame, plane), db = distribution_of(b.frame, plane);
    delta[plane.key] = {{"mean", db.mean() - da.mean()},
                        {"p95", std::int64_t{db.p95} - std::int64_t{da.p95}},
                        {"max", std::int64_t{db.max} - std::int64_t{da.max}}};
  }
  document["difference"] = {{"image",
                             {{"differing_pixels", d.differing},
                              {"pixels", d.pixels},
                              {"mean_step", d.mean_step()},
                              {"max_step", d.max_step},
                              {"worst", {d.worst_x, d.worst_y}},
                              {"first", {d.first_x, d.first_y}}}},
                            {"per_pixel", delta},
                            {"frame_ms", b.budget.derated_ms - a.budget.derated_ms},
                            {"verdict", hurts(a, b) ? "HURT" : "not hurt"}};
  document["timing"] = {{"a", timing_json(a.frame)}, {"b", timing_json(b.frame)}};
  return document.dump(2) + "\n";
}

std::string compare_text(const Billed& a, const Billed& b, const ImageDifference& d) {
  using host::Align;
  std::string text = fmt::format(
      "{}  {}x{}  {}  {}  {}\n\n", a.origin.scene_file, a.frame.width, a.frame.height, a.frame.lights,
      a.gpu.id == b.gpu.id ? a.gpu.name : a.gpu.name + " / " + b.gpu.name, a.origin.options.number);
  host::TextTable table({{"executed on the console"},
                         {"A " + a.name, Align::Right},
                         {"B " + b.name, Align::Right},
                         {"B - A", Align::Right},
                         {""}});
  for (const Plane& plane : kPlanes) {
    const Distribution da = distribution_of(a.frame, plane), db = distribution_of(b.frame, plane);
    add_comparison(table, std::string(plane.title) + " mean", da.mean(), db.mean(), false);
    add_comparison(table, "  p95", da.p95, db.p95, true);
    add_comparison(table, "  max", da.max, db.max, true);
  }
  table.add_rule();
  add_comparison(table, "console frame, ms", a.budget.derated_ms, b.budget.derated_ms, false);
  text += table.text();

  if (!a.lights.rows.empty() && a.lights.rows.size() == b.lights.rows.size()) {
    host::TextTable lights({{"one more light, static"},
                            {"A", Align::Right},
                            {"B", Align::Right},
                            {"B - A", Align::Right},
                            {""}});
    for (std::size_t i = 0; i < a.lights.rows.size(); ++i) {
      const cost::LightCost &la = a.lights.rows[i], &lb = b.lights.rows[i];
      lights.add_row({"slots: " + la.convention, fmt::format("{}", la.alu_slots),
                      fmt::format("{}", lb.alu_slots),
                      la.alu_slots == lb.alu_slots ? "=" : fmt::format("{:+d}", lb.alu_slots - la.alu_slots),
                      change_word(la.alu_slots, lb.alu_slots)});
      lights.add_row(
          {"words: " + la.convention, fmt::format("{:.0f}", la.alu_words),
           fmt::format("{:.0f}", lb.alu_words),
           la.alu_words == lb.alu_words ? "=" : fmt::format("{:+.0f}", lb.alu_words - la.alu_words),
           change_word(la.alu_words, lb.alu_words)});
    }
    text += "\n" + lights.text();
  }
  text += fmt::format("\nA {}\n{}\nB {}\n{}\npicture: {}", a.budget.sentence, sensitivity_text(a.budget),
                      b.budget.sentence, sensitivity_text(b.budget),
                      difference_text(d, a.frame.width, a.frame.rgba8, b.frame.rgba8));
  return text;
}

bool hurts(const Billed& a, const Billed& b) {
  const auto total = [](const Billed& billed, std::uint64_t passes::PassTotals::*member) {
    std::uint64_t sum = 0;
    for (const passes::PassTotals& pass : billed.frame.passes) sum += pass.*member;
    return sum;
  };
  return total(b, &passes::PassTotals::alu_words) > total(a, &passes::PassTotals::alu_words) ||
         total(b, &passes::PassTotals::fetch_cyc) > total(a, &passes::PassTotals::fetch_cyc) ||
         b.budget.derated_ms > a.budget.derated_ms;
}

}  // namespace aluminate::report
