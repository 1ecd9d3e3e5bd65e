// The text of a golden: what is written is read back, what was not written so is refused, and a change has a
// direction.
#include "shading/report/golden.hpp"

#include <gtest/gtest.h>

#include "platform/host/error.hpp"
#include "shading/report/difference_page.hpp"

namespace aluminate::test {
namespace {

using report::Change;
using report::Golden;

Golden sample() {
  Golden golden{"wall/cheap", "aluminate render \"a b\".gltf", 320, 180, std::string(32, 'a'), {}};
  golden.sections.push_back({"frame", "", {{"derated_ms", 1.0 / 3}, {"peak_ms", 0.1}}, {}});
  golden.sections.push_back({"pass", "z last", {{"pixels", 57600}, {"alu_words", 9007199254740991.0}}, {}});
  golden.sections.push_back({"pass", "a first", {{"pixels", 0}, {"alu_words", 1}}, {}});
  golden.sections.push_back({"program",
                             "lit [base \"x\" \\ \x01 \xc3\xa4] #2",
                             {{"alu_words", 33}, {"threads", 12}},
                             {"V mad r0.xyz, r1, c0, r2", "+ S rsq r1.w, |r0.x|", "T tex \"s\""}});
  return golden;
}

TEST(Golden, TextReadsBackAsItWasInItsOrder) {
  const Golden golden = sample();
  const Golden back = report::parse_golden(report::write_golden(golden), "g.toml");
  EXPECT_EQ(back.check, golden.check);
  EXPECT_EQ(back.command, golden.command);
  EXPECT_EQ(back.image_hash, golden.image_hash);
  ASSERT_EQ(back.sections.size(), golden.sections.size());
  for (std::size_t i = 0; i < golden.sections.size(); ++i) {
    EXPECT_EQ(back.sections[i].label(), golden.sections[i].label());
    EXPECT_EQ(back.sections[i].figures, golden.sections[i].figures) << i;
    EXPECT_EQ(back.sections[i].instructions, golden.sections[i].instructions);
  }
  EXPECT_EQ(report::write_golden(back), report::write_golden(golden));
  EXPECT_TRUE(report::compare_goldens(golden, back).same());
}

TEST(Golden, OneUnitInTheLastPlaceIsAChange) {
  Golden later = sample();
  later.sections[0].figures[0].value = std::nextafter(1.0 / 3, 1.0);
  const auto difference = report::compare_goldens(sample(), later);
  ASSERT_EQ(difference.figures.size(), 1u);
  EXPECT_EQ(difference.cost_change(), Change::Hurt);
}

TEST(Golden, BetterAndWorseHaveWords) {
  const auto change = [](const char* key, double before, double after) {
    Golden a = sample(), b = sample();
    a.sections[3].figures = {{key, before}};
    b.sections[3].figures = {{key, after}};
    return report::compare_goldens(a, b).cost_change();
  };
  EXPECT_EQ(change("alu_words", 33, 32), Change::Helped);
  EXPECT_EQ(change("alu_words", 33, 34), Change::Hurt);
  EXPECT_EQ(change("threads", 12, 15), Change::Helped);
  EXPECT_EQ(change("threads", 15, 12), Change::Hurt);
  EXPECT_EQ(change("pixels", 1, 2), Change::Other);
  EXPECT_EQ(change("pixels", 1, 1), Change::None);
}

TEST(Golden, TheFirstDifferingInstructionIsNamed) {
  Golden later = sample();
  later.sections[3].instructions[1] = "+ S rcp r1.w, r0.x";
  auto difference = report::compare_goldens(sample(), later);
  ASSERT_EQ(difference.instructions.size(), 1u);
  EXPECT_EQ(difference.instructions[0].line, 1u);
  EXPECT_EQ(difference.instructions[0].before, "+ S rsq r1.w, |r0.x|");
  EXPECT_EQ(difference.cost_change(), Change::Other)
      << "same counts, other code: neither better nor worse, but not the same";
  later = sample();
  later.sections[3].instructions.pop_back();
  difference = report::compare_goldens(sample(), later);
  ASSERT_EQ(difference.instructions.size(), 1u);
  EXPECT_EQ(difference.instructions[0].after, "");
}

TEST(Golden, SectionsThatCameOrWentAreChanges) {
  Golden later = sample();
  later.sections[1].name = "renamed";
  const auto difference = report::compare_goldens(sample(), later);
  EXPECT_EQ(difference.figures.size(), 2u);
}

TEST(Golden, WhatItDidNotWriteIsRefusedWithItsPlace) {
  const std::string text = report::write_golden(sample());
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    const auto at = changed.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return changed.replace(at, from.size(), to);
  };
  const std::string broken[] = {
      replaced("golden = 1", "golden = 2"),
      replaced("golden = 1\n", ""),
      replaced("check = ", "chekc = "),
      replaced("pixels = 57600", "pixels = \"many\""),
      replaced("pixels = 57600", "pixels = "),
      replaced("xxh3_128 = \"aaaa", "xxh3_128 = \"gaaa"),
      replaced("xxh3_128 = \"aa", "xxh3_128 = \"a"),
      replaced("width_px = 320", "width_px = -320"),
      replaced("width_px = 320", "width = 320"),
      replaced("  \"T tex", "  7, \"T tex"),
      replaced("[frame]", "[frames]"),
      text.substr(0, text.size() - 4),
      "<<<<<<< ours\n" + text,
      std::string("\x89PNG\r\n\x1a\n\0\0", 10),
  };
  for (const std::string& bad : broken) {
    try {
      report::parse_golden(bad, "g.toml");
      ADD_FAILURE() << "accepted:\n" << bad;
    } catch (const UserError& error) {
      EXPECT_EQ(std::string(error.what()).find("g.toml:"), 0u) << error.what();
    }
  }
}

TEST(DifferencePage, Base64IsTheStandardOne) {
  const auto encode = [](const std::string& text) {
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    return report::base64(bytes);
  };
  EXPECT_EQ(encode(""), "");  // the vectors of section 10 [RFC4648]
  EXPECT_EQ(encode("f"), "Zg==");
  EXPECT_EQ(encode("fo"), "Zm8=");
  EXPECT_EQ(encode("foo"), "Zm9v");
  EXPECT_EQ(encode("foob"), "Zm9vYg==");
  EXPECT_EQ(encode("fooba"), "Zm9vYmE=");
  EXPECT_EQ(encode("foobar"), "Zm9vYmFy");
}

TEST(DifferencePage, StandsAloneAndQuotesWhatItShows) {
  const std::vector<std::uint8_t> a(4 * 6, 10), b(4 * 6, 11);
  const std::string page = report::difference_page({.title = "<wall>",
                                                    .name_a = "a&b",
                                                    .name_b = "found",
                                                    .command = "",
                                                    .accept = "x",
                                                    .width = 3,
                                                    .height = 2,
                                                    .a = a,
                                                    .b = b});
  EXPECT_EQ(page.find("http"), std::string::npos) << "no network";
  EXPECT_EQ(page.find("<wall>"), std::string::npos);
  EXPECT_NE(page.find("a&amp;b"), std::string::npos);
  EXPECT_NE(page.find("6 of 6 pixels differ"), std::string::npos);
}

}  // namespace
}  // namespace aluminate::test
