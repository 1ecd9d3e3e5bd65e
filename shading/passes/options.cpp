#include "shading/passes/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "platform/host/error.hpp"
#include "platform/host/suggest.hpp"
#include "platform/number/format.hpp"
#include "shading/sky/cie_sky.hpp"
#include "shading/sky/sun.hpp"

namespace aluminate::passes {
namespace {

template <typename Enum>
struct Choice {
  std::string_view name;
  Enum value;
};
constexpr Choice<Pipeline> kPipelines[] = {{"forward", Pipeline::Forward}, {"deferred", Pipeline::Deferred}};
constexpr Choice<Tonemap> kTonemaps[] = {
    {"none", Tonemap::None}, {"reinhard", Tonemap::Reinhard}, {"filmic", Tonemap::Filmic}};
constexpr Choice<LightLoop> kLightLoops[] = {
    {"auto", LightLoop::Auto}, {"rolled", LightLoop::Rolled}, {"unrolled", LightLoop::Unrolled}};
constexpr Choice<int> kSampleCounts[] = {{"1", 1}, {"4", 4}};
constexpr Choice<ToksvigMode> kToksvigModes[] = {{"off", ToksvigMode::Off},
                                                 {"texture", ToksvigMode::Texture},
                                                 {"dxt5", ToksvigMode::Dxt5},
                                                 {"material", ToksvigMode::Material}};
constexpr Choice<TextureStorage> kTextureStorages[] = {{"rgba8", TextureStorage::Rgba8},
                                                       {"dxt", TextureStorage::Dxt}};
constexpr Choice<int> kAnisotropies[] = {{"1", 1}, {"2", 2}, {"4", 4}, {"8", 8}, {"16", 16}};
constexpr Choice<bool> kOnOff[] = {{"on", true}, {"off", false}};
constexpr Choice<bool> kSwitches[] = {{"true", true}, {"false", false}};
constexpr Choice<VmTier> kVmTiers[] = {{"auto", VmTier::Auto}, {"interpreter", VmTier::Interpreter}, {"jit", VmTier::Jit}};

[[noreturn]] void refuse(std::string_view key, std::string_view value, std::string_view expected,
                         std::string hint = {}) {
  throw UserError(fmt::format("--{}: expected {}, got '{}'", key, expected, value), std::move(hint));
}

using host::did_you_mean;

template <typename Enum, std::size_t N>
Enum choose(std::string_view key, std::string_view value, const Choice<Enum> (&choices)[N]) {
  std::vector<std::string> names;
  for (const auto& choice : choices) {
    if (choice.name == value) return choice.value;
    names.emplace_back(choice.name);
  }
  refuse(key, value, fmt::format("{}", fmt::join(names, ", ")), did_you_mean(value, names));
}

template <typename Enum, std::size_t N>
std::string_view name_of(Enum value, const Choice<Enum> (&choices)[N]) {
  for (const auto& choice : choices)
    if (choice.value == value) return choice.name;
  return "?";
}

std::optional<double> parse_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const auto at = text.find(separator);
    parts.push_back(text.substr(0, at));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + 1);
  }
}

void set_size(FrameOptions& options, std::string_view value) {
  const auto parts = split(value, 'x');
  const auto width = parts.size() == 2 ? parse_number(parts[0]) : std::nullopt;
  const auto height = parts.size() == 2 ? parse_number(parts[1]) : std::nullopt;
  const auto whole = [](std::optional<double> v) {
    return v && *v == std::floor(*v) && *v >= 1 && *v <= 16384;
  };
  if (!whole(width) || !whole(height))
    refuse("size", value, "WIDTHxHEIGHT, each from 1 to 16384", "for example 1280x720");
  options.width = static_cast<int>(*width);
  options.height = static_cast<int>(*height);
}

void set_ambient(FrameOptions& options, std::string_view value) {
  for (const auto& [name, kind] : {std::pair{"none", AmbientKind::None}, std::pair{"sky", AmbientKind::Sky},
                                   std::pair{"hemisphere", AmbientKind::Hemisphere}})
    if (value == name) {
      options.ambient = kind;
      return;
    }
  const auto number = value.starts_with("flat:") ? parse_number(value.substr(5)) : std::nullopt;
  if (!number || *number < 0 || *number > 1000)
    refuse("ambient", value, "none, sky, hemisphere or flat:VALUE with VALUE from 0 to 1000",
           "for example flat:0.03");
  options.ambient = AmbientKind::Flat;
  options.ambient_value = *number;
}

void set_lights(FrameOptions& options, std::string_view value) {
  if (value.starts_with("rig:") || value.starts_with("lamps:")) {
    const auto count = parse_number(value.substr(value.find(':') + 1));
    if (!count || *count != std::floor(*count) || *count < 1 || *count > 64)
      refuse("lights", value, "rig:N or lamps:N with N from 1 to 64", "for example rig:4");
  } else if (value != "scene" && value != "none") {
    refuse("lights", value, "rig:N, lamps:N, scene or none",
           did_you_mean(value, std::vector<std::string>{"rig:4", "scene", "none"}));
  }
  options.lights = value;
}

