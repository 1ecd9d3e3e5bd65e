#include "scenes/view.hpp"

#include "platform/host/error.hpp"
#include "scenes/trigonometry.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace aluminate::scenes {
namespace {

constexpr const char* kCameraForms =
    "use auto, outside, inside, gltf, gltf:N or \"ex,ey,ez:tx,ty,tz:fovy\" (world units, degrees)";

double parse_number(std::string_view text, std::string_view whole, std::string_view what) {
  double value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || status != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    throw UserError(fmt::format("camera '{}': expected a number for {}, found '{}'", whole, what, text),
                    kCameraForms);
  return value;
}

glm::dvec3 parse_point(std::string_view text, std::string_view whole, std::string_view what) {
  glm::dvec3 point{0};
  for (int axis = 0; axis < 3; ++axis) {
    const auto comma = text.find(',');
    if ((comma == std::string_view::npos) != (axis == 2))
      throw UserError(fmt::format("camera '{}': expected three numbers x,y,z for the {}", whole, what),
                      kCameraForms);
    point[axis] = parse_number(text.substr(0, comma), whole, fmt::format("the {}'s {}", what, "xyz"[axis]));
    text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
  }
  return point;
}

/// |v| for components of any size: no overflow or underflow of the squares.
double length_of(const glm::dvec3& v) {
  const double longest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  if (!(longest > 0) || !std::isfinite(longest)) return longest > 0 ? longest : 0;
  const glm::dvec3 u = v / longest;
  return longest * std::sqrt(u.x * u.x + u.y * u.y + u.z * u.z);
}

/// Unit vector; zero when v is zero or not finite.
glm::dvec3 unit(const glm::dvec3& v) {
  const double longest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  if (!(longest > 0) || !std::isfinite(longest)) return glm::dvec3(0);
  const glm::dvec3 u = v / longest;
  return u / std::sqrt(u.x * u.x + u.y * u.y + u.z * u.z);
}

/// right, up, back from the direction to look away from and a direction roughly up.
void orient(View& view, const glm::dvec3& back, const glm::dvec3& up_hint) {
  view.back = unit(back);
  glm::dvec3 right = glm::cross(up_hint, view.back);
  // Looking straight up or down: any horizontal axis will do; -z becomes "up in the picture" as for a map.
  if (length_of(right) < 1e-9) right = glm::cross(glm::dvec3(0, 0, view.back.y > 0 ? -1 : 1), view.back);
  if (length_of(right) < 1e-9) right = glm::cross(glm::dvec3(1, 0, 0), view.back);
  view.right = unit(right);
  view.up = glm::cross(view.back, view.right);
}

View look_at(const glm::dvec3& eye, const glm::dvec3& target, double fovy_degrees) {
  View view;
  view.eye = eye;
  orient(view, eye - target, glm::dvec3(0, 1, 0));
  const SinCos half = sin_cos(fovy_degrees * (kPi / 360));
  view.tan_half_fovy = half.sin / half.cos;
  return view;
}

View outside_view(const NormalisedSpace& space) {
  const double r = space.radius;
  View view = look_at(unit(glm::dvec3(0.6, 0.45, 1.0)) * (2.2 * r), glm::dvec3(0), 45);
  view.near_plane = 0.01 * r;
  view.far_plane = 10 * r;
  view.description = "outside";
  return view;
}

View inside_view(const NormalisedSpace& space) {
  const double r = space.radius;
  const glm::dvec3 extent = space.half_extent * 2.0, low = -space.half_extent;
  const glm::dvec3 eye = low + extent * glm::dvec3(0.06, 0.36, 0.42);
  const glm::dvec3 target = low + extent * glm::dvec3(0.75, 0.33, 0.62);
  if (eye == target)
    throw UserError("camera 'inside': the scene has no extent to stand in", "use --camera outside");
  View view = look_at(eye, target, 60);
  view.near_plane = 0.002 * r;
  view.far_plane = 4 * r;
  view.inside = true;
  view.description = "inside";
  return view;
}

View explicit_view(const NormalisedSpace& space, const CameraChoice& choice) {
  const glm::dvec3 eye = space.point(choice.eye), target = space.point(choice.target);
  if (eye == target)
    throw UserError("camera: eye and target are the same point, so there is no direction to look in",
                    kCameraForms);
  View view = look_at(eye, target, choice.fovy_degrees);
  view.near_plane = 0.002 * space.radius;
  view.far_plane = std::max(10 * space.radius, length_of(eye) + 1.001 * space.radius);
  view.description = fmt::format("{},{},{}:{},{},{}:{}", choice.eye.x, choice.eye.y, choice.eye.z,
                                 choice.target.x, choice.target.y, choice.target.z, choice.fovy_degrees);
  return view;
}

View file_view(const Scene& scene, const NormalisedSpace& space, int index) {
  const auto count = scene.cameras.size();
  if (index < 0 || static_cast<std::size_t>(index) >= count)
    throw UserError(
        fmt::format("camera 'gltf:{}': {} has {}", index, scene.file,
                    count == 0 ? "no camera"
                               : fmt::format("{} camera{}, counted from 0", count, count == 1 ? "" : "s")),
        "use --camera outside, inside or an explicit eye:target:fovy");
  const Camera& camera = scene.cameras[static_cast<std::size_t>(index)];
  const glm::dmat4& m = camera.camera_to_world;
  View view;
  view.eye = space.point(glm::dvec3(m[3]));
  orient(view, glm::dvec3(m[2]), glm::dvec3(m[1]));
  const double basis = length_of(view.back) * length_of(view.right) * length_of(view.up);
  const double reach = length_of(view.eye);
  if (!(basis > 0.5) || !std::isfinite(reach))
    throw UserError(fmt::format("camera 'gltf:{}' ('{}'): its node's transform is not usable as a camera",
                                index, camera.name),
                    "use --camera outside");
  view.perspective = camera.perspective;
  if (camera.perspective) {
    const SinCos half = sin_cos(camera.fovy / 2);
    view.tan_half_fovy = half.sin / half.cos;
  } else {
    view.half_height = camera.ymag * space.scale;
  }
  view.near_plane = camera.near_plane * space.scale;
  // Without zfar the projection is infinite; a plane just behind the bounds shows the same and keeps depth
  // precision.
  view.far_plane = camera.far_plane > 0 ? camera.far_plane * space.scale : reach + 1.001 * space.radius;
  if (!(view.far_plane > view.near_plane)) view.far_plane = 2 * view.near_plane + space.radius;
  view.description = fmt::format("gltf:{} '{}'", index, camera.name);
  return view;
}

}  // namespace

