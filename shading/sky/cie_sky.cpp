#include "shading/sky/cie_sky.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>

namespace aluminate::sky {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180.0;
constexpr const char* kSkyHint = "--sky takes a CIE type 1..15, fc3, or five numbers a,b,c,d,e";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::optional<double> number(std::string_view text) {
  text = trimmed(text);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

CieParameters parse_parameters(std::string_view text) {
  std::array<double, 5> values{};
  std::string_view rest = text;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto comma = rest.find(',');
    const bool last = i + 1 == values.size();
    if (last != (comma == std::string_view::npos)) {
      std::size_t count = 1;
      for (const char character : text) count += character == ',' ? 1 : 0;
      throw UserError(fmt::format("sky '{}' has {} number{}, expected 5", text, count, count == 1 ? "" : "s"),
                      kSkyHint);
    }
    const std::string_view item = rest.substr(0, comma);
    const auto value = number(item);
    if (!value)
      throw UserError(
          fmt::format("sky '{}': parameter {} is '{}', expected a number", text, "abcde"[i], item), kSkyHint);
    values[i] = *value;
    if (!last) rest.remove_prefix(comma + 1);
  }
  return {values[0], values[1], values[2], values[3], values[4]};
}

}  // namespace

const CieParameters& cie_type(int type) {
  ALU_CHECK(type >= 1 && type <= 15, "CIE sky type {}", type);
  return kNamedSkies[static_cast<std::size_t>(type - 1)].parameters;
}

CieParameters parse_sky(std::string_view text) {
  for (const NamedSky& row : kNamedSkies)
    if (row.name == text) return row.parameters;
  if (text.find(',') != std::string_view::npos) {
    const CieParameters sky = parse_parameters(text);
    validate(sky);
    return sky;
  }
  if (number(text)) throw UserError(fmt::format("there is no CIE sky type {}", trimmed(text)), kSkyHint);
  throw UserError(fmt::format("unknown sky '{}'", text), kSkyHint);
}

void validate(const CieParameters& sky) {
  if (sky.a != 0.0 && !(sky.b < 0.0))
    throw UserError(fmt::format("sky parameter b is {}, expected a negative number", sky.b),
                    "b > 0 makes the horizon infinitely bright; every standard sky has b < 0");
  const double zenith = gradation(sky, 1.0);
  if (!(zenith > 0.0) || !std::isfinite(zenith))
    throw UserError(
        fmt::format(
            "sky parameters a = {}, b = {} give a zenith gradation of {:.6g}, expected a positive number",
            sky.a, sky.b, zenith),
        "1 + a exp(b) must be positive");
  constexpr int kSteps = 1800;  // a tenth of a degree
  for (int i = 0; i <= kSteps; ++i) {
    const double chi = kPi * i / kSteps;
    const double f = indicatrix(sky, chi);
    if (!(f > 0.0) || !std::isfinite(f))
      throw UserError(
          fmt::format(
              "sky parameters c = {}, d = {}, e = {} give a luminance factor of {:.6g} at {:.4g} degrees "
              "from the sun, expected a positive number",
              sky.c, sky.d, sky.e, f, chi / kDegree),
          sky.c < 0.0 ? "the published slides print c with the wrong sign: try c > 0"
                      : "reduce c or make d negative");
  }
}

double gradation(const CieParameters& sky, double cos_zenith) noexcept {
  return cos_zenith > 0.0 ? 1.0 + sky.a * std::exp(sky.b / cos_zenith) : 1.0;
}

double indicatrix(const CieParameters& sky, double chi) noexcept {
  const double cosine = std::cos(chi);
  return 1.0 + sky.c * (std::exp(sky.d * chi) - std::exp(sky.d * kPi / 2.0)) + sky.e * cosine * cosine;
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) noexcept {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

glm::dvec3 direction(double zenith, double azimuth) noexcept {
  return {std::sin(zenith) * std::cos(azimuth), std::sin(zenith) * std::sin(azimuth), std::cos(zenith)};
}

std::string_view to_string(Relative relative) noexcept {
  return relative == Relative::Sun ? "sun" : "zenith";
}

Relative parse_relative(std::string_view text) {
  for (const Relative relative : {Relative::Zenith, Relative::Sun})
    if (to_string(relative) == text) return relative;
  throw UserError(fmt::format("cannot make luminance relative to '{}'", text),
                  "--relative takes zenith or sun");
}

double normalisation(const CieParameters& sky, Relative relative, const glm::dvec3& to_sun) noexcept {
  if (relative == Relative::Sun) return 1.0 / (indicatrix(sky, 0.0) * gradation(sky, to_sun.z));
  return 1.0 / (indicatrix(sky, angle_between(to_sun, {0, 0, 1})) * gradation(sky, 1.0));
}

double relative_luminance(const CieParameters& sky, Relative relative, const glm::dvec3& to_sun,
                          const glm::dvec3& view) noexcept {
  return indicatrix(sky, angle_between(to_sun, view)) * gradation(sky, view.z) *
         normalisation(sky, relative, to_sun);
}

SkyTableOutput sky_table_row(const CieParameters& sky, const SkyTableInput& in, const SourcePlace& place) {
  const auto check = [&](const char* name, double value, bool bounded) {
    if (!std::isfinite(value) || (bounded && (value < 0.0 || value > 180.0)))
      throw UserError(
          place,
          fmt::format("{} is {}, expected {}", name, value, bounded ? "0 to 180 degrees" : "a finite angle"),
          "zenith angles count from straight up: 0 is the zenith, 90 the horizon");
  };
  check("sun_zenith_deg", in.sun_zenith_deg, true);
  check("view_zenith_deg", in.view_zenith_deg, true);
  check("azimuth_from_sun_deg", in.azimuth_from_sun_deg, false);
  const glm::dvec3 to_sun = direction(in.sun_zenith_deg * kDegree, 0.0);
  const glm::dvec3 view = direction(in.view_zenith_deg * kDegree, in.azimuth_from_sun_deg * kDegree);
  return {relative_luminance(sky, Relative::Zenith, to_sun, view),
          relative_luminance(sky, Relative::Sun, to_sun, view)};
}

}  // namespace aluminate::sky
