// cost --watch: a change of the file or of an include is priced and explained, a broken edit is survived.
#include "shading/report/cost_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "platform/host/error.hpp"

namespace aluminate::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(CostWatch, PricesAgainWhenFileOrIncludeChanges) {
  const fs::path folder = fs::temp_directory_path() / "aluminate_cost_watch";
  fs::remove_all(folder);
  fs::create_directories(folder);
  const auto write = [&](const char* name, const std::string& text) { std::ofstream(folder / name) << text; };
  const auto body = [](const char* value) {
    return std::string(
               "float4 k;\n#include \"part.hlsl\"\nfloat4 main(float4 c : COLOR0) : COLOR0 { return ") +
           value + "; }\n";
  };
  write("part.hlsl", "float4 part(float4 c) { return c * k; }\n");
  write("lit.hlsl", body("part(c)"));
  std::vector<std::string> said;
  int step = 0;
  report::CostRequest request;
  request.subjects = {(folder / "lit.hlsl").string()};
  report::watch_cost(request, {.print = [&](const std::string& text) { said.push_back(text); },
                               .wait =
                                   [&] {
                                     switch (step++) {
                                       case 0:
                                         write("lit.hlsl", body("part(c) * c.yzwx"));
                                         return true;
                                       case 1:
                                         write("lit.hlsl", body("prat(c)"));
                                         return true;
                                       case 2:
                                         return true;  // nothing changed: nothing is said
                                       case 3:
                                         write("lit.hlsl", body("part(c) * c.yzwx"));
                                         return true;
                                       case 4:
                                         write("part.hlsl", "float4 part(float4 c) { return c; }\n");
                                         return true;
                                       default:
                                         return false;
                                     }
                                   }});
  ASSERT_EQ(said.size(), 5u);
  EXPECT_THAT(said[0], HasSubstr("words"));
  EXPECT_THAT(said[1], HasSubstr("HURT"));
  EXPECT_THAT(said[2], HasSubstr("lit.hlsl:3"));
  EXPECT_THAT(said[3], HasSubstr("no change in cost"));
  EXPECT_THAT(said[4], HasSubstr("helped"));
  fs::remove_all(folder);
}

TEST(CostWatch, NeedsAFile) {
  report::CostRequest request;
  request.subjects = {"cheap"};
  EXPECT_THROW(report::watch_cost(request, {}), UserError);
}

}  // namespace
}  // namespace aluminate::test
