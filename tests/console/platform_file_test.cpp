// Platform files: what ships is complete and sourced; what a user writes wrongly is refused where it stands.
#include "platform/console/platform_file.hpp"
#include "platform/host/error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

namespace aluminate::test {
namespace {

using console::FigureField;
using console::GpuModel;

TEST(PlatformFiles, EachLoadsUnderItsOwnNameAndIsSourced) {
  std::set<std::string> ids;
  for (const console::PlatformEntry& entry : console::builtin_platforms()) {
    GpuModel gpu = console::load_platform(std::string(entry.id));
    EXPECT_EQ(gpu.id, entry.id);
    ids.insert(gpu.id);
    for (const FigureField& field : console::figure_fields()) {
      const console::Figure& figure = field.of(gpu);
      if (field.optional_table && !figure.present) continue;
      EXPECT_TRUE(figure.present) << gpu.id << " " << field.table << "." << field.key;
      EXPECT_FALSE(figure.source.empty()) << gpu.id << " " << field.table << "." << field.key;
      EXPECT_LE(figure.low, figure.value);
      EXPECT_GE(figure.high, figure.value);
      EXPECT_FALSE(figure.confidence == console::Confidence::Doc && figure.has_range());
    }
  }
  for (const char* id : {"xenos", "rsx", "rsx-announced", "latte", "durango", "liverpool", "mali-400"})
    EXPECT_TRUE(ids.contains(id)) << id;
}

TEST(PlatformFiles, EverySourceKeyIsInTheReferences) {
  std::ifstream file(std::string(ALUMINATE_SOURCE_DIR) + "/docs/references.md");
  std::stringstream text;
  text << file.rdbuf();
  for (const console::PlatformEntry& entry : console::builtin_platforms()) {
    GpuModel gpu = console::load_platform(std::string(entry.id));
    for (const FigureField& field : console::figure_fields()) {
      const console::Figure& figure = field.of(gpu);
      if (!figure.present) continue;
      EXPECT_NE(text.str().find("[" + figure.source + "]"), std::string::npos)
          << gpu.id << " " << field.table << "." << field.key << ": " << figure.source;
    }
  }
}

TEST(PlatformFiles, DocumentShowsThemAsTheyAre) {
  std::ifstream file(std::string(ALUMINATE_SOURCE_DIR) + "/docs/cost_model.md");
  std::stringstream text;
  text << file.rdbuf();
  for (const console::PlatformEntry& entry : console::builtin_platforms()) {
    const std::string table = console::format_platform(console::load_platform(std::string(entry.id)));
    EXPECT_NE(text.str().find(table), std::string::npos)
        << "docs/cost_model.md section 7, " << entry.id << " must read:\n"
        << table;
  }
  for (const FigureField& field : console::figure_fields()) {
    EXPECT_NE(text.str().find("`" + std::string(field.table) + "." + std::string(field.key) + "`"),
              std::string::npos)
        << field.key;
  }
}

TEST(PlatformFiles, ClocksAreTheSystemReportedOnes) {
  EXPECT_EQ(console::load_platform("rsx").clock.core_mhz.value, 500);
  EXPECT_EQ(console::load_platform("rsx").memory.bandwidth_gbs.value, 20.8);
  EXPECT_EQ(console::load_platform("rsx-announced").clock.core_mhz.value, 550);
  EXPECT_EQ(console::load_platform("xenos").clock.core_mhz.value, 500);
}

TEST(PlatformFiles, TablePrintsEveryFigureWithin100Columns) {
  for (const console::PlatformEntry& entry : console::builtin_platforms()) {
    const std::string text = console::format_platform(console::load_platform(std::string(entry.id)));
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
    for (const FigureField& field : console::figure_fields()) {
      if (field.optional_table) continue;
      EXPECT_NE(text.find(std::string(field.table) + "." + std::string(field.key)), std::string::npos);
    }
  }
}

std::string xenos_text() {
  for (const console::PlatformEntry& entry : console::builtin_platforms()) {
    if (entry.id == "xenos") return std::string(entry.text);
  }
  return "";
}

/// Line (from 1) of the first occurrence of `text`.
int line_of(const std::string& file, const std::string& text) {
  const auto at = file.find(text);
  return at == std::string::npos
             ? -1
             : 1 + static_cast<int>(
                       std::count(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
}

/// The line of a figure in xenos.toml: from its key, within its table, to the end of the line.
std::pair<std::size_t, std::size_t> figure_line(const std::string& file, const FigureField& field) {
  const std::size_t table = file.find("[" + std::string(field.table) + "]");
  std::size_t at = file.find("\n" + std::string(field.key) + " ", table) + 1;
  return {at, file.find('\n', at) + 1};
}

// Every key of the schema, whatever is added to it: missing, misspelt, negative, absurd, not a number,
// without a source.
TEST(PlatformFiles, EveryKeyIsGuardedAgainstEveryMistake) {
  const std::string good = xenos_text();
  const std::regex value("value = [0-9.]+");
  for (const FigureField& field : console::figure_fields()) {
    const auto [begin, end] = figure_line(good, field);
    const std::string line = good.substr(begin, end - begin);
    ASSERT_NE(line.find("value = "), std::string::npos) << field.table << "." << field.key;
    const std::string key(field.key);
    const struct {
      std::string text, phrase;
      bool at_the_line;
    } mistakes[] = {
        {"", "'" + key + "' is missing", false},
        {key + "s" + line.substr(key.size()), "unknown key '" + key + "s'", true},
        {std::regex_replace(line, value, "value = -1"), "negative", true},
        {std::regex_replace(line, value, fmt::format("value = {}", 2 * field.high_limit + 1)),
         "out of limits", true},
        {std::regex_replace(line, value, "value = inf"), "finite", true},
        {std::regex_replace(line, value, "value = nan"), "finite", true},
        {std::regex_replace(line, value, "value = \"4\""), "must be a number", true},
        {std::regex_replace(line, std::regex("source = \"[^\"]+\""), "source = \"\""), "must not be empty",
         true},
        {key + " = 4\n", "must carry its source", true},
    };
    for (const auto& mistake : mistakes) {
      std::string bad = good;
      bad.replace(begin, end - begin, mistake.text);
      try {
        console::parse_platform(bad, "x.toml");
        ADD_FAILURE() << "accepted: " << mistake.text;
      } catch (const UserError& error) {
        EXPECT_NE(std::string(error.what()).find(mistake.phrase), std::string::npos) << error.what();
        const int expected = 1 + static_cast<int>(std::count(
                                     good.begin(), good.begin() + static_cast<std::ptrdiff_t>(begin), '\n'));
        if (mistake.at_the_line) {
          EXPECT_EQ(error.place().line, expected) << error.what();
        }
      }
    }
  }
}

TEST(PlatformFiles, BlocksTheRasterizerDoesNotKnowAreRefusedWithTheirLine) {
  std::string bad = xenos_text();
  bad.replace(bad.find("reject_samples = { value = 4"), 28, "reject_samples = { value = 5");
  try {
    console::parse_platform(bad, "x.toml");
    ADD_FAILURE();
  } catch (const UserError& error) {
    EXPECT_EQ(error.place().line, line_of(bad, "reject_samples"));
    EXPECT_NE(error.hint().find("4, 8 or 16"), std::string::npos);
  }
}

struct Damage {
  const char* name;
  const char* original;  // replaced in xenos.toml
  const char* replacement;
  const char* where;   // text whose line the error must name; "" = a missing thing, any line will do
  const char* phrase;  // in the message
};

const Damage kDamages[] = {
    {"UnknownTable", "[texture]", "[textures]", "[textures]", "unknown key 'textures'"},
    {"UnknownKey", "trilinear_cyc    = ", "trilinaer_cyc    = ", "trilinaer_cyc",
     "unknown key 'trilinaer_cyc'"},
    {"UnknownField", "core_mhz = { value", "core_mhz = { vale", "core_mhz", "unknown key 'vale'"},
    {"MissingKey", "core_mhz = { value = 500, source = \"MS04\", confidence = \"doc\" }", "", "[clock]",
     "'core_mhz' is missing"},
    {"MissingId", "id = \"xenos\"", "", "", "'id' is missing"},
    {"MissingSource", "core_mhz = { value = 500, source = \"MS04\", ", "core_mhz = { value = 500, ",
     "core_mhz", "'source' is missing"},
    {"EmptySource", "core_mhz = { value = 500, source = \"MS04\"", "core_mhz = { value = 500, source = \"\"",
     "core_mhz", "must not be empty"},
    {"MissingConfidence", "source = \"MS04\", confidence = \"doc\" }\n\n[target]",
     "source = \"MS04\" }\n\n[target]", "core_mhz", "'confidence' is missing"},
    {"UnknownConfidence", "source = \"MS04\", confidence = \"doc\" }\n\n[target]",
     "source = \"MS04\", confidence = \"sure\" }\n\n[target]", "core_mhz", "unknown confidence 'sure'"},
    {"Negative", "core_mhz = { value = 500", "core_mhz = { value = -500", "core_mhz", "negative"},
    {"ClockInHertz", "core_mhz = { value = 500", "core_mhz = { value = 500000000", "core_mhz",
     "out of limits"},
    {"EfficiencyInPerCent", "efficiency    = { value = 0.95", "efficiency    = { value = 95", "value = 95",
     "out of limits"},
    {"ZeroRate", "bilinear_per_clk = { value = 16", "bilinear_per_clk = { value = 0", "bilinear_per_clk",
     "out of limits"},
    {"NotANumber", "core_mhz = { value = 500", "core_mhz = { value = nan", "core_mhz", "finite"},
    {"Infinite", "core_mhz = { value = 500", "core_mhz = { value = inf", "core_mhz", "finite"},
    {"TextForNumber", "core_mhz = { value = 500", "core_mhz = { value = \"500\"", "core_mhz",
     "must be a number, found a string"},
    {"BareNumber", "core_mhz = { value = 500, source = \"MS04\", confidence = \"doc\" }", "core_mhz = 500",
     "core_mhz", "must carry its source"},
    {"ArrayForTable", "[setup]", "[[setup]]", "[[setup]]", "must be a table, found an array"},
    {"FractionOfAPixel", "width_px  = { value = 1280", "width_px  = { value = 1280.5", "width_px",
     "must be whole"},
    {"RangeOnDocumented", "core_mhz = { value = 500, source = \"MS04\", confidence = \"doc\" }",
     "core_mhz = { value = 500, source = \"MS04\", confidence = \"doc\", low = 400, high = 600 }", "core_mhz",
     "documented but has a range"},
    {"RangeBackwards", "low = 0.8, high = 1.0", "low = 1.0, high = 0.8", "low = 1.0", "low <= value <= high"},
    {"HalfARange", "low = 0.8, high = 1.0", "low = 0.8", "low = 0.8", "'high' is missing"},
    {"UnknownAluModel", "alu_model = \"vec4+scalar\"", "alu_model = \"vec5\"", "alu_model",
     "unknown alu_model 'vec5'"},
    {"YearAsText", "year = 2005", "year = \"2005\"", "year", "'year' must be an integer"},
    {"AbsurdYear", "year = 2005", "year = 20005", "year", "outside 1970..2100"},
    {"NotToml", "[clock]", "[clock", "[clock", "not valid TOML"},
    {"Twice", "[clock]", "[clock]\n[clock]", "[clock]", "not valid TOML"},
};

class DamagedPlatform : public ::testing::TestWithParam<Damage> {};

TEST_P(DamagedPlatform, IsRefusedAtItsLine) {
  const Damage& damage = GetParam();
  std::string text = xenos_text();
  const auto at = text.find(damage.original);
  ASSERT_NE(at, std::string::npos) << damage.original;
  text.replace(at, std::string(damage.original).size(), damage.replacement);
  try {
    console::parse_platform(text, "my.toml");
    FAIL() << "accepted";
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find(damage.phrase), std::string::npos) << error.what();
    EXPECT_EQ(error.place().file, "my.toml");
    EXPECT_GT(error.place().line, 0) << error.what();
    EXPECT_GT(error.place().column, 0) << error.what();
    if (*damage.where != '\0') {
      // A duplicate table is reported where the second one stands.
      const int extra = std::string(damage.name) == "Twice" ? 1 : 0;
      EXPECT_EQ(error.place().line, line_of(text, damage.where) + extra) << error.what();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(PlatformFiles, DamagedPlatform, ::testing::ValuesIn(kDamages),
                         [](const auto& damage) { return std::string(damage.param.name); });

TEST(PlatformFiles, MisspeltKeyGetsASuggestion) {
  std::string text = xenos_text();
  text.replace(text.find("trilinear_cyc"), 13, "trilinaer_cyc");
  try {
    console::parse_platform(text, "my.toml");
    FAIL();
  } catch (const UserError& error) {
    EXPECT_NE(error.hint().find("trilinear_cyc"), std::string::npos) << error.hint();
  }
}

TEST(PlatformFiles, UnknownNameGetsASuggestionAndAMissingFileIsNamed) {
  try {
    console::load_platform("xenoz");
    FAIL();
  } catch (const UserError& error) {
    EXPECT_NE(error.hint().find("xenos"), std::string::npos) << error.hint();
  }
  try {
    console::load_platform("no/such/file.toml");
    FAIL();
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("no/such/file.toml"), std::string::npos);
  }
}

}  // namespace
}  // namespace aluminate::test
