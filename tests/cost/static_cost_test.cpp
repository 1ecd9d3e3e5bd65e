// What price() promises beyond the five anchors: the estimate's formulas, per-block and per-line sums, paths,
// lights, refusals, and the other consoles' models.
#include "shading/cost/static_cost.hpp"
#include "platform/console/platform_file.hpp"
#include "platform/host/error.hpp"
#include "shading/cost/slots.hpp"
#include "tests/cost/program_builder.hpp"
#include "tests/cost/random_program.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace aluminate::test {
namespace {

const console::GpuModel& xenos() {
  static const console::GpuModel gpu = console::load_platform("xenos");
  return gpu;
}

/// n dependent multiply-adds: exactly n words under any pairing rule.
vm::Program chain(int n) {
  std::string text = "in TEXCOORD0 xyzw\nout COLOR0 xyzw\nuniform a 4\nmov r0, v0\n";
  for (int i = 0; i < n; ++i) text += i + 1 == n ? "mad o0, r0, c0, v0\n" : "mad r0, r0, c0, v0\n";
  return program_from_text(text);
}

TEST(Estimate, AluClocksOfThePrintedSamples) {
  // Instructions and cycles as the period compiler printed them, two decimals.
  const std::pair<int, double> printed[] = {{6, 8.00},   {9, 12.00},  {17, 22.67},  {28, 37.33},
                                            {55, 73.33}, {74, 98.67}, {178, 237.33}};
  for (const auto& [words, clocks] : printed) {
    const cost::StaticCost cost = cost::price(chain(words), xenos());
    EXPECT_EQ(cost.alu_words, words);
    EXPECT_EQ(std::round(cost.cycles.alu * 100) / 100, clocks);
  }
}

TEST(Estimate, TextureClocksAreFourForEachFetch) {
  for (int n : {1, 2, 3, 13}) {
    std::string text = "in TEXCOORD0 xy\nout COLOR0 xyzw\nsampler s 2d\nsampler c cube\nmov r1, v0.xyxy\n";
    for (int i = 0; i < n; ++i) text += "tex r0, v0.xy, s0\nadd r1, r1, r0\n";
    text += "mov o0, r1\n";
    const cost::StaticCost cost = cost::price(program_from_text(text), xenos());
    EXPECT_EQ(cost.fetches, n);
    EXPECT_EQ(cost.cycles.texture, 4 * n);
    const cost::StaticCost trilinear = cost::price(
        program_from_text(text), xenos(), {cost::FilterAssumption::Trilinear, cost::PairingRule::Strict});
    EXPECT_EQ(trilinear.cycles.texture, 8 * n);
  }
}

TEST(Estimate, InterpolatorClocksOfThePrintedSamples) {
  const std::pair<const char*, double> printed[] = {{"T", 8},       {"TT", 8},  {"TTT", 12}, {"TTTTT", 20},
                                                    {"TTTTTT", 24}, {"CT", 16}, {"CTT", 16}};
  for (const auto& [inputs, clocks] : printed) {
    std::string text, sum;
    int v = 0;
    for (const char* input = inputs; *input != '\0'; ++input, ++v) {
      text += std::string("in ") + (*input == 'C' ? "COLOR" : "TEXCOORD") + std::to_string(v) + " xyzw\n";
      sum += "add r0, r0, v" + std::to_string(v) + "\n";
    }
    text += "out COLOR0 xyzw\nmov r0, v0\n" + sum + "mov o0, r0\n";
    EXPECT_EQ(cost::price(program_from_text(text), xenos()).cycles.interpolator, clocks) << inputs;
  }
}

TEST(Estimate, SixIssuesFillAClauseAndEachCostsTwoClocks) {
  for (int words : {1, 6, 7, 12, 13}) {
    const cost::StaticCost cost = cost::price(chain(words), xenos());
    EXPECT_EQ(cost.exec_clauses, (words + 5) / 6);
    EXPECT_EQ(cost.cycles.sequencer, 2 * cost.exec_clauses + 2);
  }
}

TEST(Slots, FollowThePublishedTable) {
  const vm::Program program = program_from_text(R"(
in TEXCOORD0 xyzw
out COLOR0 xyzw
sampler a 2d
sampler b cube
tex r0, v0, s0
tex r1, v0, s1
texlod r2, v0, s0
texlod r3, v0, s1
texbias r4, v0, s0
texgrad r5, v0, v0, v0, s0
dp2add r0.x, r0, r1, r2.x
sqrt r0.y, r3.x
sin r0.z, r4.x
add o0, r0, r5
)");
  const cost::StaticCost cost = cost::price(program, xenos());
  EXPECT_EQ(cost.tex_slots, 1 + 4 + 2 + 5 + 6 + 3);
  EXPECT_EQ(cost.alu_slots, 2 + 2 + 8 + 1);
  EXPECT_EQ(cost.fetches, 6);
}

TEST(StaticCost, SumsOfBlocksAndLinesAreTheTotals) {
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    RandomShape shape;
    shape.instructions = 5 + static_cast<int>(seed % 40);
    shape.flow = seed % 2 == 0;
    const vm::Program program = random_program(seed, shape);
    const cost::StaticCost cost = cost::price(program, xenos());
    double block_words = 0, line_words = 0;
    int block_slots = 0, line_slots = 0, block_fetches = 0, line_fetches = 0, code_slots = 0;
    const std::vector<vm::Block> blocks = vm::find_blocks(program);
    ASSERT_EQ(cost.blocks.size(), blocks.size());
    const std::vector<int> slots = cost::instruction_slots(program);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const int trips = static_cast<int>(std::max(1u, blocks[b].static_trips));
      block_words += trips * cost.blocks[b].alu_words;
      block_slots += trips * cost.blocks[b].alu_slots;
      block_fetches += trips * cost.blocks[b].fetches;
      for (std::uint32_t i = blocks[b].begin; i < blocks[b].end; ++i)
        code_slots += trips * slots[i];
    }
    for (const cost::LineCost& line : cost.lines) {
      line_words += line.alu_words;
      line_slots += line.alu_slots;
      line_fetches += line.fetches;
    }
    EXPECT_EQ(block_words, cost.alu_words);
    EXPECT_EQ(line_words, cost.alu_words) << "seed " << seed;
    EXPECT_EQ(block_slots, cost.alu_slots);
    EXPECT_EQ(code_slots, cost.alu_slots);
    EXPECT_EQ(line_slots, cost.alu_slots);
    EXPECT_EQ(block_fetches, cost.fetches);
    EXPECT_EQ(line_fetches, cost.fetches);
    EXPECT_LE(cost.shortest_words, cost.longest_words);
    EXPECT_LE(cost.shortest.worst(), cost.longest.worst());
  }
}

