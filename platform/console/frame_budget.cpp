#include "platform/console/frame_budget.hpp"

#include "platform/console/platform_file.hpp"
#include "platform/host/error.hpp"
#include "platform/host/text_table.hpp"

#include <algorithm>
#include <cmath>

namespace aluminate::console {
namespace {

constexpr std::size_t at(Unit unit) { return static_cast<std::size_t>(unit); }

void check_work(const PassWork& work) {
  const double counts[] = {work.pixels,       work.quads,     work.helper_lanes,   work.alu_words,
                           work.fetches,      work.fetch_cyc, work.texel_cyc,      work.vertices,
                           work.vertex_words, work.triangles, work.resolve_pixels, work.tiling_passes};
  for (double count : counts) {
    ALU_CHECK(std::isfinite(count) && count >= 0, "pass '{}' has a count of {}", work.name, count);
  }
  for (const RopWork& rop : work.rop)
    ALU_CHECK(rop.pixels >= 0 && rop.samples >= 1 && rop.targets >= 0, "pass '{}'", work.name);
  for (const ByteStream& stream : work.bytes)
    ALU_CHECK(stream.bytes >= 0, "stream '{}' has {} bytes", stream.name, stream.bytes);
}

Unit slowest(const std::array<double, kUnitCount>& ms) {
  return static_cast<Unit>(std::max_element(ms.begin(), ms.end()) - ms.begin());  // the first of equals
}

struct FrameTime {
  std::vector<PassTime> passes;
  double peak_ms = 0, derated_ms = 0;
};

FrameTime sum_passes(const GpuModel& gpu, std::span<const PassWork> passes) {
  FrameTime frame;
  for (const PassWork& work : passes) {
    frame.passes.push_back(price_pass(gpu, work));
    frame.peak_ms += frame.passes.back().peak;
    frame.derated_ms += frame.passes.back().derated;
  }
  return frame;
}

std::vector<SensitivityRow> sensitivity_of(const GpuModel& gpu, std::span<const PassWork> passes,
                                           double nominal_ms, double budget_ms) {
  std::vector<SensitivityRow> rows;
  GpuModel varied = gpu;
  for (const FigureField& field : figure_fields()) {
    Figure& figure = field.of(varied);
    if (!figure.present || !figure.has_range()) continue;
    SensitivityRow row{fmt::format("{}.{}", field.table, field.key),
                       figure.confidence,
                       figure.low,
                       figure.value,
                       figure.high,
                       0,
                       0,
                       false};
    figure.value = row.low;
    row.ms_at_low = sum_passes(varied, passes).derated_ms;
    figure.value = row.high;
    row.ms_at_high = sum_passes(varied, passes).derated_ms;
    figure.value = row.value;
    const bool nominal_fits = nominal_ms <= budget_ms;
    row.flips = (row.ms_at_low <= budget_ms) != nominal_fits || (row.ms_at_high <= budget_ms) != nominal_fits;
    if (row.ms_at_low != nominal_ms || row.ms_at_high != nominal_ms) rows.push_back(std::move(row));
  }
  std::stable_sort(rows.begin(), rows.end(), [](const SensitivityRow& a, const SensitivityRow& b) {
    return std::abs(a.ms_at_high - a.ms_at_low) > std::abs(b.ms_at_high - b.ms_at_low);
  });
  return rows;
}

}  // namespace

std::string_view unit_name(Unit unit) {
  constexpr std::string_view kNames[] = {"ALU", "texture", "vertex", "setup", "ROP", "memory", "resolve"};
  return kNames[at(unit)];
}

std::string_view unit_phrase(Unit unit) {
  constexpr std::string_view kPhrases[] = {"ALU", "texture units",    "vertex work",   "triangle set-up",
                                           "ROP", "memory bandwidth", "eDRAM resolves"};
  return kPhrases[at(unit)];
}

std::string_view verdict_word(Verdict verdict) {
  return verdict == Verdict::Fits ? "fits" : verdict == Verdict::Over ? "over" : "inconclusive";
}

double PassWork::total_bytes() const {
  double sum = 0;
  for (const ByteStream& stream : bytes) sum += stream.bytes;
  return sum;
}

double milliseconds(const GpuModel& gpu, double cycles) {
  return cycles / (gpu.clock.core_mhz.value * 1000.0);
}

double memory_ms(const GpuModel& gpu, double bytes) { return bytes / (gpu.memory.bandwidth_gbs.value * 1e6); }

double texel_bytes(const GpuModel& gpu, const PassWork& work) {
  return work.texel_cyc * gpu.texture.new_texels_per_cyc.value * gpu.texture.texel_bytes.value *
         work.texel_share;
}

double rop_cycles(const GpuModel& gpu, const RopWork& work) {
  const bool depth_only = work.format == ColorFormat::None;
  const double rate = depth_only ? gpu.rop.z_only_rate.value : 1.0;
  const double pixel_cycles = work.pixels / (gpu.rop.pixels_per_clk.value * rate);
  const double sample_cycles = work.pixels * work.samples / (gpu.rop.samples_per_clk.value * rate);
  const double base = std::max(pixel_cycles, sample_cycles);
  if (depth_only) return base;
  const bool wide = work.format == ColorFormat::Bits64;
  const double format = wide ? gpu.rop.format_64bit.value : 1.0;
  const double blend = !work.blend ? 1.0 : wide ? gpu.rop.blend_cyc_64bit.value : gpu.rop.blend_cyc.value;
  return base * format * blend * std::max(1, work.targets);
}

double resolve_cycles(const GpuModel& gpu, double pixels) {
  return gpu.has_edram() ? pixels / gpu.edram.resolve_px_per_clk.value : 0.0;
}

PassTime price_pass(const GpuModel& gpu, const PassWork& work) {
  check_work(work);
  const bool unified = gpu.vertex.unified.value != 0;
  const double vertex_words = work.vertex_words * work.tiling_passes;
  const double vertex_word_clk = vertex_words / gpu.vertex.lanes_per_clk.value;
  const double vertex_fetch_clk =
      work.vertices * work.tiling_passes * gpu.vertex.fetch_clk_per_64.value / 64.0;

  PassTime time;
  time.name = work.name;
  auto& peak = time.peak_ms;
  // On a unified machine vertex and pixel words queue for the same lanes, so their times add.
  peak[at(Unit::Alu)] =
      milliseconds(gpu, work.alu_words / gpu.alu.lanes_per_clk.value + (unified ? vertex_word_clk : 0.0));
  peak[at(Unit::Texture)] = milliseconds(gpu, work.fetch_cyc / gpu.texture.bilinear_per_clk.value);
  peak[at(Unit::Vertex)] =
      milliseconds(gpu, unified ? vertex_fetch_clk : std::max(vertex_word_clk, vertex_fetch_clk));
  peak[at(Unit::Setup)] =
      milliseconds(gpu, work.triangles * work.tiling_passes / gpu.setup.triangles_per_clk.value);
  double rop = 0;
  for (const RopWork& entry : work.rop) rop += rop_cycles(gpu, entry);
  peak[at(Unit::Rop)] = milliseconds(gpu, rop);
  time.memory_bytes = work.total_bytes() + texel_bytes(gpu, work);
  peak[at(Unit::Memory)] = memory_ms(gpu, time.memory_bytes);
  peak[at(Unit::Resolve)] = milliseconds(gpu, resolve_cycles(gpu, work.resolve_pixels));

  // Set-up is a fixed-function rate quoted as reached; it has no derating.
  const double efficiency[kUnitCount] = {
      gpu.alu.efficiency.value, gpu.texture.efficiency.value, gpu.vertex.efficiency.value, 1.0,
      gpu.rop.efficiency.value, gpu.memory.efficiency.value,  gpu.rop.efficiency.value};
  for (std::size_t unit = 0; unit < kUnitCount; ++unit) time.derated_ms[unit] = peak[unit] / efficiency[unit];
  time.bound = slowest(time.derated_ms);
  time.peak = peak[at(slowest(peak))];
  time.derated = time.derated_ms[at(time.bound)];

  if (time.derated <= 0) {
    time.sentence = "no work";
    return time;
  }
  auto others = time.derated_ms;
  others[at(time.bound)] = -1;
  const Unit next = slowest(others);
  time.sentence = fmt::format("bound by {}: {:.3f} ms derated; next {} at {:.0f} %", unit_phrase(time.bound),
                              time.derated, unit_phrase(next), 100.0 * others[at(next)] / time.derated);
  return time;
}

FrameBudget price_frame(const GpuModel& gpu, std::span<const PassWork> passes, double budget_ms) {
  FrameBudget budget;
  budget.platform = gpu.id;
  budget.budget_ms = budget_ms > 0 ? budget_ms : 1000.0 / gpu.target.rate_hz.value;
  FrameTime frame = sum_passes(gpu, passes);
  budget.passes = std::move(frame.passes);
  budget.peak_ms = frame.peak_ms;
  budget.derated_ms = frame.derated_ms;
  budget.fits_peak = budget.peak_ms <= budget.budget_ms;
  budget.fits = budget.derated_ms <= budget.budget_ms;
  budget.sensitivity = sensitivity_of(gpu, passes, budget.derated_ms, budget.budget_ms);

  std::array<double, kUnitCount> by_bound{};
  for (const PassTime& pass : budget.passes) by_bound[at(pass.bound)] += pass.derated;
  budget.bound = slowest(by_bound);

  const bool flips = std::any_of(budget.sensitivity.begin(), budget.sensitivity.end(),
                                 [](const auto& row) { return row.flips; });
  budget.verdict = flips ? Verdict::Inconclusive : budget.fits ? Verdict::Fits : Verdict::Over;
  const double gap = budget.budget_ms - budget.derated_ms;
  budget.sentence = fmt::format("{}: {:.2f} ms of {:.2f} ms ({:.2f} ms {}), mostly bound by {}",
                                verdict_word(budget.verdict), budget.derated_ms, budget.budget_ms,
                                std::abs(gap), gap >= 0 ? "left" : "too much",
                                budget.derated_ms > 0 ? unit_phrase(budget.bound) : "nothing");
  if (flips) {
    const auto row = std::find_if(budget.sensitivity.begin(), budget.sensitivity.end(),
                                  [](const auto& r) { return r.flips; });
    budget.sentence += fmt::format("; depends on {} ({})", row->figure, confidence_word(row->confidence));
  }
  return budget;
}

std::string format_budget(const FrameBudget& budget) {
  using host::Align;
  std::vector<host::TableColumn> columns = {{"pass"}};
  for (int unit = 0; unit < kUnitCount; ++unit)
    columns.push_back({std::string(unit_name(static_cast<Unit>(unit))), Align::Right});
  columns.push_back({"ms", Align::Right});
  columns.push_back({"peak ms", Align::Right});
  columns.push_back({"bound"});
  host::TextTable table(std::move(columns));
  for (const PassTime& pass : budget.passes) {
    std::vector<std::string> cells = {pass.name.size() > 16 ? pass.name.substr(0, 16) : pass.name};
    for (double ms : pass.derated_ms) cells.push_back(ms > 0 ? fmt::format("{:.3f}", ms) : "-");
    cells.push_back(fmt::format("{:.3f}", pass.derated));
    cells.push_back(fmt::format("{:.3f}", pass.peak));
    cells.emplace_back(unit_name(pass.bound));
    table.add_row(std::move(cells));
  }
  std::string text = table.text();
  text += fmt::format("\nframe  {:.3f} ms derated, {:.3f} ms at peak rates; budget {:.2f} ms ({})\n{}\n",
                      budget.derated_ms, budget.peak_ms, budget.budget_ms, budget.platform, budget.sentence);
  text +=
      "unit columns: ms at the derated rate; a pass costs its slowest unit, the frame the sum of its "
      "passes\n";
  if (!budget.sensitivity.empty()) {
    host::TextTable rows({{"uncertain figure"},
                          {"confidence"},
                          {"range", Align::Right},
                          {"frame ms", Align::Right},
                          {"verdict"}});
    for (const SensitivityRow& row : budget.sensitivity) {
      rows.add_row({row.figure, std::string(confidence_word(row.confidence)),
                    fmt::format("{} .. {}", row.low, row.high),
                    fmt::format("{:.3f} .. {:.3f}", row.ms_at_low, row.ms_at_high),
                    row.flips ? "FLIPS" : "same"});
    }
    text += "\n" + rows.text();
  }
  return text;
}

}  // namespace aluminate::console
