#include "scenes/gltf/schema.hpp"

#include "platform/host/error.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

namespace aluminate::scenes::gltf {
namespace {

using nlohmann::json;

enum class Is {
  Object,  // a JSON object
  Array,   // an array; the elements have their own rules
  Text,    // a string
  Flag,    // true or false
  Number,
  Numbers,  // array of `number` numbers
  Texts,    // array of strings
  Int31,    // integer in [low, 2^31)
  Int53,    // integer in [low, 2^53)
  Choice,   // integer named in `detail`, "5120 5121 ..."
  Word,     // string named in `detail`
  Index,    // index into the top-level array at JSON pointer `detail`
  Indices,  // array of such
};

struct Rule {
  std::string_view
      where;  // JSON pointer of the owning objects; '*' = every element of an array or member of an object
  std::string_view key;  // '*' = every member
  Is is;
  std::string_view detail = "";
  bool required = false;
  int number = 0;  // Numbers: size; Int: lowest value
};

constexpr bool kRequired = true;
constexpr std::string_view kComponentTypes = "5120 5121 5122 5123 5125 5126";
constexpr std::string_view kLights = "/extensions/KHR_lights_punctual/lights";

// Every property that is read, in the order a file is read.
constexpr Rule kRules[] = {
    {"", "asset", Is::Object, "", kRequired},
    {"/asset", "version", Is::Text, "", kRequired},
    {"", "extensionsUsed", Is::Texts},
    {"", "extensionsRequired", Is::Texts},
    {"", "extensions", Is::Object},

    {"", "buffers", Is::Array},
    {"/buffers", "*", Is::Object},
    {"/buffers/*", "byteLength", Is::Int53, "", kRequired, 1},
    {"/buffers/*", "uri", Is::Text},
    {"", "bufferViews", Is::Array},
    {"/bufferViews", "*", Is::Object},
    {"/bufferViews/*", "buffer", Is::Index, "/buffers", kRequired},
    {"/bufferViews/*", "byteOffset", Is::Int53},
    {"/bufferViews/*", "byteLength", Is::Int53, "", kRequired, 1},
    {"/bufferViews/*", "byteStride", Is::Int31, "", false, 4},
    {"", "accessors", Is::Array},
    {"/accessors", "*", Is::Object},
    {"/accessors/*", "bufferView", Is::Index, "/bufferViews"},
    {"/accessors/*", "byteOffset", Is::Int53},
    {"/accessors/*", "componentType", Is::Choice, kComponentTypes, kRequired},
    {"/accessors/*", "count", Is::Int53, "", kRequired, 1},
    {"/accessors/*", "type", Is::Word, "SCALAR VEC2 VEC3 VEC4 MAT2 MAT3 MAT4", kRequired},
    {"/accessors/*", "normalized", Is::Flag},
    {"/accessors/*", "sparse", Is::Object},
    {"/accessors/*/sparse", "count", Is::Int31, "", kRequired, 1},
    {"/accessors/*/sparse", "indices", Is::Object, "", kRequired},
    {"/accessors/*/sparse", "values", Is::Object, "", kRequired},
    {"/accessors/*/sparse/indices", "bufferView", Is::Index, "/bufferViews", kRequired},
    {"/accessors/*/sparse/indices", "byteOffset", Is::Int31},
    {"/accessors/*/sparse/indices", "componentType", Is::Choice, "5121 5123 5125", kRequired},
    {"/accessors/*/sparse/values", "bufferView", Is::Index, "/bufferViews", kRequired},
    {"/accessors/*/sparse/values", "byteOffset", Is::Int31},

    {"", "images", Is::Array},
    {"/images", "*", Is::Object},
    {"/images/*", "uri", Is::Text},
    {"/images/*", "bufferView", Is::Index, "/bufferViews"},
    {"/images/*", "mimeType", Is::Text},
    {"", "samplers", Is::Array},
    {"/samplers", "*", Is::Object},
    {"/samplers/*", "magFilter", Is::Choice, "9728 9729"},
    {"/samplers/*", "minFilter", Is::Choice, "9728 9729 9984 9985 9986 9987"},
    {"/samplers/*", "wrapS", Is::Choice, "33071 33648 10497"},
    {"/samplers/*", "wrapT", Is::Choice, "33071 33648 10497"},
    {"", "textures", Is::Array},
    {"/textures", "*", Is::Object},
    {"/textures/*", "sampler", Is::Index, "/samplers"},
    {"/textures/*", "source", Is::Index, "/images"},
    {"/textures/*", "extensions", Is::Object},

    {"", "materials", Is::Array},
    {"/materials", "*", Is::Object},
    {"/materials/*", "pbrMetallicRoughness", Is::Object},
    {"/materials/*/pbrMetallicRoughness", "baseColorFactor", Is::Numbers, "", false, 4},
    {"/materials/*/pbrMetallicRoughness", "metallicFactor", Is::Number},
    {"/materials/*/pbrMetallicRoughness", "roughnessFactor", Is::Number},
    {"/materials/*", "normalTexture", Is::Object},
    {"/materials/*/normalTexture", "scale", Is::Number},
    {"/materials/*", "occlusionTexture", Is::Object},
    {"/materials/*/occlusionTexture", "strength", Is::Number},
    {"/materials/*", "emissiveTexture", Is::Object},
    {"/materials/*", "emissiveFactor", Is::Numbers, "", false, 3},
    {"/materials/*", "alphaMode", Is::Word, "OPAQUE MASK BLEND"},
    {"/materials/*", "alphaCutoff", Is::Number},
    {"/materials/*", "doubleSided", Is::Flag},
    {"/materials/*", "extensions", Is::Object},
    {"/materials/*/extensions", "*", Is::Object},
    {"/materials/*/extensions/KHR_materials_emissive_strength", "emissiveStrength", Is::Number},
    {"/materials/*/extensions/KHR_materials_pbrSpecularGlossiness", "diffuseFactor", Is::Numbers, "", false,
     4},
    {"/materials/*/extensions/KHR_materials_pbrSpecularGlossiness", "specularFactor", Is::Numbers, "", false,
     3},
    {"/materials/*/extensions/KHR_materials_pbrSpecularGlossiness", "glossinessFactor", Is::Number},

    {"", "meshes", Is::Array},
    {"/meshes", "*", Is::Object},
    {"/meshes/*", "primitives", Is::Array, "", kRequired},
    {"/meshes/*/primitives", "*", Is::Object},
    {"/meshes/*/primitives/*", "attributes", Is::Object, "", kRequired},
    {"/meshes/*/primitives/*/attributes", "*", Is::Index, "/accessors"},
    {"/meshes/*/primitives/*", "indices", Is::Index, "/accessors"},
    {"/meshes/*/primitives/*", "material", Is::Index, "/materials"},
    {"/meshes/*/primitives/*", "mode", Is::Choice, "0 1 2 3 4 5 6"},

    {"", "cameras", Is::Array},
    {"/cameras", "*", Is::Object},
    {"/cameras/*", "type", Is::Word, "perspective orthographic", kRequired},
    {"/cameras/*", "perspective", Is::Object},
    {"/cameras/*/perspective", "yfov", Is::Number, "", kRequired},
    {"/cameras/*/perspective", "znear", Is::Number, "", kRequired},
    {"/cameras/*/perspective", "zfar", Is::Number},
    {"/cameras/*", "orthographic", Is::Object},
    {"/cameras/*/orthographic", "xmag", Is::Number, "", kRequired},
    {"/cameras/*/orthographic", "ymag", Is::Number, "", kRequired},
    {"/cameras/*/orthographic", "znear", Is::Number, "", kRequired},
    {"/cameras/*/orthographic", "zfar", Is::Number, "", kRequired},
    {"/extensions", "KHR_lights_punctual", Is::Object},
    {"/extensions/KHR_lights_punctual", "lights", Is::Array, "", kRequired},
    {kLights, "*", Is::Object},
    {"/extensions/KHR_lights_punctual/lights/*", "type", Is::Word, "directional point spot", kRequired},
    {"/extensions/KHR_lights_punctual/lights/*", "color", Is::Numbers, "", false, 3},
    {"/extensions/KHR_lights_punctual/lights/*", "intensity", Is::Number},
    {"/extensions/KHR_lights_punctual/lights/*", "range", Is::Number},
    {"/extensions/KHR_lights_punctual/lights/*", "spot", Is::Object},
    {"/extensions/KHR_lights_punctual/lights/*/spot", "innerConeAngle", Is::Number},
    {"/extensions/KHR_lights_punctual/lights/*/spot", "outerConeAngle", Is::Number},

    {"", "nodes", Is::Array},
    {"/nodes", "*", Is::Object},
    {"/nodes/*", "children", Is::Indices, "/nodes"},
    {"/nodes/*", "mesh", Is::Index, "/meshes"},
    {"/nodes/*", "camera", Is::Index, "/cameras"},
    {"/nodes/*", "matrix", Is::Numbers, "", false, 16},
    {"/nodes/*", "translation", Is::Numbers, "", false, 3},
    {"/nodes/*", "rotation", Is::Numbers, "", false, 4},
    {"/nodes/*", "scale", Is::Numbers, "", false, 3},
    {"/nodes/*", "extensions", Is::Object},
    {"/nodes/*/extensions", "KHR_lights_punctual", Is::Object},
    {"/nodes/*/extensions/KHR_lights_punctual", "light", Is::Index, kLights, kRequired},
    {"", "scenes", Is::Array},
    {"/scenes", "*", Is::Object},
    {"/scenes/*", "nodes", Is::Indices, "/nodes"},
    {"", "scene", Is::Index, "/scenes"},
};

// The places where a texture is used share one shape.
constexpr std::string_view kTextureUses[] = {
    "/materials/*/pbrMetallicRoughness/baseColorTexture",
    "/materials/*/pbrMetallicRoughness/metallicRoughnessTexture",
    "/materials/*/normalTexture",
    "/materials/*/occlusionTexture",
    "/materials/*/emissiveTexture",
    "/materials/*/extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture",
    "/materials/*/extensions/KHR_materials_pbrSpecularGlossiness/specularGlossinessTexture",
};
constexpr Rule kTextureRules[] = {
    {"", "index", Is::Index, "/textures", kRequired},
    {"", "texCoord", Is::Int31},
    {"", "extensions", Is::Object},
    {"/extensions", "KHR_texture_transform", Is::Object},
    {"/extensions/KHR_texture_transform", "offset", Is::Numbers, "", false, 2},
    {"/extensions/KHR_texture_transform", "scale", Is::Numbers, "", false, 2},
    {"/extensions/KHR_texture_transform", "rotation", Is::Number},
    {"/extensions/KHR_texture_transform", "texCoord", Is::Int31},
};

/// A value as it may stand in a message: short, printable ASCII whatever the file holds.
std::string shown(const json& value) {
  constexpr std::size_t kLongest = 40;
  if (value.is_array()) return value.empty() ? "an empty array" : fmt::format("an array of {}", value.size());
  if (value.is_object()) return "an object";
  if (value.is_string() && value.get_ref<const std::string&>().size() > kLongest) return "a long string";
  return value.dump(-1, ' ', true, json::error_handler_t::replace);
}

/// Object keys come from the file: no control characters and no endless lines in a message.
std::string printable(std::string path) {
  constexpr std::size_t kLongest = 200;
  if (path.size() > kLongest) path.resize(kLongest);
  for (char& c : path)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
  return path;
}

class Checker {
 public:
  Checker(const json& root, const std::string& file) : root_(root), file_(file) {}