TEST(StaticCost, LoosePairingIsNeverMuchLonger) {
  double strict = 0, loose = 0;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    const vm::Program program = random_program(seed, {});
    strict += cost::price(program, xenos()).alu_words;
    loose +=
        cost::price(program, xenos(), {cost::FilterAssumption::Bilinear, cost::PairingRule::Loose}).alu_words;
  }
  EXPECT_LT(loose, strict);
}

const char* const kBranch = R"(
in TEXCOORD0 xyzw
out COLOR0 xyzw
uniform a 4
mov r0, v0
if c0.x
mad r0, r0, c0, v0
mad r0, r0, c0, v0
mad r0, r0, c0, v0
else
mad r0, r0, c0, v0
endif
mul o0, r0, r0
)";

TEST(StaticCost, BranchesArePricedAtBothEnds) {
  const cost::StaticCost cost = cost::price(program_from_text(kBranch), xenos());
  EXPECT_FALSE(cost.straight_line);
  // A copy into the register that crosses the branch and the predicate stand before it, the product after it.
  EXPECT_EQ(cost.longest_words - cost.shortest_words, 2);
  EXPECT_EQ(cost.alu_words, cost.longest_words + 1);
  EXPECT_EQ(cost.cycles.alu, cost.longest.alu);
}

TEST(StaticCost, LoopsMultiplyAndUnknownOnesAreSaid) {
  const char* const counted = R"(
in TEXCOORD0 xyzw
out COLOR0 xyzw
uniform a 4
mov r0, v0
loop 5
mad r0, r0, c0, v0
endloop
mul o0, r0, r0
)";
  const cost::StaticCost five = cost::price(program_from_text(counted), xenos());
  EXPECT_TRUE(five.straight_line);
  EXPECT_EQ(five.shortest_words, five.longest_words);
  EXPECT_EQ(five.alu_words, 1 + 5 + 1);
  std::string text = counted;
  text.replace(text.find("loop 5"), 6, "loop -1");
  text.replace(text.find("endloop"), 7, "break r0.x\nendloop");
  const cost::StaticCost open = cost::price(program_from_text(text), xenos());
  EXPECT_FALSE(open.paths_known);
  EXPECT_FALSE(open.straight_line);
}

