#include "shading/report/check_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "platform/host/input_file.hpp"
#include "platform/host/suggest.hpp"
#include "platform/host/toml_text.hpp"

namespace aluminate::report {
namespace {

constexpr const char* kHint = "docs/checks.md shows a complete file";

class CheckReader {
 public:
  CheckReader(std::string_view text, std::string path)
      : path_(std::move(path)), root_(host::parse_toml(text, path_, kHint)) {
    file_.path = path_;
    for (const passes::OptionInfo& option : passes::option_table())
      if (option.name != "D") options_.emplace_back(option.name);
    options_.emplace_back("define");
  }

  CheckFile read() {
    static const std::string kKeys[] = {"schema", "goldens", "output", "defaults", "variant", "check"};
    host::refuse_unknown_keys(root_, kKeys, "a check file", path_);
    const toml::node* schema = root_.get("schema");
    if (schema == nullptr)
      throw UserError(SourcePlace{path_, 1, 1}, "'schema' is missing", "begin the file with: schema = 1");
    if (!schema->is_integer() || **schema->as_integer() != 1) refuse(*schema, "'schema' must be 1");
    if (const toml::node* node = root_.get("goldens")) file_.goldens = folder(*node, "goldens");
    if (const toml::node* node = root_.get("output")) file_.output = folder(*node, "output");
    if (const toml::node* node = root_.get("defaults")) defaults_ = &options_table(*node, "[defaults]");
    if (const toml::node* node = root_.get("variant"))
      for (const auto& [name, options] : table_of(*node, "[variant]"))
        options_table(options, fmt::format("[variant.{}]", name.str()));
    const toml::node* checks = root_.get("check");
    if (checks == nullptr || !checks->is_array() || checks->as_array()->empty())
      throw UserError(SourcePlace{path_}, "there is no [[check]]", kHint);
    for (const toml::node& node : *checks->as_array()) read_check(table_of(node, "[[check]]"));
    return std::move(file_);
  }

 private:
  [[noreturn]] void refuse(const toml::node& node, const std::string& what,
                           const std::string& hint = kHint) const {
    throw UserError(host::toml_place(path_, node.source()), what, hint);
  }

  const toml::table& table_of(const toml::node& node, const std::string& where) const {
    if (!node.is_table())
      refuse(node, fmt::format("{} must be a table, found {}", where, host::toml_kind(node)));
    return *node.as_table();
  }

  const toml::table& options_table(const toml::node& node, const std::string& where) const {
    const toml::table& table = table_of(node, where);
    host::refuse_unknown_keys(table, options_, where, path_);
    passes::FrameOptions trial;
    apply(table, trial);  // a mistake in a variant that no check uses is still a mistake
    return table;
  }

  std::string text(const toml::node& node, std::string_view key) const {
    if (!node.is_string())
      refuse(node, fmt::format("'{}' must be a string, found {}", key, host::toml_kind(node)));
    const std::string& value = **node.as_string();
    if (value.empty()) refuse(node, fmt::format("'{}' must not be empty", key));
    return value;
  }

  std::string folder(const toml::node& node, std::string_view key) const {
    std::string value = text(node, key);
    while (value.size() > 1 && value.ends_with('/')) value.pop_back();
    return value;
  }

  // A string, or an array of them; is_list says which, because only lists lengthen a check's name.
  std::vector<std::string> texts(const toml::table& table, std::string_view key, bool& is_list) const {
    const toml::node& node = *table.get(key);
    is_list = node.is_array();
    if (!is_list) return {text(node, key)};
    std::vector<std::string> values;
    for (const toml::node& element : *node.as_array()) values.push_back(text(element, key));
    if (values.empty()) refuse(node, fmt::format("'{}' is an empty list", key));
    return values;
  }

  static std::string scalar_text(const toml::node& node) {
    if (const auto* value = node.as_string()) return **value;
    if (const auto* value = node.as_integer()) return fmt::format("{}", **value);
    if (const auto* value = node.as_floating_point()) return fmt::format("{}", **value);
    if (const auto* value = node.as_boolean()) return **value ? "true" : "false";
    return {};
  }

  // Applies the option keys of a table; other keys are somebody else's.
  void apply(const toml::table& table, passes::FrameOptions& options) const {
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      if (std::find(options_.begin(), options_.end(), name) == options_.end()) continue;
      if (name == "define") {
        for (const auto& [macro, value] : table_of(node, "define"))
          set(options, "D", fmt::format("{}={}", macro.str(), value_text(value, macro.str())), value);
      } else {
        set(options, name, value_text(node, name), node);
      }
    }
  }

  std::string value_text(const toml::node& node, std::string_view key) const {
    if (node.is_table() || node.is_array() || scalar_text(node).empty())
      refuse(node, fmt::format("'{}' must be a string, a number or a boolean, found {}", key,
                               host::toml_kind(node)));
    return scalar_text(node);
  }

  void set(passes::FrameOptions& options, const std::string& key, const std::string& value,
           const toml::node& node) const {
    try {
      passes::set_option(options, key, value);
    } catch (const UserError& error) {
      refuse(node, error.what(), error.hint());
    }
  }

