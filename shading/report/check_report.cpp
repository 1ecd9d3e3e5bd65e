#include "shading/report/check_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "platform/host/text_table.hpp"

namespace aluminate::report {
namespace {

constexpr std::size_t kMostFigures = 16;  // of one check; the golden's own diff shows the rest

// The state as one word; a regression and a broken check catch the eye without colour.
std::string state_word(const CheckResult& result) {
  switch (result.outcome) {
    case Outcome::Ok:
      return "ok";
    case Outcome::Differs: {
      const std::string cost(result.difference.cost_differs() ? change_word(result.difference.cost_change())
                                                              : "");
      return !result.difference.image_differs ? cost : cost.empty() ? "DIFF" : "DIFF+" + cost;
    }
    case Outcome::OverBudget:
      return "OVER";
    case Outcome::Missing:
      return "MISSING";
    case Outcome::Extra:
      return "EXTRA";
    case Outcome::Unstable:
      return "UNSTABLE";
    case Outcome::Accepted:
      return "accepted";
    case Outcome::Removed:
      return "removed";
    case Outcome::Error:
      return "ERROR";
  }
  return "";
}

bool fine(const CheckResult& result) {
  return result.outcome == Outcome::Ok || result.outcome == Outcome::Accepted ||
         result.outcome == Outcome::Removed;
}

// Counts in full; other numbers short, unless that hides the change.
std::string number_text(double value, double other) {
  const std::string brief = fmt::format("{:.6g}", value);
  return value == std::floor(value) || brief == fmt::format("{:.6g}", other) ? fmt::format("{}", value)
                                                                             : brief;
}

std::string figure_line(const FigureChange& change) {
  if (!change.was_there || !change.is_there) {
    const std::string what = change.key.starts_with('(') ? change.section : change.section + " " + change.key;
    return what + (change.was_there ? ": gone" : ": new");
  }
  const double delta = change.after - change.before;
  const std::string share =
      change.before != 0 ? fmt::format(", {:+.1f} %", 100.0 * delta / change.before) : "";
  return fmt::format("{}: {} {} -> {} ({:+.6g}{}) {}", change.section, change.key,
                     number_text(change.before, change.after), number_text(change.after, change.before),
                     delta, share, change_word(change.change));
}

std::string pixel_text(const std::array<int, 4>& p) {
  return fmt::format("{} {} {} {}", p[0], p[1], p[2], p[3]);
}

void add_image_lines(const CheckResult& result, std::vector<std::string>& lines) {
  const Golden &before = result.accepted, &after = result.found;
  if (before.image_hash.empty() != after.image_hash.empty()) {
    lines.push_back(before.image_hash.empty() ? "the picture was not part of what was accepted"
                                              : "the picture is no longer compared");
    return;
  }
  if (before.width != after.width || before.height != after.height) {
    lines.push_back(
        fmt::format("picture {}x{} -> {}x{} px", before.width, before.height, after.width, after.height));
    return;
  }
  const ImageDifference& d = result.image;
  lines.push_back(fmt::format("{} of {} pixels differ ({:.2f} %), largest {} of 255 at ({}, {})", d.differing,
                              d.pixels,
                              100.0 * static_cast<double>(d.differing) / static_cast<double>(d.pixels),
                              d.max_step, d.worst_x, d.worst_y));
  if (result.pixel.x >= 0)
    lines.push_back(fmt::format("first at ({}, {}): RGBA {} -> {} of 255, {}", result.pixel.x, result.pixel.y,
                                pixel_text(result.pixel.before), pixel_text(result.pixel.after),
                                result.pixel.draw.empty() ? "background" : result.pixel.draw));
}

void add_cost_lines(const GoldenDifference& difference, std::vector<std::string>& lines) {
  std::size_t shown = 0;
  for (const FigureChange& change : difference.figures)
    if (shown++ < kMostFigures) lines.push_back(figure_line(change));
  if (shown > kMostFigures) lines.push_back(fmt::format("and {} more figures", shown - kMostFigures));
  for (const InstructionChange& change : difference.instructions)
    lines.push_back(fmt::format("{}: first differing instruction, issue {}: {} -> {}", change.section,
                                change.line, change.before.empty() ? "(end)" : change.before,
                                change.after.empty() ? "(end)" : change.after));
}

std::vector<std::string> change_lines(const CheckResult& result) {
  std::vector<std::string> lines;
  if (result.difference.image_differs) add_image_lines(result, lines);
  add_cost_lines(result.difference, lines);
  return lines;
}

std::vector<std::string> detail_lines(const CheckResult& result) {
  std::vector<std::string> lines;
  const std::string accept = "accept  aluminate check --update " + result.name;
  switch (result.outcome) {
    case Outcome::Ok:
    case Outcome::Accepted:
    case Outcome::Removed:
      return change_lines(result);
    case Outcome::Differs:
      lines = change_lines(result);
      if (!result.page.empty()) lines.push_back("look    " + result.page);
      lines.push_back(accept);
      return lines;
    case Outcome::OverBudget:
      return {
          fmt::format("{:.3f} ms of console time, the budget is {:g} ms", result.frame_ms, result.budget_ms)};
    case Outcome::Missing:
      lines.push_back(result.renamed_from.empty()
                          ? "nothing was ever accepted under this name"
                          : fmt::format("same contents as the golden '{}': renamed?", result.renamed_from));
      lines.push_back(result.renamed_from.empty() ? accept : accept + " " + result.renamed_from);
      return lines;
    case Outcome::Extra:
      return {"a golden that no check names", "remove  aluminate check --update " + result.name};
    case Outcome::Unstable:
      lines = change_lines(result);
      lines.emplace_back(
          "two renderings with other threads and vector widths disagree: nothing can be accepted; this is a "
          "bug in aluminate");
      return lines;
    case Outcome::Error: {
      for (std::size_t begin = 0; begin <= result.message.size();) {
        const std::size_t end = std::min(result.message.find('\n', begin), result.message.size());
        lines.push_back(result.message.substr(begin, end - begin));
        begin = end + 1;
      }
      return lines;
    }
  }
  return lines;
}

std::string summary(const CheckRun& run) {
  std::vector<std::pair<std::string, int>> words;
  for (const CheckResult& result : run.results) {
    const std::string word = state_word(result);
    auto found = words.begin();
    while (found != words.end() && found->first != word) ++found;
    if (found == words.end()) found = words.insert(words.end(), {word, 0});
    ++found->second;
  }
  std::string text;
  for (const auto& [word, count] : words)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, word);
  return text.empty() ? "no checks" : text;
}

std::string hash_text(const CheckResult& result) {
  return result.found.image_hash.empty() ? "" : result.found.image_hash.substr(0, 8);
}

std::string xml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '"') {
      out += "&quot;";
    } else if (byte < 0x20 && c != '\n' && c != '\t') {
      out += ' ';  // XML 1.0 cannot hold it
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

std::string difference_lines(const GoldenDifference& difference) {
  std::vector<std::string> lines;
  add_cost_lines(difference, lines);
  std::string text = lines.empty() ? "no change in cost\n" : "";
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::string check_text(const CheckRun& run) {
  host::TextTable table({{"check"}, {"result"}, {"picture"}, {"frame ms", host::Align::Right}});
  for (const CheckResult& result : run.results)
    table.add_row({result.name, state_word(result), hash_text(result),
                   result.frame_ms > 0 ? fmt::format("{:.3f}", result.frame_ms) : "-"});
  std::string text = table.text();
  for (const CheckResult& result : run.results) {
    const std::vector<std::string> lines = detail_lines(result);
    if (lines.empty()) continue;
    text += fmt::format("\n{}  {}\n", state_word(result), result.name);
    for (const std::string& line : lines) text += "  " + line + "\n";
  }
  return text + "\n" + summary(run) + "\n";
}

std::string check_markdown(const CheckRun& run) {
  std::string text = fmt::format("**aluminate check**: {}\n\n", summary(run));
  host::TextTable table({{"check"}, {"result"}, {"picture"}, {"frame ms", host::Align::Right}});
  for (const CheckResult& result : run.results)
    table.add_row({result.name, fine(result) ? state_word(result) : "**" + state_word(result) + "**",
                   hash_text(result), result.frame_ms > 0 ? fmt::format("{:.3f}", result.frame_ms) : "-"});
  text += table.markdown();
  for (const CheckResult& result : run.results) {
    const std::vector<std::string> lines = detail_lines(result);
    if (lines.empty()) continue;
    text += fmt::format("\n`{}` {}\n\n```\n", result.name, state_word(result));
    for (const std::string& line : lines) text += line + "\n";
    text += "```\n";
  }
  return text;
}

std::string check_junit(const CheckRun& run) {
  int failures = 0;
  double seconds = 0;
  for (const CheckResult& result : run.results) {
    failures += !fine(result) && result.outcome != Outcome::Error;
    seconds += result.seconds;
  }
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite name=\"aluminate check\" "
      "tests=\"{}\" failures=\"{}\" "
      "errors=\"{}\" time=\"{:.3f}\">\n",
      run.results.size(), failures, run.count(Outcome::Error), seconds);
  for (const CheckResult& result : run.results) {
    const auto slash = result.name.find_last_of('/');
    const std::string folder = slash == std::string::npos ? "check" : result.name.substr(0, slash);
    text += fmt::format("<testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"", xml(folder),
                        xml(result.name), result.seconds);
    if (fine(result)) {
      text += "/>\n";
      continue;
    }
    std::string body;
    for (const std::string& line : detail_lines(result)) body += line + "\n";
    const char* tag = result.outcome == Outcome::Error ? "error" : "failure";
    text += fmt::format(">\n<{0} message=\"{1}\">{2}</{0}>\n</testcase>\n", tag, xml(state_word(result)),
                        xml(body));
  }
  return text + "</testsuite>\n</testsuites>\n";
}

}  // namespace aluminate::report
