// One rendered frame and its bill: what render_frame() gives back. Every field but `timing` is the same on
// every machine, thread count and execution tier.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "shading/passes/options.hpp"

namespace aluminate::scenes {
struct Scene;
}

namespace aluminate::passes {

/// What the console would have paid at each pixel, row-major from the top left. Helper lanes that fall
/// outside the picture are charged to the nearest pixel of their quad, so that the sum over pixels equals the
/// pass totals.
struct CostPlanes {
  std::vector<std::uint32_t> alu_words;  // words executed at this pixel, helper lanes included
  std::vector<std::uint32_t> alu_slots;  // ps_3_0 slots, likewise
  std::vector<std::uint32_t> fetches;    // texture instructions
  std::vector<std::uint32_t> fetch_cyc;  // bilinear cycles
  std::vector<std::uint32_t> overdraw;   // covered invocations of a pixel shader
  std::vector<std::uint32_t> helpers;    // helper-lane invocations
  std::vector<std::uint32_t> path;       // 1 + index into Frame::paths of the program seen here; 0: none
};

/// Totals of one pass. Lane-weighted: alu_words is the sum over executed lanes, helper lanes included.
struct PassTotals {
  std::string name;
  std::uint64_t pixels = 0;  // covered invocations
  std::uint64_t quads = 0;   // 2x2 quads shaded
  std::uint64_t helper_lanes = 0;
  std::uint64_t alu_words = 0, alu_slots = 0, fetches = 0, fetch_cyc = 0;
  std::uint64_t streamed_cyc = 0;  // of fetch_cyc, reads of whole targets whose traffic is in `bytes` already
  std::uint64_t vertices = 0, vertex_words = 0, triangles = 0;
  std::uint64_t rop_pixels = 0, rop_blended = 0;  // pixels written; pixels read, modified and written
  std::uint64_t rop_depth_only = 0;               // fragments that touch depth and stencil alone
  int color_targets = 1;                          // 32-bit colour targets of rop_pixels
  int tiling_passes = 1;                          // times its geometry is sent, for eDRAM too small
  std::uint64_t resolve_pixels = 0;  // pixels of any target copied to memory, to be fetched later
  std::uint64_t bytes = 0;           // main-memory traffic apart from texels: vertices, indices, resolve
};

/// A pixel program that took part, with the costs a lane pays for one run of it.
struct PathInfo {
  std::string program;  // "forward_lit[base_color+normal] 4 lights"
  std::uint32_t alu_words = 0, alu_slots = 0, fetches = 0, fetch_cyc = 0;
  std::vector<std::string> instructions;  // as scheduled, cost::listing_lines
};

struct Saturation {
  std::string place;  // "forward_lit.hlsl:41:12"
  std::string instruction;
  std::uint64_t lanes = 0;
};

struct Timing {  // milliseconds of wall time; the only part that varies
  std::map<std::string, double> phases_ms;  // of the last frame; "prepare", made once, belongs to no frame
  std::vector<double> frame_ms;             // from an empty frame to stored pixels
};

struct Frame {
  int width = 0, height = 0;
  double texel_share = 1;                // bytes of the textures as stored, of their bytes as RGBA8
  int samples = 1;                       // a pixel, before the resolve
  std::vector<std::uint8_t> rgba8;       // stored display values, 4 bytes a pixel, top left first
  std::vector<float> linear;             // RGBA linear light before tone map and clamp, 4 floats a pixel
  std::vector<std::uint32_t> depth_d24;  // of a pixel's first sample; 0 near .. 2^24-1 far and background
  std::vector<std::uint8_t> covered;     // 1 where geometry was drawn
  CostPlanes cost;
  std::vector<PassTotals> passes;
  std::vector<PathInfo> paths;
  std::map<std::string, std::uint64_t> skipped;  // by skip name: work items left out
  std::map<std::string, std::uint64_t> dropped;  // triangles that cannot be drawn, by reason
  std::uint64_t saturations = 0;
  std::vector<Saturation> saturated_instructions;  // --checked
  std::vector<std::string> warnings;
  std::string lights;  // the light set used, "rig:4"
  int light_count = 0;
  Timing timing;

  std::size_t pixel_count() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

/// Planes of the right size, for tiles to fill. New memory is 0; that of `recycled` holds what it held.
Frame blank_frame(const FrameOptions& options, Frame recycled = {});

/// Renders `scene` once: shading/passes/renderer.hpp for more frames of one scene. Throws UserError for options that do not fit the scene or the shader.
Frame render_frame(const scenes::Scene& scene, const FrameOptions& options);

}  // namespace aluminate::passes
