// Which camera, and the matrix that takes normalised positions to clip space. Pure functions of the scene's
// bounds and cameras; no trigonometry from libm, so the matrix has the same bits everywhere. World and view
// are right-handed, +y up, the camera looks along -z.
#pragma once

#include "scenes/normalised_space.hpp"
#include "scenes/scene.hpp"

#include <glm/glm.hpp>
#include <string>
#include <string_view>

namespace aluminate::scenes {

/// --camera auto | outside | inside | gltf[:N] | "ex,ey,ez:tx,ty,tz:fovy" (world units, degrees).
struct CameraChoice {
  enum class Kind { Auto, Outside, Inside, File, Explicit };
  Kind kind = Kind::Auto;
  int index = 0;                 // File: N, counted from 0
  glm::dvec3 eye{0}, target{0};  // Explicit
  double fovy_degrees = 45;      // Explicit, in (0, 180)
};

/// Throws UserError that says what was expected at the part that is wrong.
CameraChoice parse_camera(std::string_view text);

/// A camera in normalised units (see normalised_space.hpp). right, up, back are orthonormal; the camera looks
/// along -back.
struct View {
  glm::dvec3 eye{0}, right{1, 0, 0}, up{0, 1, 0}, back{0, 0, 1};
  bool perspective = true;
  double tan_half_fovy = 0.41421356237309503;  // perspective: tangent of half the vertical field of view
  double half_height = 1;                      // orthographic: half the height of the view volume
  double aspect = 1;                           // width / height of the image; pixels are square
  double near_plane = 0.01, far_plane = 10;    // distances along -back, near < far
  bool inside = false;                         // --camera inside: the light rig fills the scene's box
  std::string description;                     // "outside", "inside", "gltf:0 'Front'", "1,2,3:0,0,0:45"

  /// Column-major, clip = M * (p, 1). x right, y up, -w..w; z in 0..w (0 = near): D3D depth range.
  glm::dmat4 world_to_clip() const;
};

/// Throws UserError when the file has no such camera or the camera cannot see anything (eye = target).
/// A file camera's field of view is vertical and the image's aspect replaces the file's; its node's scale is
/// ignored; without zfar the far plane is put behind the scene's bounds.
View make_view(const Scene& scene, const NormalisedSpace& space, const CameraChoice& choice, double aspect);

}  // namespace aluminate::scenes
