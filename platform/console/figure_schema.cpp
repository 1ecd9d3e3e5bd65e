// The schema of a platform file, once: keys, limits, units and meanings.
#include "platform/console/platform_file.hpp"

namespace aluminate::console {
namespace {

#define ALU_FIGURE(group, field, low, high, whole, optional_table, unit, meaning)                         \
  FigureField {                                                                                           \
#group, #field, [](GpuModel & gpu) -> Figure& { return gpu.group.field; }, low, high, whole,          \
                                                                            optional_table, unit, meaning \
  }

// Limits refuse slips of the keyboard (a clock in Hz, an efficiency in per cent), not unusual hardware.
constexpr FigureField kFields[] = {
    ALU_FIGURE(clock, core_mhz, 1, 10000, false, false, "MHz",
               "core clock; every per-clock rate below refers to it"),
    ALU_FIGURE(target, width_px, 1, 16384, true, false, "px", "width of the frame a budget is stated for"),
    ALU_FIGURE(target, height_px, 1, 16384, true, false, "px", "height of that frame"),
    ALU_FIGURE(target, rate_hz, 1, 1000, false, false, "Hz", "frame rate; budget = 1000 / rate_hz ms"),
    ALU_FIGURE(group, pixels, 1, 65536, true, false, "px", "pixels that branch together"),
    ALU_FIGURE(alu, lanes_per_clk, 0.01, 65536, false, false, "lanes/clk",
               "pixel lanes issuing one word each clock"),
    ALU_FIGURE(alu, efficiency, 0.01, 1, false, false, "of peak", "derating of ALU time"),
    ALU_FIGURE(vertex, lanes_per_clk, 0.01, 65536, false, false, "lanes/clk",
               "vertex lanes issuing one word each clock"),
    ALU_FIGURE(vertex, unified, 0, 1, true, false, "yes = 1", "vertex words use the pixel ALUs"),
    ALU_FIGURE(vertex, fetch_clk_per_64, 0, 65536, false, false, "clk",
               "vertex fetch clocks for 64 vertices"),
    ALU_FIGURE(vertex, efficiency, 0.01, 1, false, false, "of peak", "derating of vertex time"),
    ALU_FIGURE(setup, triangles_per_clk, 0.001, 64, false, false, "tri/clk", "triangle set-up rate"),
    ALU_FIGURE(texture, bilinear_per_clk, 0.01, 65536, false, false, "samples/clk",
               "bilinear 32-bit samples"),
    ALU_FIGURE(texture, trilinear_cyc, 1, 16, false, false, "cyc", "bilinear cycles of a trilinear sample"),
    ALU_FIGURE(texture, volume_cyc, 1, 16, false, false, "cyc", "bilinear cycles of a linear 3D sample"),
    ALU_FIGURE(texture, format_64bit, 1, 16, false, false, "x", "cycle factor of 64-bit texels"),
    ALU_FIGURE(texture, format_128bit, 1, 16, false, false, "x", "cycle factor of 128-bit texels"),
    ALU_FIGURE(texture, format_half2, 1, 16, false, false, "x",
               "cycle factor of filtered 16F, two components"),
    ALU_FIGURE(texture, format_half4, 1, 16, false, false, "x",
               "cycle factor of filtered 16F, four components"),
    ALU_FIGURE(texture, efficiency, 0.01, 1, false, false, "of peak", "derating of texture time (stalls)"),
    ALU_FIGURE(texture, new_texels_per_cyc, 0, 64, false, false, "texels/cyc",
               "texels a fetch cycle brings from memory"),
    ALU_FIGURE(texture, texel_bytes, 0.125, 16, false, false, "bytes", "bytes of one of them"),
    ALU_FIGURE(interpolator, clk_per_interpolant, 0, 1024, false, false, "clk",
               "one vec4 texture coordinate, 64 pixels"),
    ALU_FIGURE(interpolator, clk_min, 0, 1024, false, false, "clk", "least interpolator clocks, 64 pixels"),
    ALU_FIGURE(interpolator, clk_color_extra, 0, 1024, false, false, "clk",
               "added when a COLOR input is read"),
    ALU_FIGURE(sequencer, clk_per_clause, 0, 1024, false, false, "clk",
               "one exec clause or flow word, 64 pixels"),
    ALU_FIGURE(sequencer, clk_base, 0, 1024, false, false, "clk", "sequencer clocks of any program"),
    ALU_FIGURE(registers, per_thread_max, 1, 4096, true, false, "vec4", "registers one thread can address"),
    ALU_FIGURE(registers, sets, 1, 4096, true, false, "sets", "register files that hold pixel threads"),
    ALU_FIGURE(registers, rows, 1, 1048576, true, false, "vec4", "registers of one file, one lane"),
    ALU_FIGURE(registers, threads_max, 1, 1048576, true, false, "threads", "cap on pixel threads in flight"),
    ALU_FIGURE(registers, threads_max_vertex, 1, 1048576, true, false, "threads",
               "cap on vertex threads in flight"),
    ALU_FIGURE(depth, reject_samples, 1, 16, true, false, "samples",
               "side of blocks rejected before shading: 1, 4, 8, 16"),
    ALU_FIGURE(rop, pixels_per_clk, 0.01, 4096, false, false, "px/clk",
               "colour and depth writes, 32-bit target"),
    ALU_FIGURE(rop, z_only_rate, 0.1, 64, false, false, "x", "rate factor without colour"),
    ALU_FIGURE(rop, samples_per_clk, 0.01, 65536, false, false, "samples/clk",
               "MSAA samples, colour and depth"),
    ALU_FIGURE(rop, blend_cyc, 1, 16, false, false, "x", "cycle factor of blending, 32-bit target"),
    ALU_FIGURE(rop, format_64bit, 1, 16, false, false, "x", "cycle factor of 64-bit targets"),
    ALU_FIGURE(rop, blend_cyc_64bit, 1, 16, false, false, "x", "further factor of blending, 64-bit target"),
    ALU_FIGURE(rop, efficiency, 0.01, 1, false, false, "of peak", "derating of ROP and resolve time"),
    ALU_FIGURE(memory, bandwidth_gbs, 0.01, 100000, false, false, "GB/s", "main or video memory, 1e9 bytes"),
    ALU_FIGURE(memory, efficiency, 0.01, 1, false, false, "of peak", "derating of memory time"),
    ALU_FIGURE(edram, bytes, 1024, 1e10, true, true, "bytes", "on-chip render target memory"),
    ALU_FIGURE(edram, tile_width_samples, 1, 4096, true, true, "samples", "tile width, 32-bit samples"),
    ALU_FIGURE(edram, tile_height_samples, 1, 4096, true, true, "samples", "tile height"),
    ALU_FIGURE(edram, resolve_px_per_clk, 0.01, 4096, false, true, "px/clk", "pixels copied to memory"),
};

#undef ALU_FIGURE

}  // namespace

std::span<const FigureField> figure_fields() { return kFields; }

std::string_view alu_model_word(AluModel model) {
  switch (model) {
    case AluModel::Vec4PlusScalar:
      return "vec4+scalar";
    case AluModel::DualSu:
      return "dual-su";
    case AluModel::Vliw5:
      return "vliw5";
    case AluModel::ScalarLane:
      return "scalar-lane";
    case AluModel::MaliWord:
      return "mali-word";
  }
  return "";
}

}  // namespace aluminate::console
