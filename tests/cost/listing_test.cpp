// The printed forms: documented keys, units and conventions beside the figures, 100 columns.
#include "shading/cost/listing.hpp"
#include "platform/console/platform_file.hpp"
#include "platform/host/error.hpp"
#include "tests/cost/program_builder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sstream>

namespace aluminate::test {
namespace {

const char* const kLit = R"(
in TEXCOORD0 xy
in TEXCOORD1 xyz
out COLOR0 xyzw
uniform light 3
sampler albedo_with_a_rather_long_name 2d
lit 1 0 0 0
tex r0, v0.xy, s0
dp3 r1.x, v1, v1
rsq r1.x, r1.x
mul r2.xyz, v1, r1.x
dp3_sat r1.y, r2, c0
if r1.y
mul r0.xyz, r0, r1.y
endif
mov o0.xyz, r0
mov o0.w, l0.x
)";

cost::StaticCost lit_cost(const char* platform = "xenos") {
  cost::StaticCost cost = cost::price(program_from_text(kLit, "lit"), console::load_platform(platform));
  cost.per_light = {"rolled", "rolled loop, ps_3_0 slots, nothing hoisted", 27, 36, 0};
  return cost;
}

TEST(CostFormats, JsonHasTheDocumentedKeysInOrder) {
  const auto document = nlohmann::ordered_json::parse(cost::format_cost({lit_cost()}, cost::Format::Json));
  const auto& program = document.at("programs").at(0);
  const std::vector<std::string> documented = {
      "name",      "platform",      "alu_words", "alu_slots", "vector_ops", "scalar_ops", "fetches",
      "fetch_cyc", "interpolators", "gprs",      "threads",   "cycles",     "bound",      "per_light"};
  std::size_t i = 0;
  for (const auto& [key, value] : program.items()) {
    if (i < documented.size()) {
      EXPECT_EQ(key, documented[i]);
    }
    ++i;
  }
  EXPECT_GE(i, documented.size());
  std::vector<std::string> units;
  for (const auto& [key, value] : program.at("cycles").items()) units.push_back(key);
  EXPECT_EQ(units, (std::vector<std::string>{"alu", "texture", "vertex", "sequencer", "interpolator"}));
  EXPECT_EQ(program.at("per_light").at("alu_slots"), 36);
  EXPECT_EQ(program.at("per_light").at("loop"), "rolled");
}

TEST(CostFormats, NoTextLineIsWiderThan100Columns) {
  for (const char* platform : {"xenos", "rsx", "liverpool", "mali-400", "latte"}) {
    const cost::StaticCost cost = lit_cost(platform);
    for (cost::Format format : {cost::Format::Text, cost::Format::Fxc360}) {
      std::istringstream lines(cost::format_cost({cost, cost}, format) + cost::format_listing(cost, format));
      for (std::string line; std::getline(lines, line);) {
        EXPECT_LE(line.size(), 100u) << line;
        EXPECT_FALSE(line.ends_with(' ')) << line;
      }
    }
  }
}

TEST(CostFormats, ConventionStandsBesideTheFigure) {
  const std::string text = cost::format_cost({lit_cost()}, cost::Format::Text);
  for (const char* phrase : {"clocks for 64 pixels", "ps_3_0 slots", "vec4+scalar word",
                             "rolled loop, ps_3_0 slots, nothing hoisted", "bilinear"}) {
    EXPECT_NE(text.find(phrase), std::string::npos) << phrase << "\n" << text;
  }
}

TEST(CostFormats, PeriodCommentHasItsShape) {
  const std::string text = cost::format_cost({lit_cost()}, cost::Format::Fxc360);
  for (const char* phrase :
       {"Shader Timing Estimate, in Cycles/64 pixel vector:", "// ALU: ",
        " instructions), vertex: 0, texture: 4,", "Performance (if enough threads): ~", "threads,"}) {
    EXPECT_NE(text.find(phrase), std::string::npos) << phrase << "\n" << text;
  }
}

TEST(CostFormats, TsvHasOneRowForEachProgramAndEqualColumns) {
  std::istringstream lines(cost::format_cost({lit_cost(), lit_cost("rsx")}, cost::Format::Tsv));
  std::vector<std::size_t> tabs;
  for (std::string line; std::getline(lines, line);)
    tabs.push_back(static_cast<std::size_t>(std::count(line.begin(), line.end(), '\t')));
  ASSERT_EQ(tabs.size(), 3u);
  EXPECT_EQ(tabs[0], tabs[1]);
  EXPECT_EQ(tabs[0], tabs[2]);
}

TEST(CostFormats, UnknownFormatIsRefusedWithTheNearestName) {
  try {
    cost::parse_format("jsn");
    FAIL();
  } catch (const UserError& error) {
    EXPECT_NE(error.hint().find("json"), std::string::npos);
  }
}

TEST(CostFormats, ListingShowsEveryWordOnce) {
  const cost::StaticCost cost = lit_cost();
  const std::string text = cost::format_listing(cost);
  double words = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    std::string first, second;
    fields >> first >> second;
    words += (second == "V" || second == "S") && first != "+";
  }
  EXPECT_EQ(words, cost.alu_words) << text;
}

}  // namespace
}  // namespace aluminate::test
