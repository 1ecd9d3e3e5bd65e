#include "shading/report/sky_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "platform/host/error.hpp"
#include "platform/host/suggest.hpp"
#include "platform/host/text_table.hpp"
#include "shading/sky/sh9.hpp"

namespace aluminate::report {

std::string sky_table(const Csv& inputs, const std::string& path, const sky::CieParameters& parameters) {
  static const std::vector<std::string> kColumns = {"sun_zenith_deg", "view_zenith_deg",
                                                    "azimuth_from_sun_deg"};
  std::size_t at[3];
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const auto found = std::find(inputs.columns.begin(), inputs.columns.end(), kColumns[i]);
    if (found == inputs.columns.end())
      throw UserError(SourcePlace{path, 1, 0}, fmt::format("column '{}' is missing", kColumns[i]),
                      "sky table reads sun_zenith_deg,view_zenith_deg,azimuth_from_sun_deg");
    at[i] = static_cast<std::size_t>(found - inputs.columns.begin());
  }
  for (const std::string& column : inputs.columns)
    if (std::find(kColumns.begin(), kColumns.end(), column) == kColumns.end())
      throw UserError(SourcePlace{path, 1, 0}, fmt::format("unknown column '{}'", column),
                      host::did_you_mean(column, kColumns));
  std::string text = fmt::format("{},L_over_L_zenith,L_over_L_sun\n", fmt::join(inputs.columns, ","));
  for (std::size_t row = 0; row < inputs.rows.size(); ++row) {
    const std::vector<double>& values = inputs.rows[row];
    const sky::SkyTableOutput out =
        sky::sky_table_row(parameters, {values[at[0]], values[at[1]], values[at[2]]},
                           SourcePlace{path, static_cast<int>(row) + 2, 0});
    text += fmt::format("{},{:.17g},{:.17g}\n", fmt::join(inputs.text[row], ","), out.l_over_l_zenith,
                        out.l_over_l_sun);
  }
  return text;
}

sky::Sky make_sky(const SkyRequest& request) {
  if (!(request.sun_zenith_deg >= 0 && request.sun_zenith_deg <= 180))
    throw UserError(fmt::format("--sun-zenith: expected 0 to 180 degrees, got {}", request.sun_zenith_deg));
  sky::Sky sky;
  sky.cie = sky::parse_sky(request.sky);
  sky.relative = sky::parse_relative(request.relative);
  const double zenith = request.sun_zenith_deg * std::numbers::pi / 180.0;
  sky.to_sun = {std::sin(zenith), 0.0, std::cos(zenith)};
  sky.gradient = sky::zenith_horizon_gradient(request.zenith_color, request.horizon_color);
  return sky;
}

std::string sh9_json(const SkyRequest& request) {
  const sky::Sh9 light = sky::project(make_sky(request));
  nlohmann::ordered_json coefficients = nlohmann::ordered_json::array(),
                         order = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < light.size(); ++i) {
    coefficients.push_back({light[i].r, light[i].g, light[i].b});
    order.push_back(sky::kSh9Names[i]);
  }
  const nlohmann::ordered_json document = {
      {"schema", 1},
      {"tool", {{"name", "aluminate"}, {"version", ALUMINATE_VERSION}}},
      {"command", fmt::format("aluminate sky sh9 --sky {} --sun-zenith {} --relative {}", request.sky,
                              request.sun_zenith_deg, request.relative)},
      {"inputs",
       {{"sky", request.sky},
        {"sun_zenith_deg", request.sun_zenith_deg},
        {"relative", request.relative},
        {"zenith_color", {request.zenith_color.r, request.zenith_color.g, request.zenith_color.b}},
        {"horizon_color", {request.horizon_color.r, request.horizon_color.g, request.horizon_color.b}}}},
      {"basis", "real orthonormal, z up, sun at (sin Zs, 0, cos Zs), radiance"},
      {"order", order},
      {"coefficients", coefficients}};
  return document.dump(2) + "\n";
}

std::string sh9_text(const SkyRequest& request) {
  using host::Align;
  host::TextTable table({{"lm"}, {"r", Align::Right}, {"g", Align::Right}, {"b", Align::Right}});
  const sky::Sh9 light = sky::project(make_sky(request));
  for (std::size_t i = 0; i < light.size(); ++i)
    table.add_row({std::string(sky::kSh9Names[i]), fmt::format("{:.9f}", light[i].r),
                   fmt::format("{:.9f}", light[i].g), fmt::format("{:.9f}", light[i].b)});
  return table.text();
}

glm::dvec3 parse_color(const std::string& option, const std::string& text) {
  const Csv parsed = [&] {
    try {
      const auto commas = std::count(text.begin(), text.end(), ',');
      return parse_csv((commas == 2 ? "r,g,b\n" : "v\n") + text, option);
    } catch (const UserError&) {
      throw UserError(fmt::format("{}: expected R,G,B or one number, got '{}'", option, text),
                      "for example 0.3,0.5,1");
    }
  }();
  if (parsed.rows.size() != 1)
    throw UserError(fmt::format("{}: expected R,G,B or one number, got '{}'", option, text),
                    "for example 0.3,0.5,1");
  const std::vector<double>& v = parsed.rows.front();
  const glm::dvec3 color = v.size() == 3 ? glm::dvec3(v[0], v[1], v[2]) : glm::dvec3(v[0]);
  for (int c = 0; c < 3; ++c)
    if (!(color[c] >= 0 && std::isfinite(color[c])))
      throw UserError(fmt::format("{}: colours are finite and not negative, got '{}'", option, text));
  return color;
}

}  // namespace aluminate::report
