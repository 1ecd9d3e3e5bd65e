// Directions to faces of a cube map, Direct3D's layout [MSD]: faces +x -x +y -y +z -z, each seen from the
// centre with v down. Literal binary64 sequences, shared by the fast texture unit and its reference.
#pragma once

#include <array>
#include <cmath>

namespace aluminate::vm {

using Direction = std::array<double, 3>;

/// A direction in the frame of a face: s to the right, t down, m towards the face. Linear in the direction.
struct FaceFrame {
  double s = 0, t = 0, m = 0;
};

/// The face a direction points at: the axis of greatest magnitude; of equal ones z before y before x.
constexpr int cube_face(const Direction& d) noexcept {
  const double x = d[0] < 0 ? -d[0] : d[0], y = d[1] < 0 ? -d[1] : d[1], z = d[2] < 0 ? -d[2] : d[2];
  const std::size_t axis = z >= x && z >= y ? 2 : y >= x ? 1 : 0;
  return static_cast<int>(2 * axis) + (d[axis] < 0 ? 1 : 0);
}

constexpr FaceFrame in_face(int face, const Direction& d) noexcept {
  switch (face) {
    case 0:
      return {-d[2], -d[1], d[0]};
    case 1:
      return {d[2], -d[1], -d[0]};
    case 2:
      return {d[0], d[2], d[1]};
    case 3:
      return {d[0], -d[2], -d[1]};
    case 4:
      return {d[0], -d[1], d[2]};
    default:
      return {-d[0], -d[1], -d[2]};
  }
}

struct FacePoint {
  int face = 0;
  double u = 0.5, v = 0.5;  // [0, 1]
};

/// No direction (all zero) is the middle of +z.
inline FacePoint face_point(const Direction& d) noexcept {
  const int face = cube_face(d);
  const FaceFrame f = in_face(face, d);
  if (f.m == 0) return {face, 0.5, 0.5};
  return {face, 0.5 * (f.s / f.m) + 0.5, 0.5 * (f.t / f.m) + 0.5};
}

/// Change of (u, v) on the face of d when the direction changes by step: the derivative of s / m.
inline std::array<double, 2> face_step(const Direction& d, const Direction& step) noexcept {
  const int face = cube_face(d);
  const FaceFrame at = in_face(face, d), by = in_face(face, step);
  if (at.m == 0) return {0, 0};
  const double scale = 0.5 / (at.m * at.m);
  return {(by.s * at.m - at.s * by.m) * scale, (by.t * at.m - at.t * by.m) * scale};
}

}  // namespace aluminate::vm
