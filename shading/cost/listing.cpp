#include "shading/cost/listing.hpp"

#include "platform/host/error.hpp"
#include "platform/host/suggest.hpp"
#include "platform/host/text_table.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace aluminate::cost {
namespace {

using host::Align;
using host::TextTable;
using Json = nlohmann::ordered_json;

/// Whole numbers without a point, others with two digits.
std::string count_text(double number) {
  return number == std::floor(number) ? fmt::format("{:.0f}", number) : fmt::format("{:.2f}", number);
}
std::string clocks(double number) { return number == 0 ? "-" : fmt::format("{:.2f}", number); }

std::string range_text(double low, double high) {
  return low == high ? fmt::format("{:.2f}", low) : fmt::format("{:.2f}-{:.2f}", low, high);
}

/// Short enough for the first column of a 100-column table.
std::string short_name(const std::string& name, std::size_t most = 22) {
  return name.size() <= most ? name : ".." + name.substr(name.size() - (most - 2));
}

std::string filter_sentence(const StaticCost& cost) {
  const int probes = cost.assumptions.anisotropy;
  return fmt::format(
      "8 bits a component, {}, {}, no cache misses",
      cost.assumptions.filter == FilterAssumption::Trilinear ? "trilinear" : "bilinear",
      probes > 1 ? fmt::format("{} samples a fetch (the most its anisotropy allows)", probes) : "no anisotropy");
}

TextTable cost_table(const std::vector<StaticCost>& costs) {
  TextTable table({{"program"},
                   {"words", Align::Right},
                   {"slots", Align::Right},
                   {"fetch", Align::Right},
                   {"GPRs", Align::Right},
                   {"thr", Align::Right},
                   {"ALU", Align::Right},
                   {"tex", Align::Right},
                   {"vtx", Align::Right},
                   {"seq", Align::Right},
                   {"interp", Align::Right},
                   {"bound"}});
  for (const StaticCost& cost : costs) {
    table.add_row({short_name(cost.name), count_text(cost.alu_words), std::to_string(cost.alu_slots),
                   std::to_string(cost.fetches), std::to_string(cost.gprs), std::to_string(cost.threads),
                   clocks(cost.cycles.alu), clocks(cost.cycles.texture), clocks(cost.cycles.vertex),
                   clocks(cost.cycles.sequencer), clocks(cost.cycles.interpolator),
                   cost_unit_name(cost.bound)});
  }
  return table;
}

std::vector<std::string> notes(const StaticCost& cost) {
  std::vector<std::string> lines;
  lines.push_back(fmt::format("{}: {}", short_name(cost.name, 30), cost.sentence));
  lines.push_back(fmt::format(
      "  {} vector + {} scalar operations in {} words, none of their schedules is under {}; {} texture slots",
      cost.vector_ops, cost.scalar_ops, count_text(cost.alu_words), cost.bound_words, cost.tex_slots));
  if (!cost.straight_line) {
    lines.push_back(fmt::format("  branches: {} to {} words, {} ALU clocks{}",
                                count_text(cost.shortest_words), count_text(cost.longest_words),
                                range_text(cost.shortest.alu, cost.longest.alu),
                                cost.paths_known ? "" : "; a loop of unknown length counts 0 to 1 times"));
  }
  if (!cost.per_light.loop.empty()) {
    lines.push_back(fmt::format("  per light ({}): {} slots, {} words, {} fetches", cost.per_light.convention,
                                cost.per_light.alu_slots, count_text(cost.per_light.alu_words),
                                cost.per_light.fetches));
  }
  return lines;
}

std::string platforms_line(const std::vector<StaticCost>& costs) {
  std::vector<std::string> seen;
  std::string text;
  for (const StaticCost& cost : costs) {
    if (std::find(seen.begin(), seen.end(), cost.platform) != seen.end()) continue;
    seen.push_back(cost.platform);
    text += fmt::format("{}{}: word = {}", text.empty() ? "platform  " : "          ", cost.platform,
                        cost.word_name);
    text += cost.assumptions.pairing == PairingRule::Loose ? " (loose pairing: sensitivity only)\n" : "\n";
  }
  return text;
}

std::string text_of(const std::vector<StaticCost>& costs) {
  std::string text =
      platforms_line(costs) +
      "static cost; ALU .. interp: clocks for 64 pixels (vertices), whole chip at peak rate\n\n";
  text += cost_table(costs).text() + "\n";
  for (const StaticCost& cost : costs) {
    for (const std::string& line : notes(cost)) text += line + "\n";
  }
  text +=
      "words = issue words after pairing; slots = ps_3_0 slots, textures apart; thr = threads in flight;\n";
  text += "bound = largest column, if enough threads. A dash is zero.\nTextures: " +
          (costs.empty() ? std::string("-") : filter_sentence(costs.front())) + ".\n";
  return text;
}

Json number(double value) {
  return value == std::floor(value) && std::abs(value) < 1e15 ? Json(static_cast<std::int64_t>(value))
                                                              : Json(value);
}

Json cycles_json(const UnitCycles& cycles) {
  return {{"alu", number(cycles.alu)},
          {"texture", number(cycles.texture)},
          {"vertex", number(cycles.vertex)},
          {"sequencer", number(cycles.sequencer)},
          {"interpolator", number(cycles.interpolator)}};
}

Json light_json(const LightCost& light) {
  if (light.loop.empty()) return nullptr;
  return {{"loop", light.loop},
          {"convention", light.convention},
          {"alu_words", number(light.alu_words)},
          {"alu_slots", light.alu_slots},
          {"fetches", light.fetches}};
}

Json cost_json(const StaticCost& cost) {
  Json entry;
  entry["name"] = cost.name;
  entry["platform"] = cost.platform;
  entry["alu_words"] = number(cost.alu_words);
  entry["alu_slots"] = cost.alu_slots;
  entry["vector_ops"] = cost.vector_ops;
  entry["scalar_ops"] = cost.scalar_ops;
  entry["fetches"] = cost.fetches;
  entry["fetch_cyc"] = number(cost.fetch_cyc);
  entry["interpolators"] = cost.interpolators;
  entry["gprs"] = cost.gprs;
  entry["threads"] = cost.threads;
  entry["cycles"] = cycles_json(cost.cycles);
  entry["bound"] = cost_unit_name(cost.bound);
  entry["per_light"] = light_json(cost.per_light);
  entry["cycles_per_vector"] = cost.cycles_per_vector;
  entry["tex_slots"] = cost.tex_slots;
  entry["exec_clauses"] = cost.exec_clauses;
  entry["bound_words"] = cost.bound_words;
  entry["straight_line"] = cost.straight_line;
  entry["shortest"] = {{"alu_words", number(cost.shortest_words)}, {"cycles", cycles_json(cost.shortest)}};
  entry["longest"] = {{"alu_words", number(cost.longest_words)}, {"cycles", cycles_json(cost.longest)}};
  entry["word"] = cost.word_name;
  entry["pairing"] = cost.assumptions.pairing == PairingRule::Strict ? "strict" : "loose";
  entry["texture_assumption"] = filter_sentence(cost);
  entry["sentence"] = cost.sentence;
  return entry;
}

std::string tsv_of(const std::vector<StaticCost>& costs) {
  TextTable table({{"name"},
                   {"platform"},
                   {"alu_words"},
                   {"alu_slots"},
                   {"vector_ops"},
                   {"scalar_ops"},
                   {"fetches"},
                   {"fetch_cyc"},
                   {"interpolators"},
                   {"gprs"},
                   {"threads"},
                   {"cycles_alu"},
                   {"cycles_texture"},
                   {"cycles_vertex"},
                   {"cycles_sequencer"},
                   {"cycles_interpolator"},
                   {"cycles_per_vector"},
                   {"bound"},
                   {"per_light_loop"},
                   {"per_light_alu_words"},
                   {"per_light_alu_slots"},
                   {"per_light_fetches"}});
  for (const StaticCost& cost : costs) {
    const LightCost& light = cost.per_light;
    const bool lit = !light.loop.empty();
    table.add_row({cost.name,
                   cost.platform,
                   fmt::format("{}", cost.alu_words),
                   std::to_string(cost.alu_slots),
                   std::to_string(cost.vector_ops),
                   std::to_string(cost.scalar_ops),
                   std::to_string(cost.fetches),
                   fmt::format("{}", cost.fetch_cyc),
                   std::to_string(cost.interpolators),
                   std::to_string(cost.gprs),
                   std::to_string(cost.threads),
                   fmt::format("{:.4f}", cost.cycles.alu),
                   fmt::format("{:.4f}", cost.cycles.texture),
                   fmt::format("{:.4f}", cost.cycles.vertex),
                   fmt::format("{:.4f}", cost.cycles.sequencer),
                   fmt::format("{:.4f}", cost.cycles.interpolator),
                   std::to_string(cost.cycles_per_vector),
                   cost_unit_name(cost.bound),
                   light.loop,
                   lit ? fmt::format("{}", light.alu_words) : "",
                   lit ? std::to_string(light.alu_slots) : "",
                   lit ? std::to_string(light.fetches) : ""});
  }
  return table.tsv();
}

std::string markdown_of(const std::vector<StaticCost>& costs) {
  std::string text = cost_table(costs).markdown() + "\n";
  for (const StaticCost& cost : costs) {
    for (const std::string& line : notes(cost))
      text += (line.starts_with("  ") ? "  - " + line.substr(2) : "- " + line) + "\n";
  }
  text +=
      "\nStatic cost. ALU to interp: clocks for 64 pixels (vertices), whole chip at peak rate; words = issue "
      "words after pairing; "
      "slots = ps_3_0 slots, textures apart; bound = largest column, if enough threads.\n";
  return text;
}

/// The comment shape of the period's compiler, so that old notes and new ones can stand side by side.
std::string fxc360_of(const StaticCost& cost) {
  const UnitCycles &low = cost.shortest, &high = cost.longest;
  const auto whole = [](double a, double b) {
    return a == b ? count_text(a) : count_text(a) + "-" + count_text(b);
  };
  const int least = static_cast<int>(std::floor(low.worst() + 1e-9)),
            most = static_cast<int>(std::floor(high.worst() + 1e-9));
  std::string text;
  text += fmt::format("// {} ({})\n", cost.name, cost.platform);
  text += fmt::format("// Shader Timing Estimate, in Cycles/64 {} vector:\n",
                      cost.stage == vm::Stage::Vertex ? "vertex" : "pixel");
  text += fmt::format("// ALU: {} ({} instructions), vertex: {}, texture: {},\n",
                      range_text(low.alu, high.alu), whole(cost.shortest_words, cost.longest_words),
                      whole(low.vertex, high.vertex), whole(low.texture, high.texture));
  text += fmt::format("//   sequencer: {}, interpolator: {};    {} {}, {} threads,\n",
                      whole(low.sequencer, high.sequencer), whole(low.interpolator, high.interpolator),
                      cost.gprs, cost.gprs == 1 ? "GPR" : "GPRs", cost.threads);
  text += fmt::format("// Performance (if enough threads): ~{} cycles per vector\n",
                      least == most ? std::to_string(most) : fmt::format("{}-{}", least, most));
  text += "// * texture cycles assume " + filter_sentence(cost) + "\n";
  text += fmt::format("// * instructions are {}s; branches: shortest to longest path\n", cost.word_name);
  return text;
}

std::string place_text(const StaticCost& cost, const vm::SourceLine& line) {
  if (line.line == 0) return "-";
  const std::string file = line.file < cost.files.size() ? cost.files[line.file] : "";
  const auto slash = file.find_last_of('/');
  const std::string base = slash == std::string::npos ? file : file.substr(slash + 1);
  return base.empty() ? std::to_string(line.line) : short_name(base, 24) + ":" + std::to_string(line.line);
}

Json listing_json(const StaticCost& cost) {
  Json rows = Json::array();
  for (const ListingRow& row : cost.listing) {
    rows.push_back({{"block", row.block},
                    {"clause", row.clause},
                    {"word", row.word},
                    {"pipe", row.pipe},
                    {"instruction", row.text},
                    {"file", row.line.file < cost.files.size() ? cost.files[row.line.file] : ""},
                    {"line", row.line.line},
                    {"alu_slots", row.alu_slots}});
  }
  return {{"name", cost.name}, {"platform", cost.platform}, {"listing", std::move(rows)}};
}

}  // namespace

