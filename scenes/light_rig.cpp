#include "scenes/light_rig.hpp"

#include "platform/host/error.hpp"
#include "scenes/trigonometry.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace aluminate::scenes {
namespace {

constexpr const char* kLightForms = "use auto, scene, none, rig:N or lamps:N with N from 1 to 256";

/// Nearest distance a lamp is seen from, squared: 2^-8 of a scene whose radius is 1 to 2. Keeps 1/d^2 <=
/// 2^16, inside the shader's +-2^20, and is within 1/256 of the true 1/d^2 from d = 1/16 outwards (2^-16 /
/// d^2 <= 2^-8).
constexpr double kLampRadius2 = 0x1p-16;

/// Light that reaches the scene's centre above this many times white makes a warning: everything clips.
constexpr double kBlindingWhite = 100;

double frac(double x) { return x - std::floor(x); }

ShadingLight rig_light(int i, int count, const NormalisedSpace& space, bool inside) {
  // design: S = 3/sqrt(N), t_i = frac(0.61803399 i), golden-angle spiral of directions.
  const double s = 3 / std::sqrt(static_cast<double>(count));
  ShadingLight light;
  light.name = fmt::format("rig {}", i);
  if (i == 0) {
    const glm::dvec3 to_light{0.5, 1.0, 0.3};
    light.position = glm::dvec4(to_light / std::sqrt(glm::dot(to_light, to_light)), 0);
    light.color = glm::dvec3(1, 0.95, 0.85) * s;
    return light;
  }
  const double t = frac(0.61803399 * i), y = 0.2 + 0.6 * t, q = std::sqrt(1 - y * y);
  const SinCos phi = sin_cos(2.39996323 * i);
  const glm::dvec3 d{phi.cos * q, y, phi.sin * q};
  const double r = space.radius;
  const glm::dvec3 position = inside ? 0.8 * space.half_extent * glm::dvec3(d.x, 2 * y - 1, d.z)
                                     : 1.2 * r * d;  // the centre is the origin
  light.position = glm::dvec4(position, 1);
  for (int k = 0; k < 3; ++k) light.color[k] = (0.6 + 0.4 * sin_cos(2 * kPi * (t + k / 3.0)).cos) * 3 * s;
  light.k1 = 4 / (r * r);
  return light;
}

/// Points that end: reach a quarter of the scene's radius, on the rig's spiral inside the scene's box.
ShadingLight lamp(int i, const NormalisedSpace& space) {
  const double t = frac(0.61803399 * (i + 1)), y = 0.2 + 0.6 * t, q = std::sqrt(1 - y * y);
  const SinCos phi = sin_cos(2.39996323 * (i + 1));
  ShadingLight light;
  light.name = fmt::format("lamp {}", i);
  light.position = glm::dvec4(0.8 * space.half_extent * glm::dvec3(phi.cos * q, 2 * y - 1, phi.sin * q), 1);
  for (int k = 0; k < 3; ++k) light.color[k] = (0.6 + 0.4 * sin_cos(2 * kPi * (t + k / 3.0)).cos) * 3;
  const double range = 0.25 * space.radius;
  light.inv_range2 = 1 / (range * range);
  light.k1 = 4 / (range * range);
  return light;
}

glm::dvec3 unit_or(const glm::dvec3& v, const glm::dvec3& fallback) {
  const double longest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  if (!(longest > 0) || !std::isfinite(longest)) return fallback;
  const glm::dvec3 u = v / longest;
  return u / std::sqrt(glm::dot(u, u));
}

ShadingLight scene_light(const Light& source, std::size_t index, const NormalisedSpace& space) {
  ShadingLight light;
  light.name = source.name.empty() ? fmt::format("light {}", index) : source.name;
  light.color = source.color * (source.intensity / kPi);
  const glm::dvec3 to_light = unit_or(-source.direction, glm::dvec3(0, 0, 1));
  if (source.kind == LightKind::Directional) {
    light.position = glm::dvec4(to_light, 0);
    return light;
  }
  light.position = glm::dvec4(space.point(source.position), 1);
  // I / d^2 with d in world units = I * scale^2 / d'^2 with d' = d * scale.
  light.color *= space.scale * space.scale;
  light.k0 = kLampRadius2;
  light.k1 = 1;
  if (source.range > 0) {
    const double range = source.range * space.scale;
    light.inv_range2 = 1 / (range * range);
  }
  if (source.kind == LightKind::Spot) {
    const double cos_outer = sin_cos(source.outer_cone).cos;
    light.spot_axis = to_light;
    light.spot_scale = 1 / std::max(0.001, sin_cos(source.inner_cone).cos - cos_outer);  // [KHRLights]
    light.spot_offset = -cos_outer * light.spot_scale;
  }
  return light;
}

/// Strongest channel this light sends to the scene's centre if nothing narrows it.
double strength_at_centre(const ShadingLight& light) {
  const glm::dvec3 p(light.position);
  const double d2 = glm::dot(p, p);
  return std::max({light.color.r, light.color.g, light.color.b}) / (light.k0 + d2 * light.k1);
}

}  // namespace

