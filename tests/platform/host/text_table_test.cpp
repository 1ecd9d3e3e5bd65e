#include "platform/host/text_table.hpp"

#include <gtest/gtest.h>

#include "platform/host/error.hpp"

namespace aluminate::host {
namespace {

TextTable sample() {
  TextTable table({{"pass"}, {"alu words", Align::Right}, {"note"}});
  table.add_row({"forward", "12", "a|b"});
  table.add_rule();
  table.add_row({"n·l", "1234567890", ""});
  return table;
}

TEST(TextTable, AlignsByCharactersAndEndsNoLineInABlank) {
  EXPECT_EQ(sample().text(),
            "pass      alu words  note\n"
            "forward          12  a|b\n"
            "-------  ----------  ----\n"
            "n·l      1234567890\n");
}

TEST(TextTable, TsvHasOneLinePerRow) {
  TextTable table = sample();
  table.add_row({"tab\there", "line\nbreak", "x"});
  EXPECT_EQ(table.tsv(), "pass\talu words\tnote\nforward\t12\ta|b\nn·l\t1234567890\t\ntab here\tline break\tx\n");
}

TEST(TextTable, MarkdownCarriesAlignment) {
  EXPECT_EQ(sample().markdown(),
            "| pass | alu words | note |\n| --- | ---: | --- |\n| forward | 12 | a\\|b |\n| n·l | 1234567890 |  |\n");
}

TEST(TextTable, RulesAreNoRows) { EXPECT_EQ(sample().row_count(), 2u); }

TEST(TextTable, RefusesARowOfAnotherWidth) {
  TextTable table({{"one"}});
  EXPECT_THROW(table.add_row({"a", "b"}), InternalError);
}

}  // namespace
}  // namespace aluminate::host
