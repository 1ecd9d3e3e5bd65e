#include "shading/sky/sun.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numbers>

namespace aluminate::sky {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

template <class Number>
bool read_whole(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

}  // namespace

glm::dvec3 to_sun(const SunPosition& position) noexcept {
  const double elevation = position.elevation_deg * kDegree, azimuth = position.azimuth_deg * kDegree;
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

SunPosition parse_sun(std::string_view text) {
  SunPosition position;
  const auto comma = text.find(',');
  const bool azimuth_ok =
      comma == std::string_view::npos ||
      (read_whole(text.substr(comma + 1), position.azimuth_deg) && std::isfinite(position.azimuth_deg));
  if (!read_whole(text.substr(0, comma), position.elevation_deg) || !azimuth_ok)
    throw UserError(fmt::format("sun position '{}', expected elevation,azimuth in degrees", text),
                    "for example --sun 35,120");
  if (!(position.elevation_deg >= -90.0 && position.elevation_deg <= 90.0))
    throw UserError(fmt::format("sun elevation of {} degrees, expected -90 to 90", position.elevation_deg),
                    "elevation counts from the horizon: 0 is sunset, 90 straight up");
  return position;
}

double parse_time(std::string_view text) {
  const auto colon = text.find(':');
  int hour = -1, minute = -1;
  const bool shaped = colon != std::string_view::npos && (colon == 1 || colon == 2) &&
                      text.size() == colon + 3 && read_whole(text.substr(0, colon), hour) &&
                      read_whole(text.substr(colon + 1), minute);
  if (!shaped || hour < 0 || hour > 23 || minute < 0 || minute > 59)
    throw UserError(fmt::format("time of day '{}', expected HH:MM from 00:00 to 23:59", text),
                    "for example --time 17:30");
  return hour + minute / 60.0;
}

SunPosition sun_at(double hours, const SunPath& path) noexcept {
  const double hour_angle = 15.0 * (hours - 12.0) * kDegree;
  const double latitude = path.latitude_deg * kDegree, declination = path.declination_deg * kDegree;
  const double east = -std::cos(declination) * std::sin(hour_angle);
  const double north = std::cos(latitude) * std::sin(declination) -
                       std::sin(latitude) * std::cos(declination) * std::cos(hour_angle);
  const double up = std::sin(latitude) * std::sin(declination) +
                    std::cos(latitude) * std::cos(declination) * std::cos(hour_angle);
  return {std::atan2(up, std::hypot(east, north)) / kDegree, std::atan2(north, east) / kDegree};
}

}  // namespace aluminate::sky