  void run() {
    if (!root_.is_object()) fail("", "expected a JSON object at the top of the file");
    for (const Rule& rule : kRules) visit(root_, "", rule.where, rule);
    for (const std::string_view use : kTextureUses) {
      // A texture use is an object wherever it is present; its members follow the shared rules.
      const auto slash = use.rfind('/');
      visit(root_, "", use.substr(0, slash), Rule{"", use.substr(slash + 1), Is::Object});
      for (const Rule& rule : kTextureRules)
        visit(root_, "", std::string(use) + std::string(rule.where), rule);
    }
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& what) const {
    throw UserError(SourcePlace{file_}, path.empty() ? what : printable(path) + ": " + what);
  }

  /// Follows `where` from `node`, fanning out at '*', and applies the rule to each owner found. Missing parts
  /// are fine: whether an object must be there is its own rule.
  void visit(const json& node, const std::string& path, std::string_view where, const Rule& rule) const {
    if (where.empty()) return apply(node, path, rule);
    where.remove_prefix(1);
    const auto slash = std::min(where.find('/'), where.size());
    const std::string_view name = where.substr(0, slash), rest = where.substr(slash);
    if (name == "*") {
      for_each(node, path, [&](const json& child, const std::string& child_path) {
        visit(child, child_path, rest, rule);
      });
    } else if (node.is_object()) {
      if (const auto found = node.find(name); found != node.end())
        visit(*found, path + "/" + std::string(name), rest, rule);
    }
  }

