#include "shading/report/golden.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "shading/cost/listing.hpp"

namespace aluminate::report {
namespace {

double real(std::uint64_t count) { return static_cast<double>(count); }  // counts stay far below 2^53

GoldenSection pass_section(const passes::PassTotals& pass, const console::PassTime& time) {
  return {"pass",
          pass.name,
          {{"pixels", real(pass.pixels)},
           {"quads", real(pass.quads)},
           {"helper_lanes", real(pass.helper_lanes)},
           {"alu_words", real(pass.alu_words)},
           {"alu_slots", real(pass.alu_slots)},
           {"fetches", real(pass.fetches)},
           {"fetch_cyc", real(pass.fetch_cyc)},
           {"vertices", real(pass.vertices)},
           {"vertex_words", real(pass.vertex_words)},
           {"triangles", real(pass.triangles)},
           {"rop_pixels", real(pass.rop_pixels)},
           {"rop_blended", real(pass.rop_blended)},
           {"bytes", real(pass.bytes)},
           {"derated_ms", time.derated}},
          {}};
}

GoldenSection program_section(const cost::StaticCost& cost) {
  GoldenSection section{"program",
                        cost.name,
                        {{"alu_words", cost.alu_words},
                         {"alu_slots", real(static_cast<std::uint64_t>(cost.alu_slots))},
                         {"vector_ops", static_cast<double>(cost.vector_ops)},
                         {"scalar_ops", static_cast<double>(cost.scalar_ops)},
                         {"fetches", static_cast<double>(cost.fetches)},
                         {"fetch_cyc", cost.fetch_cyc},
                         {"interpolators", static_cast<double>(cost.interpolators)},
                         {"gprs", static_cast<double>(cost.gprs)},
                         {"threads", static_cast<double>(cost.threads)},
                         {"alu_clk", cost.cycles.alu},
                         {"texture_clk", cost.cycles.texture},
                         {"vertex_clk", cost.cycles.vertex},
                         {"sequencer_clk", cost.cycles.sequencer},
                         {"interpolator_clk", cost.cycles.interpolator},
                         {"vector_clk", static_cast<double>(cost.cycles_per_vector)}},
                        cost::listing_lines(cost)};
  return section;
}

// Two surfaces may share a label: the second one is "label #2".
void name_apart(std::vector<GoldenSection>& sections) {
  for (std::size_t i = 0; i < sections.size(); ++i) {
    int same = 1;
    for (std::size_t j = 0; j < i; ++j)
      same += sections[j].kind == sections[i].kind &&
              sections[j].name.substr(0, sections[j].name.find(" #")) == sections[i].name;
    if (same > 1) sections[i].name += fmt::format(" #{}", same);
  }
}

// What a key says about better and worse. Pixels, quads and triangles are what the scene is, not what it
// costs.
Change direction(const std::string& key, double before, double after) {
  static constexpr std::string_view kCosts[] = {"alu_words", "alu_slots", "vector_ops",   "scalar_ops",
                                                "fetches",   "fetch_cyc", "vertex_words", "interpolators",
                                                "gprs",      "bytes",     "helper_lanes", "rop_blended"};
  if (before == after) return Change::None;
  const bool cost = std::find(std::begin(kCosts), std::end(kCosts), key) != std::end(kCosts) ||
                    key.ends_with("_ms") || key.ends_with("_clk");
  if (cost) return after < before ? Change::Helped : Change::Hurt;
  if (key == "threads") return after > before ? Change::Helped : Change::Hurt;
  return Change::Other;
}

const GoldenSection* find_section(const Golden& golden, const GoldenSection& like) {
  for (const GoldenSection& section : golden.sections)
    if (section.kind == like.kind && section.name == like.name) return &section;
  return nullptr;
}

const GoldenFigure* find_figure(const GoldenSection& section, const std::string& key) {
  for (const GoldenFigure& figure : section.figures)
    if (figure.key == key) return &figure;
  return nullptr;
}

void compare_sections(const GoldenSection& before, const GoldenSection& after, GoldenDifference& difference) {
  for (const GoldenFigure& figure : after.figures) {
    const GoldenFigure* old = find_figure(before, figure.key);
    if (old == nullptr) {
      difference.figures.push_back({after.label(), figure.key, 0, figure.value, false, true, Change::Other});
    } else if (old->value != figure.value) {
      difference.figures.push_back({after.label(), figure.key, old->value, figure.value, true, true,
                                    direction(figure.key, old->value, figure.value)});
    }
  }
  for (const GoldenFigure& figure : before.figures)
    if (find_figure(after, figure.key) == nullptr)
      difference.figures.push_back({before.label(), figure.key, figure.value, 0, true, false, Change::Other});
  const auto parted = std::mismatch(before.instructions.begin(), before.instructions.end(),
                                    after.instructions.begin(), after.instructions.end());
  if (parted.first == before.instructions.end() && parted.second == after.instructions.end()) return;
  difference.instructions.push_back({after.label(),
                                     static_cast<std::size_t>(parted.second - after.instructions.begin()),
                                     parted.first == before.instructions.end() ? "" : *parted.first,
                                     parted.second == after.instructions.end() ? "" : *parted.second});
}

}  // namespace

Golden golden_of(const std::string& check, const Billed& billed, bool with_image, bool with_cost) {
  const passes::Frame& frame = billed.frame;
  Golden golden{check, canonical_command("render", billed.origin), frame.width, frame.height, "", {}};
  if (with_image) golden.image_hash = image_hash(frame);
  if (!with_cost) return golden;
  golden.sections.push_back(
      {"frame", "", {{"derated_ms", billed.budget.derated_ms}, {"peak_ms", billed.budget.peak_ms}}, {}});
  for (std::size_t i = 0; i < frame.passes.size(); ++i)
    golden.sections.push_back(pass_section(frame.passes[i], billed.budget.passes[i]));
  for (const passes::PathInfo& path : frame.paths)
    golden.sections.push_back({"program",
                               path.program,
                               {{"alu_words", static_cast<double>(path.alu_words)},
                                {"alu_slots", static_cast<double>(path.alu_slots)},
                                {"fetches", static_cast<double>(path.fetches)},
                                {"fetch_cyc", static_cast<double>(path.fetch_cyc)}},
                               path.instructions});
  name_apart(golden.sections);
  return golden;
}

Golden golden_of(const std::string& check, const std::string& command,
                 const std::vector<cost::StaticCost>& costs) {
  Golden golden{check, command, 0, 0, "", {}};
  for (const cost::StaticCost& cost : costs) golden.sections.push_back(program_section(cost));
  name_apart(golden.sections);
  return golden;
}

std::string_view change_word(Change change) {
  constexpr std::string_view kWords[] = {"same", "helped", "HURT", "changed"};
  return kWords[static_cast<std::size_t>(change)];
}

Change GoldenDifference::cost_change() const {
  if (!cost_differs()) return Change::None;
  const auto any = [&](Change change) {
    return std::any_of(figures.begin(), figures.end(),
                       [&](const FigureChange& f) { return f.change == change; });
  };
  return any(Change::Hurt) ? Change::Hurt : any(Change::Helped) ? Change::Helped : Change::Other;
}

GoldenDifference compare_goldens(const Golden& accepted, const Golden& found) {
  GoldenDifference difference;
  difference.image_differs = accepted.image_hash != found.image_hash;
  for (const GoldenSection& section : found.sections) {
    if (const GoldenSection* before = find_section(accepted, section)) {
      compare_sections(*before, section, difference);
    } else {
      difference.figures.push_back({section.label(), "(new)", 0, 0, false, true, Change::Other});
    }
  }
  for (const GoldenSection& section : accepted.sections)
    if (find_section(found, section) == nullptr)
      difference.figures.push_back({section.label(), "(gone)", 0, 0, true, false, Change::Other});
  return difference;
}

}  // namespace aluminate::report