LightChoice parse_lights(std::string_view text) {
  using Kind = LightChoice::Kind;
  LightChoice choice;
  if (text == "auto") return choice;
  if (text == "scene") return choice.kind = Kind::Scene, choice;
  if (text == "none") return choice.kind = Kind::None, choice;
  if (text.starts_with("rig:") || text.starts_with("lamps:")) {
    choice.kind = text.starts_with("rig:") ? Kind::Rig : Kind::Lamps;
    const std::string_view number = text.substr(text.find(':') + 1);
    const auto [end, status] = std::from_chars(number.data(), number.data() + number.size(), choice.count);
    if (status != std::errc{} || end != number.data() + number.size() || choice.count < 1 ||
        choice.count > kMaxRigLights)
      throw UserError(
          fmt::format("lights '{}': expected a count from 1 to {}, found '{}'", text, kMaxRigLights, number),
          kLightForms);
    return choice;
  }
  throw UserError(fmt::format("lights '{}': not a known light set", text), kLightForms);
}

LightSet make_lights(const Scene& scene, const NormalisedSpace& space, const View& view,
                     const LightChoice& choice) {
  using Kind = LightChoice::Kind;
  LightSet set;
  Kind kind = choice.kind;
  int count = choice.count;
  if (kind == Kind::Auto) {
    kind = scene.lights.empty() ? Kind::Rig : Kind::Scene;
    count = 4;
  }
  if (kind == Kind::None) {
    set.description = "none";
  } else if (kind == Kind::Lamps) {
    for (int i = 0; i < count; ++i) set.lights.push_back(lamp(i, space));
    set.description = fmt::format("lamps:{}", count);
  } else if (kind == Kind::Rig) {
    ALU_CHECK(count >= 1 && count <= kMaxRigLights, "{} lights", count);
    for (int i = 0; i < count; ++i) set.lights.push_back(rig_light(i, count, space, view.inside));
    set.description = fmt::format("rig:{}", count);
  } else {
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
      set.lights.push_back(scene_light(scene.lights[i], i, space));
      const double strength = strength_at_centre(set.lights.back());
      if (strength > kBlindingWhite)
        set.warnings.push_back(
            fmt::format("light '{}' brings {:.3g} times white to the scene's centre, so most of the picture "
                        "will clip: no exposure is "
                        "applied to a file's photometric units",
                        set.lights.back().name, strength));
    }
    set.description =
        fmt::format("scene ({} light{})", scene.lights.size(), scene.lights.size() == 1 ? "" : "s");
    if (scene.lights.empty())
      set.warnings.push_back(fmt::format("{} has no lights: only the ambient light remains", scene.file));
  }
  return set;
}

}  // namespace aluminate::scenes
