// What a lens does to a photograph and how to take it back: geometric distortion, vignetting, lateral colour.
// Models of lensfun (poly3, poly5, ptlens; pa vignetting; linear and poly3 colour) and Adobe's camera model
// (rectilinear, fisheye). All map an ideal position to where the lens put it; undistort() inverts that. Never
// looks at colours.
#pragma once

#include <array>
#include <string>

#include "calibration/chart_geometry.hpp"
#include "calibration/photo.hpp"

namespace aluminate::calibration {

enum class LensKind {
  None,
  Poly3,           // rd = ru (1 - k1 + k1 ru^2) [Lensfun]
  Poly5,           // rd = ru (1 + k1 ru^2 + k2 ru^4)
  PtLens,          // rd = ru (k1 ru^3 + k2 ru^2 + k3 ru + 1 - k1 - k2 - k3)
  AcmRectilinear,  // x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 (k4 y + k5 x) x + k5 r^2, y alike with + k4 r^2
                   // [Chen10]
  AcmFisheye,      // rd = theta + k1 theta^3 + k2 theta^5, theta = atan(ru)
};

/// Positions are px from `centre`, divided by `unit_px`: half the shorter side for lensfun's models, the
/// focal length in px for Adobe's.
struct LensModel {
  LensKind kind = LensKind::None;
  std::array<double, 5> k{};
  Point centre;
  double unit_px = 1.0;

  /// Lateral colour: a channel's radius times a + b r + c r^2, after distortion; green is (1, 0, 0) in
  /// lensfun's models.
  std::array<std::array<double, 3>, 3> channel_scale{{{1, 0, 0}, {1, 0, 0}, {1, 0, 0}}};

  /// A pixel at radius r, in vignette_unit_px, is darkened by 1 + v1 r^2 + v2 r^4 + v3 r^6.
  std::array<double, 3> vignette{};
  double vignette_unit_px = 1.0;

  bool moves_pixels() const;
  bool has_lateral_colour() const;
  bool has_vignette() const;
};

/// "poly3:k1", "poly5:k1,k2", "ptlens:a,b,c", "acm:k1,k2,k3,k4,k5", "acm-fisheye:k1,k2", "none". UserError
/// otherwise. The units are those of a width x height picture; focal_px is needed for Adobe's models (0: not
/// known).
LensModel parse_lens(const std::string& text, int width, int height, double focal_px);

/// Where the lens puts an ideal position, px.
Point distort(const LensModel& lens, const Point& ideal) noexcept;
Point distort(const LensModel& lens, const Point& ideal, std::size_t channel) noexcept;

/// The inverse, by Newton's method to 1e-9 of the unit. Throws UserError where the model folds over and has
/// no inverse.
Point undistort(const LensModel& lens, const Point& seen);

/// 1 at the centre.
double vignette_at(const LensModel& lens, const Point& seen) noexcept;

/// Takes vignetting back, then resamples every channel (cubic) from where the lens put it. Positions outside
/// of the photograph repeat its border.
void correct_lens(Photo& photo, const LensModel& lens);

/// What lensfun's database knows of a lens at a focal length, aperture and distance (0: 1000 m). Throws
/// UserError when the camera or the lens is not in it, with the nearest names.
struct LensQuery {
  std::string maker, model, lens;
  double focal_mm = 0, aperture = 0, distance_m = 0;
};
LensModel lens_from_database(const LensQuery& query, int width, int height);

}  // namespace aluminate::calibration
