#include "platform/console/platform_file.hpp"

#include "platform/host/error.hpp"
#include "platform/host/suggest.hpp"
#include "platform/host/text_table.hpp"
#include "platform/host/toml_text.hpp"

#include <cmath>
#include <fstream>
#include <sstream>

namespace aluminate::console {
namespace {

constexpr AluModel kAluModels[] = {AluModel::Vec4PlusScalar, AluModel::DualSu, AluModel::Vliw5,
                                   AluModel::ScalarLane, AluModel::MaliWord};

class PlatformReader {
 public:
  PlatformReader(std::string_view text, std::string path) : path_(std::move(path)) {
    model_.path = path_;
    root_ = host::parse_toml(
        text, path_,
        "each figure looks like: core_mhz = { value = 500, source = \"KEY\", confidence = \"doc\" }");
  }

  GpuModel read() {
    refuse_unknown_keys();
    model_.id = read_text(root_, "id");
    model_.name = read_text(root_, "name");
    model_.notes = read_text(root_, "notes");
    model_.year = read_year();
    model_.alu_model = read_alu_model();
    for (const FigureField& field : figure_fields()) {
      const toml::node* table = root_.get(field.table);
      if (table == nullptr && field.optional_table) continue;
      if (table == nullptr)
        throw UserError(place(root_.source()), fmt::format("table [{}] is missing", field.table),
                        shape_hint(field));
      read_figure(*table->as_table(), field);
    }
    const double reject = model_.depth.reject_samples.value;
    if (reject != 1 && reject != 4 && reject != 8 && reject != 16)
      throw UserError(place(root_.at_path("depth.reject_samples.value").node()->source()),
                      fmt::format("depth.reject_samples = {} is no block the rasterizer knows", reject),
                      "allowed: 1 (each sample), 4, 8 or 16 samples");
    return std::move(model_);
  }

 private:
  SourcePlace place(const toml::source_region& region) const { return host::toml_place(path_, region); }

  static std::string shape_hint(const FigureField& field) {
    return fmt::format("[{}] {} = {{ value = N, source = \"KEY\", confidence = \"doc\" }}   # {}, {}",
                       field.table, field.key, field.unit, field.meaning);
  }

  void refuse_unknown_keys() const {
    std::vector<std::string> top = {"id", "name", "year", "notes", "alu_model"};
    for (const FigureField& field : figure_fields()) {
      if (top.back() != field.table) top.emplace_back(field.table);
    }
    host::refuse_unknown_keys(root_, top, "a platform file", path_);
    for (const auto& [key, node] : root_) {
      std::vector<std::string> known;
      for (const FigureField& field : figure_fields()) {
        if (field.table == key.str()) known.emplace_back(field.key);
      }
      if (known.empty()) continue;
      if (!node.is_table()) {
        throw UserError(place(node.source()),
                        fmt::format("[{}] must be a table, found {}", key.str(), host::toml_kind(node)));
      }
      host::refuse_unknown_keys(*node.as_table(), known, fmt::format("[{}]", key.str()), path_);
    }
  }

  const toml::node& need(const toml::table& table, std::string_view key, const std::string& hint) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) throw UserError(place(table.source()), fmt::format("'{}' is missing", key), hint);
    return *node;
  }

  std::string read_text(const toml::table& table, std::string_view key) const {
    const toml::node& node = need(table, key, fmt::format("add {} = \"...\"", key));
    if (!node.is_string()) {
      throw UserError(place(node.source()),
                      fmt::format("'{}' must be a string, found {}", key, host::toml_kind(node)));
    }
    std::string text = **node.as_string();
    if (text.find_first_not_of(" \t\n") == std::string::npos) {
      throw UserError(place(node.source()), fmt::format("'{}' must not be empty", key));
    }
    return text;
  }

  int read_year() const {
    const toml::node& node = need(root_, "year", "add the year it shipped, for example year = 2005");
    if (!node.is_integer())
      throw UserError(place(node.source()),
                      fmt::format("'year' must be an integer, found {}", host::toml_kind(node)));
    const std::int64_t year = **node.as_integer();
    if (year < 1970 || year > 2100) {
      throw UserError(place(node.source()), fmt::format("year {} is outside 1970..2100", year));
    }
    return static_cast<int>(year);
  }

  AluModel read_alu_model() const {
    const std::string word = read_text(root_, "alu_model");
    std::vector<std::string> known;
    for (AluModel model : kAluModels) {
      if (alu_model_word(model) == word) return model;
      known.emplace_back(alu_model_word(model));
    }
    throw UserError(place(root_.get("alu_model")->source()), fmt::format("unknown alu_model '{}'", word),
                    host::did_you_mean(word, known));
  }

