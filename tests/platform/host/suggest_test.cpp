#include "platform/host/suggest.hpp"

#include <gtest/gtest.h>

namespace aluminate::host {
namespace {

TEST(EditDistance, CountsEdits) {
  EXPECT_EQ(edit_distance("", ""), 0);
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
  EXPECT_EQ(edit_distance("forward", "froward"), 1);  // swapped neighbours
  EXPECT_EQ(edit_distance("ca", "abc"), 3);           // a swapped pair is not edited again
}

TEST(EditDistance, IgnoresCaseAndKindOfDash) { EXPECT_EQ(edit_distance("Schlick_Smith", "schlick-smith"), 0); }

TEST(EditDistance, IsSymmetric) {
  for (const auto& [a, b] : {std::pair{"cheap", "cheep"}, {"xenos", "rsx"}, {"", "x"}}) {
    EXPECT_EQ(edit_distance(a, b), edit_distance(b, a));
  }
}

const std::vector<std::string> kVariants{"none", "schlick-smith", "integrated", "cheap"};

TEST(Suggest, NearestFirst) {
  EXPECT_EQ(nearest_names("cheep", kVariants), std::vector<std::string>{"cheap"});
  EXPECT_EQ(nearest_names("schlicksmith", kVariants), std::vector<std::string>{"schlick-smith"});
  const std::vector<std::string> near{"abcd", "abcx", "abc"};
  EXPECT_EQ(nearest_names("abc", near), (std::vector<std::string>{"abc", "abcd", "abcx"}));
}

TEST(Suggest, BeginningOfANameIsEnough) {
  EXPECT_EQ(nearest_names("int", kVariants), std::vector<std::string>{"integrated"});
}

TEST(Suggest, NothingFarAway) { EXPECT_TRUE(nearest_names("wrong", kVariants).empty()); }

TEST(Suggest, ReadsAsAHint) {
  EXPECT_EQ(did_you_mean("cheep", kVariants), "did you mean 'cheap'?");
  EXPECT_EQ(did_you_mean("ab", std::vector<std::string>{"aba", "abb", "abc"}), "did you mean 'aba', 'abb' or 'abc'?");
  EXPECT_EQ(did_you_mean("wrong", kVariants), "one of: none, schlick-smith, integrated, cheap");
  EXPECT_EQ(did_you_mean("wrong", std::vector<std::string>(13, "name-of-thing")), "");
  EXPECT_EQ(did_you_mean("wrong", {}), "");
}

}  // namespace
}  // namespace aluminate::host