  std::string check_name(const toml::table& table) const {
    const toml::node* node = table.get("name");
    if (node == nullptr)
      throw UserError(host::toml_place(path_, table.source()), "a check needs a name",
                      "name = \"wall/cheap\"");
    const std::string name = text(*node, "name");
    const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
      return std::isalnum(c) || c == '_' || c == '-' || c == '.' || c == '/';
    });
    if (!plain || name.starts_with('/') || name.ends_with('/') || name.starts_with('-') ||
        name.starts_with('.') || name.find("//") != std::string::npos || name.find("/.") != std::string::npos)
      refuse(*node, fmt::format("'{}' cannot name a check", name),
             "letters, digits, _ - . and / between folders: it names the golden's file");
    return name;
  }

  const toml::table* variant_of(const std::string& name, const toml::node& node) const {
    const toml::table* variants = root_.get("variant") ? root_.get("variant")->as_table() : nullptr;
    const toml::node* found = variants ? variants->get(name) : nullptr;
    if (found != nullptr) return found->as_table();
    std::vector<std::string> known;
    if (variants)
      for (const auto& [key, ignored] : *variants) known.emplace_back(key.str());
    refuse(node, fmt::format("there is no [variant.{}]", name), host::did_you_mean(name, known));
  }

  void read_compare(const toml::table& table, CheckSpec& spec) const {
    const toml::node* node = table.get("compare");
    if (node == nullptr) return;
    const std::string word = text(*node, "compare");
    static const std::string kWords[] = {"image", "cost", "image+cost"};
    if (std::find(std::begin(kWords), std::end(kWords), word) == std::end(kWords))
      refuse(*node, fmt::format("compare is image, cost or image+cost, found '{}'", word),
             host::did_you_mean(word, kWords));
    spec.image = word != "cost";
    spec.cost = word != "image";
    if (!spec.subject.empty() && spec.image)
      refuse(*node, "a shader without a scene has no image to compare", "leave 'compare' out");
  }

  void read_budget(const toml::table& table, CheckSpec& spec) const {
    const toml::node* node = table.get("budget_ms");
    if (node == nullptr) return;
    const double value = node->is_number() ? *node->value<double>() : -1;
    if (!(value > 0 && value < 1e6))
      refuse(*node, "'budget_ms' must be a number above 0 and below 1000000",
             "console milliseconds the frame may take");
    if (spec.scene.empty())
      refuse(*node, "'budget_ms' is for scenes: a shader by itself has no frame time", "remove it");
    spec.budget_ms = value;
  }

  void read_check(const toml::table& table) {
    std::vector<std::string> known = options_;
    for (const char* key : {"name", "scene", "cost", "variant", "compare", "budget_ms", "stage", "entry"})
      known.emplace_back(key);
    host::refuse_unknown_keys(table, known, "[[check]]", path_);
    CheckSpec base;
    base.place = host::toml_place(path_, table.source());
    base.name = check_name(table);
    const bool renders = table.contains("scene"), prices = table.contains("cost");
    if (renders == prices)
      throw UserError(
          base.place, fmt::format("check '{}' needs a scene or a shader", base.name),
          "scene = \"FILE.gltf\" renders; cost = \"FILE.hlsl\" prices a shader by itself; one of the two");
    for (const char* key : {"stage", "entry"}) {
      const toml::node* node = table.get(key);
      if (node == nullptr) continue;
      if (!prices) refuse(*node, fmt::format("'{}' belongs to checks with cost = \"SHADER\"", key));
      (key[0] == 's' ? base.stage : base.entry) = text(*node, key);
    }
    if (base.stage != "pixel" && base.stage != "vertex")
      refuse(*table.get("stage"), fmt::format("stage is pixel or vertex, found '{}'", base.stage));

    bool many_subjects = false, many_variants = false;
    const std::vector<std::string> subjects = texts(table, renders ? "scene" : "cost", many_subjects);
    std::vector<std::string> variants = {""};
    if (table.contains("variant")) variants = texts(table, "variant", many_variants);
    for (const std::string& subject : subjects)
      for (const std::string& variant : variants) {
        CheckSpec spec = base;
        (renders ? spec.scene : spec.subject) = subject;
        if (many_subjects) spec.name += "/" + std::filesystem::path(subject).stem().string();
        if (many_variants) spec.name += "/" + variant;
        if (defaults_ != nullptr) apply(*defaults_, spec.options);
        if (!variant.empty()) apply(*variant_of(variant, *table.get("variant")), spec.options);
        apply(table, spec.options);
        spec.image = renders;
        read_compare(table, spec);
        read_budget(table, spec);
        add(std::move(spec));
      }
  }

  void add(CheckSpec spec) {
    for (const CheckSpec& other : file_.checks)
      if (other.name == spec.name)
        throw UserError(spec.place, fmt::format("two checks are named '{}'", spec.name),
                        fmt::format("the first stands at {}", other.place.text()));
    file_.checks.push_back(std::move(spec));
  }

  std::string path_;
  toml::table root_;
  std::vector<std::string> options_;  // names that set_option takes, and "define"
  const toml::table* defaults_ = nullptr;
  CheckFile file_;
};

}  // namespace

CheckFile parse_check_file(std::string_view text, const std::string& path) {
  return CheckReader(text, path).read();
}

CheckFile load_check_file(const std::string& path) { return parse_check_file(host::read_text(path), path); }

}  // namespace aluminate::report