Format parse_format(const std::string& word) {
  const std::vector<std::string> known = {"text", "json", "tsv", "markdown", "fxc360"};
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (known[i] == word) return static_cast<Format>(i);
  }
  throw UserError(fmt::format("unknown format '{}'", word), host::did_you_mean(word, known));
}

std::string format_cost(const std::vector<StaticCost>& costs, Format format) {
  switch (format) {
    case Format::Text:
      return text_of(costs);
    case Format::Tsv:
      return tsv_of(costs);
    case Format::Markdown:
      return markdown_of(costs);
    case Format::Json: {
      Json document = {{"programs", Json::array()}};
      for (const StaticCost& cost : costs) document["programs"].push_back(cost_json(cost));
      return document.dump(2) + "\n";
    }
    case Format::Fxc360: {
      std::string text;
      for (const StaticCost& cost : costs) text += (text.empty() ? "" : "\n") + fxc360_of(cost);
      return text;
    }
  }
  return "";
}

std::string format_listing(const StaticCost& cost, Format format) {
  if (format == Format::Json) return listing_json(cost).dump(2) + "\n";
  TextTable table({{"word", Align::Right}, {"pipe"}, {"instruction"}, {"slots", Align::Right}, {"source"}});
  const bool flat = format == Format::Tsv;
  int block = -1, clause = -1, word = -1, shown = -1;
  for (const ListingRow& row : cost.listing) {
    if (!flat && (row.block != block || row.clause != clause)) {
      const std::string trips =
          cost.blocks[static_cast<std::size_t>(row.block)].static_trips > 1
              ? fmt::format(" x{}", cost.blocks[static_cast<std::size_t>(row.block)].static_trips)
              : "";
      table.add_row({"", "", fmt::format("-- block {}{}, clause {}", row.block, trips, row.clause), "", ""});
    }
    if (row.block != block) {
      word = -1;
      shown = -1;
    }
    const bool fetch = row.pipe == "T";
    if (row.word != word && !fetch) ++shown;
    // Words are numbered as the ALU issues them, from 0 in each block; the second half of a word repeats no
    // number.
    const std::string label = fetch ? "" : row.word == word ? "+" : std::to_string(shown);
    table.add_row({label, row.pipe, flat || row.text.size() <= 52 ? row.text : row.text.substr(0, 50) + "..",
                   row.alu_slots > 0 ? std::to_string(row.alu_slots) : "-", place_text(cost, row.line)});
    block = row.block;
    clause = row.clause;
    word = row.word;
  }
  if (flat) return table.tsv();
  if (format == Format::Markdown) return table.markdown();
  std::string text =
      fmt::format("{} on {}: {} words, {} slots, {} fetches, {} GPRs\n\n", cost.name, cost.platform,
                  count_text(cost.alu_words), cost.alu_slots, cost.fetches, cost.gprs);
  text += table.text() + "\n";
  text +=
      "word = issue word of the block, '+' its other half; pipe V vec4, S scalar, T fetch;\n"
      "slots = ps_3_0, on the first row of each instruction; rows without slots are the console's own\n";
  if (format != Format::Fxc360) return text;
  std::string commented;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    commented += (end == begin ? std::string("//") : "// " + text.substr(begin, end - begin)) + "\n";
    begin = end + 1;
  }
  return commented;
}

std::vector<std::string> listing_lines(const StaticCost& cost) {
  std::vector<std::string> lines;
  int block = 0, word = -1;
  for (const ListingRow& row : cost.listing) {
    if (row.block != block) lines.push_back(fmt::format("block {}", row.block));
    const bool other_half = row.block == block && row.word == word && row.pipe != "T";
    lines.push_back(fmt::format("{}{} {}", other_half ? "+ " : "", row.pipe, row.text));
    block = row.block;
    word = row.word;
  }
  return lines;
}

}  // namespace aluminate::cost
