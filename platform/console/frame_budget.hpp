// From counted work to milliseconds on a console: each pass costs its slowest unit, a frame the sum of its
// passes, and the verdict says how sure it is. Counts come in, nothing is executed; no host timing ever
// enters.
#pragma once

#include "platform/console/gpu_model.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace aluminate::console {

enum class Unit : std::uint8_t { Alu, Texture, Vertex, Setup, Rop, Memory, Resolve };
inline constexpr int kUnitCount = 7;
std::string_view unit_name(
    Unit unit);  // "ALU", "texture", "vertex", "setup", "ROP", "memory", "resolve": tables and JSON
std::string_view unit_phrase(Unit unit);  // "triangle set-up", ...: sentences

enum class ColorFormat : std::uint8_t { None, Bits32, Bits64 };  // None = depth only

/// Fragments written with one output state.
struct RopWork {
  double pixels = 0;  // fragments that pass depth (and reads of the blended target are implied by `blend`)
  ColorFormat format = ColorFormat::Bits32;
  bool blend = false;
  int samples = 1;  // 1, 2 or 4 MSAA samples a pixel
  int targets = 1;  // colour targets written at once; each costs its own cycle
};

struct ByteStream {
  std::string name;  // "textures", "vertices", "colour", ...
  double bytes = 0;  // main-memory traffic; on-chip eDRAM traffic is not listed
};

/// One pass, counted over the whole frame. Totals are lane-weighted: a lane is a covered pixel or a helper
/// lane of a partly covered 2x2 quad, so lanes = 4 * quads = pixels + helper_lanes and helper lanes are
/// already in every total.
struct PassWork {
  std::string name;
  double pixels = 0;          // covered fragments shaded (overdraw included)
  double quads = 0;           // 2x2 quads shaded
  double helper_lanes = 0;    // lanes executed only for derivatives
  double alu_words = 0;       // sum over executed lanes of the issue words each ran
  double alu_slots = 0;       // same in ps_3_0 slots; reported, never priced
  double fetches = 0;         // sum over executed lanes of texture fetches
  double fetch_cyc = 0;       // same, times filter and format cycles: bilinear 32-bit cycles
  double texel_cyc = 0;       // of fetch_cyc, those of covered pixels: only they bring new texels
  double texel_share = 1;     // bytes of these texels, of those texture.texel_bytes says
  double vertices = 0;        // vertices shaded
  double vertex_words = 0;    // sum over vertices of issue words
  double triangles = 0;       // triangles reaching set-up
  double tiling_passes = 1;   // times the geometry is sent (edram.hpp); multiplies vertex and set-up work
  double resolve_pixels = 0;  // pixels copied from eDRAM to memory, one target each
  std::vector<RopWork> rop{};
  std::vector<ByteStream> bytes{};

  double total_bytes() const;  // of the streams; texels come on top, see texel_bytes
};

struct PassTime {
  std::string name;
  std::array<double, kUnitCount> peak_ms{};     // each unit alone, at peak rate
  std::array<double, kUnitCount> derated_ms{};  // peak / efficiency figure of the unit
  double peak = 0, derated = 0;                 // slowest unit, ms
  double memory_bytes = 0;                      // main-memory traffic, texels included
  Unit bound = Unit::Alu;                       // the slowest unit, derated
  std::string sentence;                         // "ALU bound: 3.21 ms of words, next texture at 62 %"
};

enum class Verdict : std::uint8_t { Fits, Over, Inconclusive };
std::string_view verdict_word(Verdict verdict);  // "fits", "over", "inconclusive"

/// The frame again with one uncertain figure at one end of its range.
struct SensitivityRow {
  std::string figure;  // "texture.efficiency"
  Confidence confidence = Confidence::Guess;
  double low = 0, value = 0, high = 0;
  double ms_at_low = 0, ms_at_high = 0;  // derated frame time
  bool flips = false;                    // the verdict differs from the nominal one at an end
};

struct FrameBudget {
  std::string platform;
  std::vector<PassTime> passes;
  double peak_ms = 0, derated_ms = 0;
  double budget_ms = 0;
  bool fits_peak = false, fits = false;     // against budget_ms; `fits` uses derated times
  Verdict verdict = Verdict::Fits;          // Inconclusive when any row flips
  Unit bound = Unit::Alu;                   // unit with the most frame time among the passes it bounds
  std::string sentence;                     // "fits: 21.40 ms of 33.33 ms, mostly ALU bound"
  std::vector<SensitivityRow> sensitivity;  // largest effect first
};

PassTime price_pass(const GpuModel& gpu, const PassWork& work);

/// budget_ms <= 0: 1000 / target.rate_hz. No passes: 0 ms, fits. Negative or non-finite work is a bug
/// (InternalError).
FrameBudget price_frame(const GpuModel& gpu, std::span<const PassWork> passes, double budget_ms = 0);

/// Cycles at the core clock, whole chip, no efficiency applied. Exposed for tests and docs.
double rop_cycles(const GpuModel& gpu, const RopWork& work);
double resolve_cycles(const GpuModel& gpu, double pixels);
double milliseconds(const GpuModel& gpu, double cycles);
double memory_ms(const GpuModel& gpu, double bytes);
/// Texture traffic of a pass: texel_cyc * new_texels_per_cyc * texel_bytes * texel_share (docs/cost_model.md, texture
/// cache).
double texel_bytes(const GpuModel& gpu, const PassWork& work);

/// Fixed-width report, at most 100 columns, units on every number.
std::string format_budget(const FrameBudget& budget);

}  // namespace aluminate::console