  template <typename Action>
  static void for_each(const json& node, const std::string& path, const Action& action) {
    if (node.is_array()) {
      for (std::size_t i = 0; i < node.size(); ++i) action(node[i], path + "/" + std::to_string(i));
    } else if (node.is_object()) {
      for (auto it = node.begin(); it != node.end(); ++it) action(*it, path + "/" + it.key());
    }
  }

  void apply(const json& owner, const std::string& path, const Rule& rule) const {
    if (rule.key == "*")
      return for_each(owner, path, [&](const json& child, const std::string& child_path) {
        check(child, child_path, rule);
      });
    if (!owner.is_object()) return;
    const auto found = owner.find(rule.key);
    const std::string child_path = path + "/" + std::string(rule.key);
    if (found != owner.end()) return check(*found, child_path, rule);
    if (rule.required) fail(child_path, "is missing");
  }

  void check(const json& value, const std::string& path, const Rule& rule) const {
    switch (rule.is) {
      case Is::Object:
        return expect(value.is_object(), value, path, "an object");
      case Is::Array:
        return expect(value.is_array(), value, path, "an array");
      case Is::Text:
        return expect(value.is_string(), value, path, "a string");
      case Is::Flag:
        return expect(value.is_boolean(), value, path, "true or false");
      case Is::Number:
        return expect(value.is_number(), value, path, "a number");
      case Is::Numbers:
        return check_numbers(value, path, static_cast<std::size_t>(rule.number));
      case Is::Texts:
        return check_array(value, path, "strings", [&](const json& v, const std::string& p) {
          expect(v.is_string(), v, p, "a string");
        });
      case Is::Int31:
        return check_integer(value, path, rule.number, std::uint64_t{1} << 31);
      case Is::Int53:
        return check_integer(value, path, rule.number, std::uint64_t{1} << 53);
      case Is::Choice:
        if (!value.is_number_unsigned() || !names(rule.detail, value.dump()))
          unexpected(value, path, one_of(rule.detail));
        return;
      case Is::Word:
        if (!value.is_string() || !names(rule.detail, value.get<std::string>()))
          unexpected(value, path, one_of(rule.detail));
        return;
      case Is::Index:
        return check_index(value, path, rule.detail);
      case Is::Indices:
        return check_array(value, path, "indices",
                           [&](const json& v, const std::string& p) { check_index(v, p, rule.detail); });
    }
  }

