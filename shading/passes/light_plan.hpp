// How a frame's lights are spread over draws on the G-buffer. In: the draw list. Out: what the console draws
// and pays (DrawList::screen_draws, their programs), and what is run instead, which gives the same bits.
//
// The console draws: ambient, emitted light and every light without a bound in full-screen draws of up to 8
// lights, the pass "sun"; each bounded light (KHR_lights_punctual with a range) as a stencilled volume of its
// own, the pass "lights". What runs: the same groups, and for each tile its bounded lights in groups of 8, 4,
// 2 and 1, each group adding to what the one before left, in order.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "shading/passes/draw_list.hpp"

namespace aluminate::passes {

/// A light that ends: what its volume on the console encloses.
struct BoundedLight {
  std::uint32_t stamp_draw = 0;  // index a billed stamp names
  glm::dvec3 position{0};
  double inv_range2 = 0, range = 0;
  glm::dvec3 spot_axis{0};
  double spot_scale = 0, spot_offset = 1;
  int own_group = -1;  // into LightPlan::own: it casts a shadow; -1: shares a sized group
  /// Pixels of the screen rectangle around the sphere: what each face of the marking draw touches.
  std::uint64_t rectangle_pixels = 0;

  /// Sphere and cone, where the shader's window and cone are not 0.
  bool contains(const glm::dvec3& p) const {
    const glm::dvec3 to_light = position - p;
    const double d2 = glm::dot(to_light, to_light);
    if (!(d2 * inv_range2 < 1.0)) return false;
    return spot_scale == 0.0 ||
           glm::dot(to_light, spot_axis) * spot_scale + spot_offset * std::sqrt(d2) > 0.0;
  }
};

struct LightPlan {
  /// Groups every lit pixel runs, in order.
  struct Group {
    int program = 0;  // into `programs`
    std::vector<double> constants;
  };
  static constexpr std::array<int, 4> kSizes{8, 4, 2, 1};

  std::vector<PixelProgram> programs;  // what runs
  std::vector<Group> everywhere;
  std::uint32_t first_screen_stamp = 0;  // stamp index of everywhere[0]
  std::vector<BoundedLight> bounded;
  std::array<Group, kSizes.size()>
      sized;  // one for each of kSizes that can occur; constants of no light in particular
  std::vector<Group> own;
  /// On the grid: light_position, light_color, light_window, light_axis of each bounded light.
  std::vector<std::array<double, 16>> light_rows;
  /// A light reaches no pixel further than its range plus this: more than reconstruction and the grid can
  /// err.
  double reach_margin = 0;

  bool used() const { return !everywhere.empty() || !bounded.empty(); }
  /// Constants of a sized group for `lights` (indices into bounded), as many as its size.
  void fill_constants(std::size_t size_index, std::span<const std::uint32_t> lights,
                      std::vector<double>& constants) const;
};

/// Adds the console's draws and their programs to `list`.
LightPlan make_light_plan(DrawList& list, const FrameOptions& options);

}  // namespace aluminate::passes
