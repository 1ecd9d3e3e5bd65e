// The text of a golden: TOML, one quantity a line, so that version control shows what an accepted change was.
#include <fmt/format.h>

#include <algorithm>

#include "platform/host/toml_text.hpp"
#include "shading/report/golden.hpp"

namespace aluminate::report {
namespace {

constexpr int kSchema = 1;
constexpr const char* kHint =
    "goldens are written by 'aluminate check --update NAME'; accept again, or restore the file";

// A basic TOML string: what instructions and names may hold is quoted so that any byte sequence survives.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      out += fmt::format("\\u{:04x}", byte);
    } else {
      out += c;
    }
  }
  return out + "\"";
}

class GoldenReader {
 public:
  GoldenReader(std::string_view text, std::string path)
      : path_(std::move(path)), root_(host::parse_toml(text, path_, kHint)) {}

  Golden read() {
    static const std::string kKeys[] = {"golden", "check", "command", "image", "frame", "pass", "program"};
    host::refuse_unknown_keys(root_, kKeys, "a golden", path_);
    const double schema = number(root_, "golden");
    if (schema != kSchema)
      refuse(*root_.get("golden"),
             fmt::format("written in format {}, this program reads {}", schema, kSchema));
    golden_.check = text(root_, "check");
    golden_.command = text(root_, "command");
    if (const toml::node* image = root_.get("image")) read_image(table_of(*image, "image"));
    if (const toml::node* frame = root_.get("frame")) read_section("frame", "", table_of(*frame, "frame"));
    for (const char* kind : {"pass", "program"}) {
      const toml::node* sections = root_.get(kind);
      if (sections == nullptr) continue;
      for (const auto& [name, node] : table_of(*sections, kind))
        read_section(kind, std::string(name.str()), table_of(node, name.str()));
    }
    // Tables come sorted by name; the file's order is the order of the passes.
    std::stable_sort(order_.begin(), order_.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [line, section] : order_) golden_.sections.push_back(std::move(section));
    return std::move(golden_);
  }

 private:
  [[noreturn]] void refuse(const toml::node& node, const std::string& what) const {
    throw UserError(host::toml_place(path_, node.source()), what, kHint);
  }

  const toml::table& table_of(const toml::node& node, std::string_view name) const {
    if (!node.is_table())
      refuse(node, fmt::format("[{}] must be a table, found {}", name, host::toml_kind(node)));
    return *node.as_table();
  }

  const toml::node& need(const toml::table& table, std::string_view key) const {
    const toml::node* node = table.get(key);
    if (node == nullptr)
      throw UserError(host::toml_place(path_, table.source()), fmt::format("'{}' is missing", key), kHint);
    return *node;
  }

  double number(const toml::table& table, std::string_view key) const {
    const toml::node& node = need(table, key);
    if (!node.is_number())
      refuse(node, fmt::format("'{}' must be a number, found {}", key, host::toml_kind(node)));
    return *node.value<double>();
  }

  std::string text(const toml::table& table, std::string_view key) const {
    const toml::node& node = need(table, key);
    if (!node.is_string())
      refuse(node, fmt::format("'{}' must be a string, found {}", key, host::toml_kind(node)));
    return **node.as_string();
  }

  void read_image(const toml::table& image) {
    static const std::string kKeys[] = {"width_px", "height_px", "xxh3_128"};
    host::refuse_unknown_keys(image, kKeys, "[image]", path_);
    const double width = number(image, "width_px"), height = number(image, "height_px");
    for (const double side : {width, height})
      if (!(side >= 1 && side <= 16384 && side == static_cast<int>(side)))
        refuse(*image.get("width_px"), fmt::format("{}x{} is no picture size", width, height));
    golden_.width = static_cast<int>(width);
    golden_.height = static_cast<int>(height);
    golden_.image_hash = text(image, "xxh3_128");
    const bool hex = golden_.image_hash.size() == 32 &&
                     golden_.image_hash.find_first_not_of("0123456789abcdef") == std::string::npos;
    if (!hex)
      refuse(*image.get("xxh3_128"),
             fmt::format("'{}' is no hash of 32 hexadecimal digits", golden_.image_hash));
  }

  void read_section(const std::string& kind, const std::string& name, const toml::table& table) {
    std::vector<std::pair<toml::source_index, GoldenFigure>> figures;
    GoldenSection section{kind, name, {}, {}};
    for (const auto& [key, node] : table) {
      if (key.str() == "instructions" && kind == "program") {
        if (!node.is_array()) refuse(node, "'instructions' must be an array of strings");
        for (const toml::node& line : *node.as_array()) {
          if (!line.is_string()) refuse(line, "'instructions' must be an array of strings");
          section.instructions.push_back(**line.as_string());
        }
        continue;
      }
      figures.emplace_back(key.source().begin.line,
                           GoldenFigure{std::string(key.str()), number(table, key.str())});
    }
    std::stable_sort(figures.begin(), figures.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [line, figure] : figures) section.figures.push_back(std::move(figure));
    order_.emplace_back(table.source().begin.line, std::move(section));
  }

  std::string path_;
  toml::table root_;
  Golden golden_;
  std::vector<std::pair<toml::source_index, GoldenSection>> order_;
};

}  // namespace

std::string write_golden(const Golden& golden) {
  std::string text = fmt::format(
      "# Accepted with: aluminate check --update {}\n# Compared exactly; better and worse both fail until "
      "accepted.\n"
      "golden = {}\ncheck = {}\ncommand = {}\n",
      golden.check, kSchema, quoted(golden.check), quoted(golden.command));
  if (!golden.image_hash.empty())
    text += fmt::format("\n[image]\nwidth_px = {}\nheight_px = {}\nxxh3_128 = \"{}\"\n", golden.width,
                        golden.height, golden.image_hash);
  for (const GoldenSection& section : golden.sections) {
    text += section.name.empty() ? fmt::format("\n[{}]\n", section.kind)
                                 : fmt::format("\n[{}.{}]\n", section.kind, quoted(section.name));
    // {} is the shortest text that reads back as the same double.
    for (const GoldenFigure& figure : section.figures)
      text += fmt::format("{} = {}\n", figure.key, figure.value);
    if (section.instructions.empty()) continue;
    text += "instructions = [\n";
    for (const std::string& line : section.instructions) text += fmt::format("  {},\n", quoted(line));
    text += "]\n";
  }
  return text;
}

Golden parse_golden(std::string_view text, const std::string& path) {
  return GoldenReader(text, path).read();
}

}  // namespace aluminate::report