  /// A finite number within the field's limits.
  double read_number(const toml::table& entry, std::string_view key, const FigureField& field) const {
    const toml::node& node = need(entry, key, shape_hint(field));
    if (!node.is_number()) {
      throw UserError(place(node.source()),
                      fmt::format("{} of {}.{} must be a number, found {}", key, field.table, field.key,
                                  host::toml_kind(node)),
                      fmt::format("unit: {}", field.unit));
    }
    const double number = *node.value<double>();
    const std::string limits =
        fmt::format("allowed: {} to {} {}", field.low_limit, field.high_limit, field.unit);
    if (!std::isfinite(number))
      throw UserError(place(node.source()), fmt::format("{}.{} must be finite", field.table, field.key),
                      limits);
    if (number < 0)
      throw UserError(place(node.source()),
                      fmt::format("{}.{} is negative: {}", field.table, field.key, number), limits);
    if (number < field.low_limit || number > field.high_limit) {
      throw UserError(place(node.source()),
                      fmt::format("{}.{} = {} is out of limits", field.table, field.key, number), limits);
    }
    if (field.whole && number != std::floor(number)) {
      throw UserError(place(node.source()),
                      fmt::format("{}.{} must be whole, found {}", field.table, field.key, number), limits);
    }
    return number;
  }

  Confidence read_confidence(const toml::table& entry) const {
    const std::string word = read_text(entry, "confidence");
    for (Confidence confidence : {Confidence::Doc, Confidence::Inferred, Confidence::Guess}) {
      if (confidence_word(confidence) == word) return confidence;
    }
    throw UserError(place(entry.get("confidence")->source()), fmt::format("unknown confidence '{}'", word),
                    "one of: doc, inferred, guess");
  }

  void read_figure(const toml::table& table, const FigureField& field) {
    const toml::node& node = need(table, field.key, shape_hint(field));
    if (!node.is_table()) {
      throw UserError(place(node.source()),
                      fmt::format("{}.{} must carry its source and confidence, found {} alone", field.table,
                                  field.key, host::toml_kind(node)),
                      shape_hint(field));
    }
    const toml::table& entry = *node.as_table();
    const std::string where = fmt::format("{}.{}", field.table, field.key);
    static const std::string kKeys[] = {"value", "source", "confidence", "low", "high"};
    host::refuse_unknown_keys(entry, kKeys, where, path_);

    Figure& figure = field.of(model_);
    figure.value = figure.low = figure.high = read_number(entry, "value", field);
    figure.source = read_text(entry, "source");
    figure.confidence = read_confidence(entry);
    figure.present = true;
    if (!entry.contains("low") && !entry.contains("high")) return;
    if (figure.confidence == Confidence::Doc) {
      const toml::node& bound = *entry.get(entry.contains("low") ? "low" : "high");
      throw UserError(place(bound.source()), fmt::format("{} is documented but has a range", where),
                      "a figure with a range is 'inferred' or 'guess'");
    }
    figure.low = read_number(entry, "low", field);
    figure.high = read_number(entry, "high", field);
    if (figure.low > figure.value || figure.value > figure.high) {
      throw UserError(place(entry.get("low")->source()),
                      fmt::format("{} needs low <= value <= high, found {} <= {} <= {}", where, figure.low,
                                  figure.value, figure.high));
    }
  }

  std::string path_;
  toml::table root_;
  GpuModel model_;
};

}  // namespace

GpuModel parse_platform(std::string_view toml_text, const std::string& path) {
  return PlatformReader(toml_text, path).read();
}

GpuModel load_platform(const std::string& name_or_path) {
  std::vector<std::string> names;
  for (const PlatformEntry& entry : builtin_platforms()) {
    if (entry.id == name_or_path)
      return parse_platform(entry.text, std::string(entry.id) + ".toml (built in)");
    names.emplace_back(entry.id);
  }
  const bool looks_like_path = name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".toml");
  if (!looks_like_path) {
    throw UserError(fmt::format("unknown platform '{}'", name_or_path),
                    host::did_you_mean(name_or_path, names));
  }
  std::ifstream file(name_or_path, std::ios::binary);
  std::stringstream text;
  if (file) text << file.rdbuf();
  if (!file || text.fail()) throw UserError(SourcePlace{name_or_path}, "cannot read the platform file");
  return parse_platform(text.str(), name_or_path);
}

std::string format_platform(const GpuModel& model) {
  host::TextTable table(
      {{"figure"}, {"value", host::Align::Right}, {"unit"}, {"range"}, {"confidence"}, {"source"}});
  GpuModel copy = model;  // the schema hands out mutable references
  for (const FigureField& field : figure_fields()) {
    const Figure& figure = field.of(copy);
    if (!figure.present) continue;
    table.add_row({fmt::format("{}.{}", field.table, field.key), fmt::format("{}", figure.value),
                   std::string(field.unit),
                   figure.has_range() ? fmt::format("{} .. {}", figure.low, figure.high) : "-",
                   std::string(confidence_word(figure.confidence)), figure.source});
  }
  std::string head = fmt::format("{}: {} ({}), {} ALUs\n", model.id, model.name, model.year,
                                 alu_model_word(model.alu_model));
  std::string line;
  std::istringstream words(model.notes);
  for (std::string word; words >> word;) {
    if (!line.empty() && line.size() + 1 + word.size() > 98) {
      head += line + "\n";
      line.clear();
    }
    if (!line.empty()) line += ' ';
    line += word;
  }
  return head + line + "\n\n" + table.text();
}

}  // namespace aluminate::console