TEST(StaticCost, LightsArePricedRolledAndUnrolled) {
  std::string rolled = "in TEXCOORD0 xyzw\nout COLOR0 xyzw\nuniform a 4\nmov r0, v0\nloop 4\n";
  const std::string body = "mad r0, r0, c0, v0\nrcp r1.x, r0.x\nmul r0.y, r0.z, r1.x\n";
  const vm::Program program = program_from_text(rolled + body + "endloop\nmul o0, r0, r0\n");
  const cost::LightCost light = cost::loop_body_light(program, cost::price(program, xenos()));
  EXPECT_EQ(light.alu_slots, 3);
  EXPECT_EQ(light.convention, "rolled loop, ps_3_0 slots, nothing hoisted");
  const auto unrolled = [&](int n) {
    std::string text = "in TEXCOORD0 xyzw\nout COLOR0 xyzw\nuniform a 4\nmov r0, v0\n";
    for (int i = 0; i < n; ++i) text += body;
    return cost::price(program_from_text(text + "mul o0, r0, r0\n"), xenos());
  };
  const cost::LightCost marginal = cost::marginal_light(unrolled(3), unrolled(4));
  EXPECT_EQ(marginal.alu_slots, 3);
  EXPECT_EQ(marginal.convention, "unrolled, hoisted");
  EXPECT_THROW(cost::loop_body_light(chain(3), cost::price(chain(3), xenos())), UserError);
}

TEST(StaticCost, TooManyRegistersAreRefusedByName) {
  std::string text = "in TEXCOORD0 xyzw\nout COLOR0 xyzw\nuniform a 4\nsampler s 2d\n";
  for (int i = 0; i < 70; ++i)
    text += "mad r" + std::to_string(i) + ", v0, c0, v0.wzyx\nexp r" + std::to_string(i) + ".x, r" +
            std::to_string(i) + ".y\n";
  // Read last-made first and first-made last, each after all are made.
  text += "mov r70, r69\n";
  for (int i = 0; i < 70; ++i)
    text += "mad r70, r70, r" + std::to_string(i) + ", r" + std::to_string(69 - i) + "\n";
  text += "dsx r71, r70\n";
  for (int i = 0; i < 70; ++i)
    text += "mad r71, r71, r" + std::to_string(i) + ", r" + std::to_string(69 - i) + "\n";
  text += "mov o0, r71\n";
  try {
    const cost::StaticCost cost = cost::price(program_from_text(text, "greedy"), xenos());
    FAIL() << cost.gprs;
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("greedy"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("64"), std::string::npos);
  }
}

TEST(OtherConsoles, CountsFollowTheirWidth) {
  // One vec4 multiply-add, one reciprocal, one vec3 product, in a chain.
  const vm::Program program = program_from_text(R"(
in TEXCOORD0 xyzw
out COLOR0 xyz
uniform a 4
sampler s 2d
tex r0, v0.xy, s0
mad r1, r0, c0, v0
rcp r2.x, r1.w
mul o0.xyz, r1, r2.x
)");
  EXPECT_EQ(cost::price(program, console::load_platform("liverpool")).alu_words,
            4 + 4 + 3);  // lanes; reciprocal at quarter rate
  EXPECT_EQ(cost::price(program, console::load_platform("latte")).alu_words, 3);
  // SU0 fetches, SU1 multiplies and adds; next pass SU0 the reciprocal, SU1 the product.
  EXPECT_EQ(cost::price(program, console::load_platform("rsx")).alu_words, 2);
  // Word 1: fetch, mul, add, and the combiner makes the reciprocal; word 2 the product.
  EXPECT_EQ(cost::price(program, console::load_platform("mali-400")).alu_words, 2);
}

TEST(OtherConsoles, EveryModelPricesRandomProgramsAboveItsBound) {
  for (const char* platform : {"rsx", "latte", "durango", "liverpool", "mali-400"}) {
    console::GpuModel gpu = console::load_platform(platform);
    gpu.registers.per_thread_max.value = 4096;  // registers are not the question here
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
      const cost::StaticCost cost = cost::price(random_program(seed, {}), gpu);
      EXPECT_GE(cost.alu_words, cost.bound_words) << platform << " seed " << seed;
      EXPECT_GT(cost.alu_words, 0);
    }
  }
}

}  // namespace
}  // namespace aluminate::test
