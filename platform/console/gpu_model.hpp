// A console GPU as data: every number a Figure, filled from a platform file (platform_file.hpp), used by the
// pure functions of this folder and by shading/cost. It knows no shader and no scene.
#pragma once

#include "platform/console/figure.hpp"

#include <cstdint>
#include <string>
#include <string_view>

namespace aluminate::console {

/// How instructions become issue words; shading/cost holds one scheduler for each.
enum class AluModel : std::uint8_t {
  Vec4PlusScalar,  // Xenos: one vec4 and one scalar operation a word, strict third-source rule [XEN-U]
  DualSu,  // RSX: two 4-lane units in series a pass, each splits 3+1 or 2+2, texture takes the first [3DC]
  Vliw5,   // Latte: four lanes and one transcendental lane a bundle [TPU]
  ScalarLane,  // GCN: one component a lane, transcendentals at quarter rate [CLRX]
  MaliWord,    // Utgard: vec4 mul, vec4 add, scalar mul, scalar add and a combiner a word [LIMA]
};
std::string_view alu_model_word(
    AluModel model);  // "vec4+scalar", "dual-su", "vliw5", "scalar-lane", "mali-word"

struct GpuModel {
  std::string id;     // "xenos"; names the platform everywhere
  std::string name;   // "Xbox 360 Xenos"
  std::string notes;  // one paragraph for people
  std::string path;   // file it came from; "xenos.toml (built in)" for embedded ones
  int year = 0;
  AluModel alu_model = AluModel::Vec4PlusScalar;

  struct {
    Figure core_mhz;
  } clock;
  struct {
    Figure width_px, height_px, rate_hz;
  } target;  // the frame a budget is stated for
  struct {
    Figure pixels;
  } group;  // pixels that branch together

  struct {
    Figure lanes_per_clk;  // pixel lanes that issue one word (pass, bundle) each clock, whole chip
    Figure efficiency;     // share of peak reached in practice, (0, 1]
  } alu;
  struct {
    Figure
        lanes_per_clk;  // vertex lanes that issue one word each clock; shares the pixel ALUs when unified = 1
    Figure unified;     // 1: vertex words compete with pixel words; 0: own pipes
    Figure fetch_clk_per_64;  // clocks of vertex fetch for 64 vertices
    Figure efficiency;
  } vertex;
  struct {
    Figure triangles_per_clk;
  } setup;
  struct {
    Figure bilinear_per_clk;  // bilinear samples of a 32-bit texel, whole chip
    Figure trilinear_cyc;     // bilinear cycles of one trilinear sample
    Figure volume_cyc;        // bilinear cycles of one linear sample of a 3D texture
    Figure format_64bit;      // multipliers on the cycles of a sample, 32-bit texel = 1
    Figure format_128bit;
    Figure format_half2;  // filtered 16-bit float, two components
    Figure format_half4;  // filtered 16-bit float, four components
    Figure efficiency;
    Figure new_texels_per_cyc;  // texels a bilinear cycle brings from memory: what the cache does not hold
    Figure texel_bytes;         // bytes of one of them
  } texture;
  struct {
    Figure clk_per_interpolant;  // clocks for one vec4 interpolant of 64 pixels
    Figure clk_min;              // least clocks whatever the count
    Figure clk_color_extra;      // added when a COLOR input is read
  } interpolator;
  struct {
    Figure clk_per_clause;  // clocks for one exec clause (or flow word) of 64 pixels
    Figure clk_base;
  } sequencer;
  struct {
    Figure per_thread_max;  // vec4 registers one thread can address
    Figure sets, rows;      // threads = min(threads_max, sets * floor(rows / registers))
    Figure threads_max, threads_max_vertex;
  } registers;
  struct {
    // Side of the block of samples that is rejected together before shading: 1 = each sample, else 4, 8 or 16.
    Figure reject_samples;
  } depth;
  struct {
    Figure pixels_per_clk;   // colour + depth writes of a 32-bit target, one sample a pixel
    Figure z_only_rate;      // multiplier on the rate when no colour is written
    Figure samples_per_clk;  // MSAA samples a clock, colour + depth
    Figure blend_cyc;        // multiplier on the cycles when blending, 32-bit targets
    Figure format_64bit;     // multiplier on the cycles, 64-bit targets
    Figure blend_cyc_64bit;  // further multiplier when blending 64-bit targets
    Figure efficiency;
  } rop;
  struct {
    Figure bandwidth_gbs;  // main (or video) memory, 1e9 bytes a second
    Figure efficiency;
  } memory;
  struct {  // optional: on-chip render target memory with explicit resolves
    Figure bytes;
    Figure tile_width_samples, tile_height_samples;
    Figure resolve_px_per_clk;
  } edram;

  bool has_edram() const { return edram.bytes.present; }
};

}  // namespace aluminate::console