CameraChoice parse_camera(std::string_view text) {
  using Kind = CameraChoice::Kind;
  CameraChoice choice;
  if (text == "auto") return choice;
  if (text == "outside") return choice.kind = Kind::Outside, choice;
  if (text == "inside") return choice.kind = Kind::Inside, choice;
  if (text == "gltf") return choice.kind = Kind::File, choice;
  if (text.starts_with("gltf:")) {
    choice.kind = Kind::File;
    const std::string_view number = text.substr(5);
    const auto [end, status] = std::from_chars(number.data(), number.data() + number.size(), choice.index);
    if (status != std::errc{} || end != number.data() + number.size() || choice.index < 0)
      throw UserError(fmt::format("camera '{}': expected a camera number from 0, found '{}'", text, number),
                      kCameraForms);
    return choice;
  }
  const auto first = text.find(':');
  const auto second = first == std::string_view::npos ? first : text.find(':', first + 1);
  if (second == std::string_view::npos || text.find(':', second + 1) != std::string_view::npos)
    throw UserError(fmt::format("camera '{}': not a known camera", text), kCameraForms);
  choice.kind = Kind::Explicit;
  choice.eye = parse_point(text.substr(0, first), text, "eye");
  choice.target = parse_point(text.substr(first + 1, second - first - 1), text, "target");
  choice.fovy_degrees = parse_number(text.substr(second + 1), text, "the field of view");
  if (!(choice.fovy_degrees > 0 && choice.fovy_degrees < 180))
    throw UserError(fmt::format("camera '{}': the field of view must lie between 0 and 180 degrees", text),
                    kCameraForms);
  return choice;
}

View make_view(const Scene& scene, const NormalisedSpace& space, const CameraChoice& choice, double aspect) {
  ALU_CHECK(aspect > 0 && std::isfinite(aspect), "aspect {}", aspect);
  using Kind = CameraChoice::Kind;
  Kind kind = choice.kind;
  if (kind == Kind::Auto) kind = scene.cameras.empty() ? Kind::Outside : Kind::File;
  View view;
  switch (kind) {
    case Kind::Auto:
    case Kind::Outside:
      view = outside_view(space);
      break;
    case Kind::Inside:
      view = inside_view(space);
      break;
    case Kind::File:
      view = file_view(scene, space, choice.kind == Kind::Auto ? 0 : choice.index);
      break;
    case Kind::Explicit:
      view = explicit_view(space, choice);
      break;
  }
  view.aspect = aspect;
  return view;
}

glm::dmat4 View::world_to_clip() const {
  // Rows of the view matrix: right, up, back, each with -dot(axis, eye).
  const glm::dvec3 shift{-glm::dot(right, eye), -glm::dot(up, eye), -glm::dot(back, eye)};
  const double n = near_plane, f = far_plane;
  glm::dmat4 clip{0};
  if (perspective) {
    // z_view = -n -> 0 and z_view = -f -> w = f.
    const double sx = 1 / (tan_half_fovy * aspect), sy = 1 / tan_half_fovy, a = f / (n - f),
                 b = n * f / (n - f);
    for (int c = 0; c < 3; ++c) clip[c] = glm::dvec4(right[c] * sx, up[c] * sy, back[c] * a, -back[c]);
    clip[3] = glm::dvec4(shift.x * sx, shift.y * sy, shift.z * a + b, -shift.z);
  } else {
    const double sx = 1 / (half_height * aspect), sy = 1 / half_height, a = 1 / (n - f), b = n / (n - f);
    for (int c = 0; c < 3; ++c) clip[c] = glm::dvec4(right[c] * sx, up[c] * sy, back[c] * a, 0);
    clip[3] = glm::dvec4(shift.x * sx, shift.y * sy, shift.z * a + b, 1);
  }
  return clip;
}

}  // namespace aluminate::scenes