  static std::string one_of(std::string_view words) { return fmt::format("one of {}", words); }

  [[noreturn]] void unexpected(const json& value, const std::string& path, std::string_view what) const {
    fail(path, fmt::format("expected {}, found {}", what, shown(value)));
  }

  void expect(bool holds, const json& value, const std::string& path, std::string_view what) const {
    if (!holds) unexpected(value, path, what);
  }

  template <typename Action>
  void check_array(const json& value, const std::string& path, std::string_view of,
                   const Action& action) const {
    if (!value.is_array()) unexpected(value, path, fmt::format("an array of {}", of));
    for_each(value, path, action);
  }

  void check_numbers(const json& value, const std::string& path, std::size_t size) const {
    if (!value.is_array() || value.size() != size)
      unexpected(value, path, fmt::format("an array of {} numbers", size));
    for_each(value, path,
             [&](const json& v, const std::string& p) { expect(v.is_number(), v, p, "a number"); });
  }

  void check_integer(const json& value, const std::string& path, int low, std::uint64_t end) const {
    if (value.is_number_unsigned() && value.get<std::uint64_t>() >= static_cast<std::uint64_t>(low) &&
        value.get<std::uint64_t>() < end)
      return;
    unexpected(value, path, fmt::format("an integer from {} to {}", low, end - 1));
  }

  void check_index(const json& value, const std::string& path, std::string_view array) const {
    const json::json_pointer pointer{std::string(array)};
    const std::size_t size =
        root_.contains(pointer) && root_.at(pointer).is_array() ? root_.at(pointer).size() : 0;
    if (value.is_number_unsigned() && value.get<std::uint64_t>() < size) return;
    if (size == 0) unexpected(value, path, fmt::format("an index into {}, which has no elements", array));
    unexpected(value, path, fmt::format("an index into {} (0 to {})", array, size - 1));
  }

  /// Whether `word` is one of the space-separated words of `list`.
  static bool names(std::string_view list, std::string_view word) {
    while (!list.empty()) {
      const auto space = std::min(list.find(' '), list.size());
      if (list.substr(0, space) == word) return true;
      list.remove_prefix(std::min(space + 1, list.size()));
    }
    return false;
  }

  const json& root_;
  const std::string& file_;
};

}  // namespace

void check_schema(const nlohmann::json& root, const std::string& file) { Checker(root, file).run(); }

}  // namespace aluminate::scenes::gltf