void set_background(FrameOptions& options, std::string_view value) {
  const auto parts = split(value, ',');
  for (std::size_t i = 0; i < 3; ++i) {
    const auto channel = parts.size() == 3 ? parse_number(parts[i]) : std::nullopt;
    if (!channel || *channel < 0 || *channel > 1)
      refuse("background", value, "R,G,B, each from 0 to 1", "for example 0.05,0.06,0.08");
    options.background[static_cast<int>(i)] = *channel;
  }
}

glm::dvec3 parse_factors(std::string_view key, std::string_view value) {
  const auto parts = split(value, ',');
  glm::dvec3 factors(1.0);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto channel = parts.size() == 3 ? parse_number(parts[i]) : std::nullopt;
    if (!channel || *channel < 0 || *channel > 16)
      refuse(key, value, "R,G,B, each from 0 to 16", "for example 0.6,0.8,1");
    factors[static_cast<int>(i)] = *channel;
  }
  return factors;
}

void set_no_skip(FrameOptions& options, std::string_view value) {
  std::vector<std::string> names(std::begin(kSkipNames), std::end(kSkipNames));
  if (value == "all") {
    options.no_skip.insert(names.begin(), names.end());
    return;
  }
  if (std::find(names.begin(), names.end(), value) == names.end()) {
    names.emplace_back("all");
    refuse("no-skip", value, fmt::format("{}", fmt::join(names, ", ")), did_you_mean(value, names));
  }
  options.no_skip.emplace(value);
}

void set_define(FrameOptions& options, std::string_view value) {
  const auto equals = value.find('=');
  const std::string_view name = value.substr(0, equals);
  const bool identifier = !name.empty() && !std::isdigit(static_cast<unsigned char>(name[0])) &&
                          std::all_of(name.begin(), name.end(), [](char c) {
                            return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
                          });
  if (!identifier) refuse("D", value, "NAME or NAME=VALUE", "for example -D LIGHT_COUNT=2");
  options.defines.emplace_back(name, equals == std::string_view::npos ? "1" : value.substr(equals + 1));
}

}  // namespace

const std::vector<OptionInfo>& option_table() {
  static const std::vector<OptionInfo> table = {
      {"size", "WxH", "picture size in pixels (1280x720)"},
      {"msaa", "1|4", "samples a pixel, resolved in linear light (1)"},
      {"camera", "auto|outside|inside|gltf[:N]|ex,ey,ez:tx,ty,tz:fovy", "point of view (auto)"},
      {"lights", "rig:N|lamps:N|scene|none", "light set (scene if the file has lights, else rig:4)"},
      {"ambient", "flat:V|sky|hemisphere|none",
       "ambient light on cdiff + cspec; sky: SH9 of --sky (flat:0.03)"},
      {"sky", "none|1..15|fc3|a,b,c,d,e", "CIE sky behind the scene, with its sun as a light (none)"},
      {"time", "HH:MM", "time of day of --sky: sun and colours (15:00)"},
      {"sun", "ELEVATION,AZIMUTH", "sun of --sky in degrees, azimuth from +x towards -z; instead of --time"},
      {"polarizer", "R,G,B", "factor on what is seen of the sky, never on its light (1,1,1)"},
      {"background", "R,G,B", "stored display values (0.05,0.06,0.08)"},
      {"pipeline", "forward|deferred",
       "where light meets surface: in each draw, or over a G-buffer (forward)"},
      {"visibility", "none|schlick-smith|integrated|cheap", "specular visibility term (schlick-smith)"},
      {"fresnel", "schlick|sg|sg-lagarde", "Fresnel term (schlick)"},
      {"toksvig", "off|texture|dxt5|material",
       "gloss filtered by the normal map, and where it is kept (off)"},
      {"textures", "rgba8|dxt", "maps as the file has them, or through DXT1, DXT5 and DXT5nm (rgba8)"},
      {"anisotropy", "1|2|4|8|16", "most samples a fetch takes along the longer axis of a pixel (1)"},
      {"shadows", "on|off", "shadow maps of directional and spot lights (off)"},
      {"reflections", "FILE|off",
       "cube map of `aluminate cubemap` as specular ambient light; its sky follows --time (off)"},
      {"tonemap", "none|reinhard|filmic", "tone map before display (none: clamp)"},
      {"number", "fx31|fx24|...|q16.16|ref64", "number format of the shader VM (fx31)"},
      {"platform", "xenos|rsx|...|FILE.toml", "console whose bill is written (xenos)"},
      {"shader", "FILE", "pixel shader to use instead of the shipped one (.hlsl, .glsl, .spv)"},
      {"light-loop", "auto|rolled|unrolled", "form of the light loop (auto: unrolled up to 8 lights)"},
      {"vm", "auto|interpreter|jit", "execution tier; never changes a result (auto: compiles when it pays)"},
      {"no-skip", "all|NAME", "do the work that would be skipped; never changes a result"},
      {"checked", "true|false", "report each instruction that saturated, with its source line (false)"},
      {"D", "NAME[=VALUE]", "macro for the pixel shader"},
  };
  return table;
}

