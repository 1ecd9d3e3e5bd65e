// Milliseconds from counted work: each unit by hand, the slowest unit, the sum, the verdict and what could
// flip it.
#include "platform/console/frame_budget.hpp"
#include "platform/console/occupancy.hpp"
#include "platform/console/platform_file.hpp"
#include "platform/host/error.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include <cmath>
#include <sstream>

namespace aluminate::test {
namespace {

using console::PassWork;
using console::Unit;

const console::GpuModel& xenos() {
  static const console::GpuModel gpu = console::load_platform("xenos");
  return gpu;
}

constexpr double kFramePixels = 1280.0 * 720.0;
// Sums of a few doubles: one part in 1e12 is many times their rounding.
void expect_close(double a, double b) { EXPECT_NEAR(a, b, 1e-12 * std::max(1.0, std::abs(b))); }

double peak(const PassWork& work, Unit unit) {
  return console::price_pass(xenos(), work).peak_ms[static_cast<std::size_t>(unit)];
}

TEST(FrameBudget, UnitCostsOfAFullFrameMatchTheTable) {
  PassWork word{.name = "word", .pixels = kFramePixels, .alu_words = kFramePixels};
  EXPECT_NEAR(peak(word, Unit::Alu), 0.0384, 5e-5);  // table prints four digits
  PassWork fetch{.name = "fetch", .pixels = kFramePixels, .fetches = kFramePixels, .fetch_cyc = kFramePixels};
  EXPECT_NEAR(peak(fetch, Unit::Texture), 0.1152, 5e-5);
  PassWork layer{.name = "layer", .rop = {{kFramePixels}}};
  EXPECT_NEAR(peak(layer, Unit::Rop), 0.2304, 5e-5);
  PassWork resolve{.name = "resolve", .resolve_pixels = kFramePixels};
  EXPECT_NEAR(peak(resolve, Unit::Resolve), 0.2304, 5e-5);
  PassWork copy{.name = "copy", .bytes = {{"colour", kFramePixels * 4}}};
  EXPECT_NEAR(peak(copy, Unit::Memory), 0.1646, 5e-5);
}

TEST(FrameBudget, PeakBudgetsOfA30HzFrameMatchTheTable) {
  const double frame_ms = 1000.0 / 30.0;
  EXPECT_EQ(std::round(frame_ms / peak({.name = "w", .alu_words = kFramePixels}, Unit::Alu)), 868);
  EXPECT_EQ(std::round(frame_ms / peak({.name = "f", .fetch_cyc = kFramePixels}, Unit::Texture)), 289);
  EXPECT_EQ(std::round(frame_ms / peak({.name = "r", .rop = {{kFramePixels}}}, Unit::Rop)), 145);
  EXPECT_EQ(std::round(frame_ms / peak({.name = "m", .bytes = {{"b", kFramePixels}}}, Unit::Memory)), 810);
}

TEST(FrameBudget, RopRatesFollowFormatBlendAndSamples) {
  const auto cycles = [](console::RopWork work) { return console::rop_cycles(xenos(), work); };
  using console::ColorFormat;
  const double pixels = 8000;
  EXPECT_EQ(cycles({pixels, ColorFormat::Bits32, false, 1, 1}), 1000);
  EXPECT_EQ(cycles({pixels, ColorFormat::Bits32, true, 1, 1}), 1000);   // blending is free at 32 bits
  EXPECT_EQ(cycles({pixels, ColorFormat::Bits32, true, 4, 1}), 1000);   // and so are four samples
  EXPECT_EQ(cycles({pixels, ColorFormat::Bits64, false, 1, 1}), 2000);  // 64 bits halve the rate
  EXPECT_EQ(cycles({pixels, ColorFormat::None, false, 1, 1}), 500);     // depth alone doubles it
  EXPECT_EQ(cycles({pixels, ColorFormat::None, false, 4, 1}), 500);
  EXPECT_EQ(cycles({pixels, ColorFormat::Bits32, false, 1, 3}), 3000);
}

TEST(FrameBudget, ThreadsFollowThePrintedSamples) {
  const std::pair<int, int> pixel[] = {{1, 63}, {2, 63}, {3, 63},  {5, 36},
                                       {6, 30}, {7, 27}, {14, 12}, {25, 6}};
  for (const auto& [gprs, threads] : pixel)
    EXPECT_EQ(console::threads_in_flight(xenos(), gprs, false), threads) << gprs;
  const std::pair<int, int> vertex[] = {{4, 31}, {9, 21}, {13, 12}};
  for (const auto& [gprs, threads] : vertex)
    EXPECT_EQ(console::threads_in_flight(xenos(), gprs, true), threads) << gprs;
}

TEST(FrameBudget, WavesOfTheLaterConsolesFollowTheirTable) {
  const console::GpuModel gpu = console::load_platform("liverpool");
  // vec4 registers = VGPRs / 4
  const std::pair<int, int> waves[] = {{6, 10}, {7, 9},  {8, 8},  {9, 7}, {10, 6},
                                       {12, 5}, {16, 4}, {21, 3}, {32, 2}};
  for (const auto& [gprs, count] : waves)
    EXPECT_EQ(console::threads_in_flight(gpu, gprs, false), count) << gprs;
}

TEST(FrameBudget, PassTakesItsSlowestUnitAndFrameTheSum) {
  PassWork alu{.name = "light", .alu_words = 100 * kFramePixels, .fetch_cyc = kFramePixels};
  PassWork fill{.name = "fill", .alu_words = kFramePixels, .rop = {{4 * kFramePixels}}};
  const std::vector<PassWork> passes = {alu, fill};
  const console::FrameBudget budget = console::price_frame(xenos(), passes);
  EXPECT_EQ(budget.passes[0].bound, Unit::Alu);
  EXPECT_EQ(budget.passes[1].bound, Unit::Rop);
  expect_close(budget.peak_ms, 100 * kFramePixels / 48 / 500000 + 4 * kFramePixels / 8 / 500000);
  expect_close(budget.derated_ms,
               100 * kFramePixels / 48 / 500000 / 0.95 + 4 * kFramePixels / 8 / 500000 / 0.9);
  expect_close(budget.budget_ms, 1000.0 / 30);
  EXPECT_TRUE(budget.fits);
  EXPECT_EQ(budget.verdict, console::Verdict::Fits);
  EXPECT_NE(budget.sentence.find("fits"), std::string::npos);
  EXPECT_NE(budget.passes[1].sentence.find("ROP"), std::string::npos);
}

TEST(FrameBudget, NothingCostsNothing) {
  const console::FrameBudget budget = console::price_frame(xenos(), {});
  EXPECT_EQ(budget.derated_ms, 0);
  EXPECT_TRUE(budget.fits);
}

TEST(FrameBudget, VertexWorkSharesUnifiedAlusAndRepeatsWithTiling) {
  PassWork once{.name = "geometry", .vertices = 64000, .vertex_words = 64000 * 48.0, .triangles = 1000};
  PassWork thrice = once;
  thrice.tiling_passes = 3;
  expect_close(peak(thrice, Unit::Alu), 3 * peak(once, Unit::Alu));
  expect_close(peak(thrice, Unit::Vertex), 3 * peak(once, Unit::Vertex));
  expect_close(peak(thrice, Unit::Setup), 3 * peak(once, Unit::Setup));
  expect_close(peak(once, Unit::Alu), 64000 / 500000.0);
  const console::GpuModel rsx = console::load_platform("rsx");
  EXPECT_EQ(console::price_pass(rsx, once).peak_ms[static_cast<std::size_t>(Unit::Alu)],
            0);  // own vertex pipes
}

TEST(FrameBudget, VerdictIsInconclusiveExactlyWhenAnUncertainFigureFlipsIt) {
  // Texture time alone: 0.8 of peak, said to be between 0.6 and 1.
  PassWork work{.name = "fetching", .fetch_cyc = kFramePixels * 200};
  const double at_peak = console::price_pass(xenos(), work).peak;
  const std::vector<PassWork> passes = {work};
  for (const auto& [budget_ms, verdict] : {std::pair{at_peak * 0.99, console::Verdict::Over},
                                           std::pair{at_peak * 1.1, console::Verdict::Inconclusive},
                                           std::pair{at_peak * 1.5, console::Verdict::Inconclusive},
                                           std::pair{at_peak * 1.7, console::Verdict::Fits}}) {
    const console::FrameBudget budget = console::price_frame(xenos(), passes, budget_ms);
    EXPECT_EQ(budget.verdict, verdict) << budget.sentence;
    ASSERT_EQ(budget.sensitivity.size(), 1u);  // no other uncertain figure moves this frame
    EXPECT_EQ(budget.sensitivity[0].figure, "texture.efficiency");
    expect_close(budget.sensitivity[0].ms_at_high, at_peak);
    expect_close(budget.sensitivity[0].ms_at_low, at_peak / 0.6);
  }
}

TEST(FrameBudget, TexelTrafficIsMemoryTimeAndUncertain) {
  // 1e9 cycles of covered pixels bring 1.35e9 texels of 4 bytes: 5.4e9 bytes over 22.4 GB/s, 241.07 ms at peak.
  const std::vector<PassWork> passes = {{.name = "cached", .fetch_cyc = 1e6, .texel_cyc = 1e9}};
  const console::FrameBudget budget = console::price_frame(xenos(), passes, 33.3);
  expect_close(budget.passes[0].memory_bytes, 5.4e9);
  expect_close(budget.passes[0].peak_ms[static_cast<std::size_t>(console::Unit::Memory)], 5.4e9 / 22.4e6);
  EXPECT_EQ(budget.passes[0].bound, console::Unit::Memory);
  const auto named = [&](const char* figure) {
    return std::any_of(budget.sensitivity.begin(), budget.sensitivity.end(),
                       [&](const auto& row) { return row.figure == figure; });
  };
  EXPECT_TRUE(named("texture.new_texels_per_cyc"));
  EXPECT_TRUE(named("texture.texel_bytes"));
}

TEST(FrameBudget, ImpossibleCountsAreABug) {
  const std::vector<PassWork> passes = {{.name = "bad", .alu_words = -1}};
  EXPECT_THROW(console::price_frame(xenos(), passes), InternalError);
}

TEST(FrameBudget, ReportFits100ColumnsAndCarriesUnits) {
  const std::vector<PassWork> passes = {{.name = "a pass with a long name indeed",
                                         .alu_words = 1e9,
                                         .fetch_cyc = 1e8,
                                         .vertices = 1e5,
                                         .triangles = 1e6,
                                         .resolve_pixels = 1e6,
                                         .rop = {{1e7}},
                                         .bytes = {{"all", 1e8}}}};
  const std::string text = console::format_budget(console::price_frame(xenos(), passes));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  EXPECT_NE(text.find(" ms derated"), std::string::npos);
  EXPECT_NE(text.find("confidence"), std::string::npos);
}

}  // namespace
}  // namespace aluminate::test
