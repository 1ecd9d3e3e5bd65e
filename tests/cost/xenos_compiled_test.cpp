// The public shaders of xenos_anchor_test, from their HLSL through the compiler, against the table of printed
// and decoded figures; and what the shipped lighting program's schedules leave over their bounds.
#include "platform/console/platform_file.hpp"
#include "shading/compiler/compile.hpp"
#include "shading/cost/legality.hpp"
#include "shading/cost/listing.hpp"
#include "shading/cost/static_cost.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

namespace aluminate::test {
namespace {

using Row = std::map<std::string, std::string>;

std::vector<Row> read_table(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> keys;
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells(1);
    for (char c : line) {
      if (c == ',')
        cells.emplace_back();
      else if (c != '\r')
        cells.back() += c;
    }
    if (keys.empty()) {
      keys = cells;
      continue;
    }
    Row row;
    for (std::size_t i = 0; i < keys.size() && i < cells.size(); ++i) row[keys[i]] = cells[i];
    rows.push_back(row);
  }
  return rows;
}

const std::string kShared = std::string(ALUMINATE_SHARED_DIR) + "/xenos/";

TEST(XenosCompiled, MatchesThePrintedAndDecodedFigures) {
  if (!std::filesystem::exists(kShared + "expected.csv")) GTEST_SKIP() << "public figures not present";
  const console::GpuModel xenos = console::load_platform("xenos");
  for (const Row& row : read_table(kShared + "expected.csv")) {
    const std::string name = row.at("name");
    compiler::Options options;
    options.source_path = kShared + name + ".hlsl";
    const vm::Program program = compiler::compile(options);
    const cost::StaticCost cost = cost::price(program, xenos);
    SCOPED_TRACE(name + "\n" + cost::format_listing(cost));
    const double words = std::stod(row.at("xenos_alu_instructions"));
    EXPECT_LE(std::abs(cost.alu_words - words), std::max(1.0, 0.1 * words))
        << cost.alu_words << " words, console " << words;
    EXPECT_EQ(cost.fetches, std::stoi(row.at("texture_cycles")) / 4);
    EXPECT_EQ(cost.cycles.texture, std::stod(row.at("texture_cycles")));
    EXPECT_EQ(cost.cycles.sequencer, std::stod(row.at("sequencer_cycles")));
    if (!row.at("interpolator_cycles").empty()) {
      EXPECT_EQ(cost.cycles.interpolator, std::stod(row.at("interpolator_cycles")));
    }
    EXPECT_LE(std::abs(cost.gprs - std::stoi(row.at("gprs"))), 2);
    if (cost.gprs == std::stoi(row.at("gprs"))) {
      EXPECT_EQ(cost.threads, std::stoi(row.at("threads")));
    }
    if (!row.at("cycles_per_vector").empty()) {
      EXPECT_EQ(cost.cycles_per_vector, std::stoi(row.at("cycles_per_vector")));
    }
    EXPECT_TRUE(cost::broken_rules(program, cost::schedule_program(program, cost::PairingRule::Strict),
                                   cost::PairingRule::Strict)
                    .empty());
  }
}

// if_lt compares two operands itself: the comparison in front of a branch takes no slots of its own, unless
// its value is read again.
TEST(XenosCompiled, AComparisonInFrontOfABranchIsTheBranchs) {
  const auto priced = [](const std::string& condition, const std::string& result) {
    compiler::Options options;
    options.source_path = "branch.hlsl";
    options.source =
        "sampler2D t; float4 k;\nfloat4 main(float4 c : TEXCOORD0) : COLOR0 {\n  float4 r = c;\n" +
        condition +
        "\n  [branch] if (on) { r = tex2Dlod(t, float4(c.xy, 0, 0)) * k + r.wzyx; r = r * r + k; }\n  "
        "return " +
        result + ";\n}\n";
    return cost::price(compiler::compile(options), console::load_platform("xenos"));
  };
  const cost::StaticCost branch = priced("  bool on = c.z < k.x;", "r");
  int shown = 0;
  for (const cost::ListingRow& row : branch.listing) shown += row.alu_slots;
  EXPECT_LE(shown, branch.alu_slots);
  EXPECT_FALSE(branch.straight_line) << "the branch must survive for this test to mean anything";
  const cost::StaticCost read_again = priced("  bool on = c.z < k.x;", "r + (on ? 1.0 : 0.0)");
  EXPECT_GT(read_again.alu_slots, branch.alu_slots);
}

TEST(XenosCompiled, LightingSchedulesAreWithinFivePerCentOfTheirBounds) {
  const console::GpuModel xenos = console::load_platform("xenos");
  double words = 0, bound = 0;
  for (const char* visibility : {"0", "1"}) {
    for (const char* lights : {"1", "2", "4", "8"}) {
      compiler::Options options;
      options.source_path = std::string(ALUMINATE_SOURCE_DIR) + "/tests/cost/lights.hlsl";
      options.defines = {{"LIGHTS", lights}, {"SCHLICK_SMITH", visibility}};
      options.loops = compiler::LoopMode::Unrolled;
      const vm::Program program = compiler::compile(options);
      const cost::StaticCost cost = cost::price(program, xenos);
      std::cout << "lights " << lights << " schlick-smith " << visibility << ": " << cost.alu_words
                << " words, bound " << cost.bound_words << ", slots " << cost.alu_slots << ", " << cost.gprs
                << " GPRs\n";
      words += cost.alu_words;
      bound += cost.bound_words;
    }
  }
  EXPECT_LE(words, 1.05 * bound);
}

}  // namespace
}  // namespace aluminate::test