void set_option(FrameOptions& options, std::string_view key, std::string_view value) {
  if (key == "size") return set_size(options, value);
  if (key == "msaa") {
    options.msaa = choose(key, value, kSampleCounts);
  } else if (key == "camera") {
    options.camera = value;
  } else if (key == "lights") {
    set_lights(options, value);
  } else if (key == "ambient") {
    set_ambient(options, value);
  } else if (key == "background") {
    set_background(options, value);
  } else if (key == "sky") {
    if (value != "none") static_cast<void>(sky::parse_sky(value));  // throws what is wrong with it
    options.sky = value;
  } else if (key == "time") {
    static_cast<void>(sky::parse_time(value));
    options.time = value;
    options.sun.clear();
  } else if (key == "sun") {
    static_cast<void>(sky::parse_sun(value));
    options.sun = value;
    options.time.clear();
  } else if (key == "polarizer") {
    options.polarizer = parse_factors(key, value);
  } else if (key == "pipeline") {
    options.pipeline = choose(key, value, kPipelines);
  } else if (key == "visibility") {
    const auto parsed = brdf::parse_visibility(value);
    if (!parsed)
      refuse(key, value, "none, schlick-smith, integrated or cheap",
             did_you_mean(value, std::vector<std::string>{"none", "schlick-smith", "integrated", "cheap"}));
    options.visibility = *parsed;
  } else if (key == "fresnel") {
    const auto parsed = brdf::parse_fresnel(value);
    if (!parsed)
      refuse(key, value, "schlick, sg or sg-lagarde",
             did_you_mean(value, std::vector<std::string>{"schlick", "sg", "sg-lagarde"}));
    options.fresnel = *parsed;
  } else if (key == "toksvig") {
    options.toksvig = choose(key, value, kToksvigModes);
  } else if (key == "textures") {
    options.textures = choose(key, value, kTextureStorages);
  } else if (key == "anisotropy") {
    options.anisotropy = choose(key, value, kAnisotropies);
  } else if (key == "shadows") {
    options.shadows = choose(key, value, kOnOff);
  } else if (key == "reflections") {
    options.reflections = value == "off" ? "" : value;
  } else if (key == "tonemap") {
    options.tonemap = choose(key, value, kTonemaps);
  } else if (key == "number") {
    if (!number::parse_number_format(value))
      refuse(key, value, "a number format: fx31, auto, fx24, q16.16, q12.20, q8.24, ref64, ...");
    options.number = value;
  } else if (key == "platform") {
    options.platform = value;
  } else if (key == "shader") {
    options.shader = value;
  } else if (key == "light-loop") {
    options.light_loop = choose(key, value, kLightLoops);
  } else if (key == "vm") {
    options.vm = choose(key, value, kVmTiers);
  } else if (key == "no-skip") {
    set_no_skip(options, value);
  } else if (key == "checked") {
    options.checked = choose(key, value, kSwitches);
  } else if (key == "D") {
    set_define(options, value);
  } else {
    std::vector<std::string> names;
    for (const OptionInfo& option : option_table()) names.emplace_back(option.name);
    throw UserError(fmt::format("unknown option '{}'", key), did_you_mean(key, names));
  }
}

void set_options(FrameOptions& options, std::string_view assignments) {
  // A value may itself hold commas (camera, background): a piece without '=' belongs to the value before it.
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string_view piece : split(assignments, ',')) {
    const auto equals = piece.find('=');
    if (equals != std::string_view::npos) {
      pairs.emplace_back(piece.substr(0, equals), piece.substr(equals + 1));
    } else if (!pairs.empty()) {
      pairs.back().second.append(",").append(piece);
    } else if (!piece.empty()) {
      throw UserError(fmt::format("expected key=value, got '{}'", piece),
                      "for example visibility=cheap,fresnel=sg");
    }
  }
  for (const auto& [key, value] : pairs) set_option(options, key, value);
}

std::string_view to_string(Pipeline value) { return name_of(value, kPipelines); }
std::string_view to_string(Tonemap value) { return name_of(value, kTonemaps); }
std::string_view to_string(ToksvigMode value) { return name_of(value, kToksvigModes); }
std::string_view to_string(TextureStorage value) { return name_of(value, kTextureStorages); }
std::string_view to_string(LightLoop value) { return name_of(value, kLightLoops); }

std::string ambient_text(const FrameOptions& options) {
  switch (options.ambient) {
    case AmbientKind::None:
      return "none";
    case AmbientKind::Sky:
      return "sky";
    case AmbientKind::Hemisphere:
      return "hemisphere";
    default:
      return fmt::format("flat:{}", options.ambient_value);
  }
}

}  // namespace aluminate::passes
