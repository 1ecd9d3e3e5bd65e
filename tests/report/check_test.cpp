// Checks from end to end on a small scene: what is caught, what is explained, what can and cannot be
// accepted.
#include "shading/report/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "platform/host/image_file.hpp"
#include "shading/report/check_report.hpp"
#include "shading/report/document.hpp"

namespace aluminate::test {
namespace {

namespace fs = std::filesystem;
using report::Outcome;
using testing::HasSubstr;

const std::string kScene = std::string(ALUMINATE_SOURCE_DIR) + "/scenes/samples/material_wall.gltf";

class Checks : public testing::Test {
 protected:
  void SetUp() override {
    before_ = fs::current_path();
    folder_ =
        fs::temp_directory_path() /
        ("aluminate_check_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    fs::current_path(folder_);
    write("lit.hlsl", "float4 a, b;\nfloat4 main(float4 c : COLOR0) : COLOR0 { return a * c + b; }\n");
    file("tri", "lit");
  }
  void TearDown() override {
    fs::current_path(before_);
    fs::remove_all(folder_);
  }

  static void write(const std::string& name, const std::string& text) {
    std::ofstream(name, std::ios::binary) << text;
  }
  static std::string read(const std::string& name) {
    std::ifstream in(name, std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
  }
  static void file(const std::string& scene_check, const std::string& shader_check,
                   const std::string& more = "") {
    write("aluminate.toml",
          "schema = 1\n[defaults]\nsize = \"48x32\"\nlights = \"rig:1\"\n[[check]]\nname = \"" + scene_check +
              "\"\nscene = \"" + kScene + "\"\n" + more + "[[check]]\nname = \"" + shader_check +
              "\"\ncost = \"lit.hlsl\"\n");
  }

  static report::CheckRun run(std::vector<std::string> names = {}, std::vector<std::string> update = {},
                              bool verify = false) {
    return report::run_checks(
        {report::load_check_file("aluminate.toml"), std::move(names), std::move(update), verify});
  }
  static void accept_all() { ASSERT_EQ(run({}, {"tri", "lit"}).exit_code(), 0); }

  fs::path before_, folder_;
};

TEST_F(Checks, NothingAcceptedIsMissingUntilAcceptedByName) {
  report::CheckRun first = run();
  EXPECT_EQ(first.exit_code(), 1);
  EXPECT_EQ(first.count(Outcome::Missing), 2);
  EXPECT_THAT(report::check_text(first), HasSubstr("aluminate check --update tri"));
  ASSERT_EQ(run({}, {"tri"}).exit_code(), 0);
  EXPECT_EQ(run({"tri"}).exit_code(), 0);
  EXPECT_EQ(run().count(Outcome::Missing), 1) << "accepting one accepts no other";
  ASSERT_EQ(run({}, {"lit"}).exit_code(), 0);
  EXPECT_EQ(run({}, {}, true).exit_code(), 0) << "the same with other threads and vector widths";
  const std::string golden = read("goldens/tri.toml");
  ASSERT_EQ(run({}, {"tri"}).exit_code(), 0);
  EXPECT_EQ(read("goldens/tri.toml"), golden) << "accepting again changes no byte";
}

TEST_F(Checks, OneStepOfOneChannelOfOnePixelIsCaughtAndNamed) {
  accept_all();
  // The accepted picture had one red step less at (24, 16).
  host::Image8 image = host::read_image_rgba8("goldens/tri.png");
  const std::string old_hash = report::image_hash(image.width, image.height, image.texels);
  const std::size_t at = (16u * 48u + 24u) * 4u;
  const int now = image.texels[at];
  ASSERT_GT(now, 0);
  image.texels[at] = static_cast<std::uint8_t>(now - 1);
  host::write_png("goldens/tri.png", image);
  std::string golden = read("goldens/tri.toml");
  golden.replace(golden.find(old_hash), 32, report::image_hash(image.width, image.height, image.texels));
  write("goldens/tri.toml", golden);

  const report::CheckRun done = run();
  EXPECT_EQ(done.exit_code(), 1);
  const report::CheckResult& result = done.results[0];
  EXPECT_EQ(result.outcome, Outcome::Differs);
  EXPECT_FALSE(result.difference.cost_differs());
  EXPECT_EQ(result.image.differing, 1u);
  EXPECT_EQ(result.pixel.x, 24);
  EXPECT_EQ(result.pixel.y, 16);
  EXPECT_EQ(result.pixel.before[0], now - 1);
  EXPECT_EQ(result.pixel.after[0], now);
  EXPECT_THAT(result.pixel.draw, testing::StartsWith("draw "));
  EXPECT_TRUE(fs::exists("aluminate-check/tri.html"));
  EXPECT_THAT(read("aluminate-check/tri.html"), HasSubstr("aluminate check --update tri"));
  const std::string text = report::check_text(done);
  EXPECT_THAT(text, HasSubstr("first at (24, 16)"));
  EXPECT_THAT(text, HasSubstr("aluminate-check/tri.html"));

  ASSERT_EQ(run({}, {"tri"}).exit_code(), 0);
  EXPECT_EQ(run().exit_code(), 0);
  EXPECT_FALSE(fs::exists("aluminate-check/tri.html")) << "an old page must not outlive its difference";
}

TEST_F(Checks, OneInstructionIsCaughtBetterAndWorseAndNeither) {
  accept_all();
  const auto change = [&](const char* body) {
    write("lit.hlsl",
          std::string("float4 a, b;\nfloat4 main(float4 c : COLOR0) : COLOR0 { return ") + body + "; }\n");
    const report::CheckRun done = run({"lit"});
    EXPECT_EQ(done.exit_code(), 1) << body;
    EXPECT_THAT(report::check_text(done), HasSubstr("first differing instruction"));
    return done.results[0].difference.cost_change();
  };
  EXPECT_EQ(change("a * c + b.wzyx"), report::Change::Other) << "same counts, another swizzle";
  EXPECT_EQ(change("(a * c + b) * c.yzwx"), report::Change::Hurt);
  write("lit.hlsl",
        "float4 a, b;\nfloat4 main(float4 c : COLOR0) : COLOR0 { return (a * c + b) * c.yzwx; }\n");
  ASSERT_EQ(run({}, {"lit"}).exit_code(), 0);
  EXPECT_EQ(change("a * c + b"), report::Change::Helped) << "better fails too until it is accepted";
}

TEST_F(Checks, AFrameThatCostsMoreIsHurt) {
  accept_all();
  file("tri", "lit", "lights = \"rig:2\"\n");
  const report::CheckRun done = run({"tri"});
  EXPECT_EQ(done.results[0].difference.cost_change(), report::Change::Hurt);
  EXPECT_THAT(report::check_text(done), HasSubstr("HURT"));
}

TEST_F(Checks, BrokenGoldensAreErrorsThatNameTheFile) {
  accept_all();
  const std::string golden = read("goldens/tri.toml");
  write("goldens/tri.toml", golden.substr(0, golden.size() / 2) + "=");
  report::CheckRun done = run();
  EXPECT_EQ(done.exit_code(), 2);
  EXPECT_EQ(done.count(Outcome::Ok), 1) << "the other check still runs";
  EXPECT_THAT(done.results[0].message, HasSubstr("goldens/tri.toml:"));
  ASSERT_EQ(run({}, {"tri"}).exit_code(), 0) << "accepting again repairs it";
  EXPECT_EQ(run().exit_code(), 0);
  // Somebody accepted the picture of another check.
  std::string other = read("goldens/tri.toml");
  other.replace(other.find("check = \"tri\""), 13, "check = \"oak\"");
  write("goldens/tri.toml", other);
  EXPECT_THAT(run().results[0].message, HasSubstr("golden of 'oak'"));
}

TEST_F(Checks, ThePictureMustBeTheOneThatWasAccepted) {
  accept_all();
  file("tri", "lit", "visibility = \"none\"\nlights = \"rig:2\"\n");
  host::Image8 image = host::read_image_rgba8("goldens/tri.png");
  image.texels[0] ^= 1;
  host::write_png("goldens/tri.png", image);
  EXPECT_THAT(run().results[0].message, HasSubstr("not the picture that was accepted"));
  fs::resize_file("goldens/tri.png", 40);
  EXPECT_EQ(run().exit_code(), 2);
  fs::remove("goldens/tri.png");
  EXPECT_EQ(run().exit_code(), 2);
  EXPECT_THAT(run().results[0].message, HasSubstr("goldens/tri.png"));
}

TEST_F(Checks, ExtraAndRenamedGoldensAreReportedAndRemovedByName) {
  accept_all();
  file("triangle", "lit");
  const report::CheckRun done = run();
  EXPECT_EQ(done.exit_code(), 1);
  EXPECT_EQ(done.count(Outcome::Missing), 1);
  EXPECT_EQ(done.count(Outcome::Extra), 1);
  EXPECT_EQ(done.results[0].renamed_from, "tri");
  ASSERT_EQ(run({}, {"triangle", "tri"}).exit_code(), 0);
  EXPECT_EQ(run().exit_code(), 0);
  EXPECT_FALSE(fs::exists("goldens/tri.toml"));
  EXPECT_FALSE(fs::exists("goldens/tri.png"));
}

TEST_F(Checks, UnknownNamesAreRefusedWithASuggestion) {
  try {
    run({"trj"});
    ADD_FAILURE();
  } catch (const UserError& error) {
    EXPECT_THAT(error.hint(), HasSubstr("tri"));
  }
  EXPECT_THROW(run({}, {"trj"}), UserError);
  EXPECT_FALSE(fs::exists("goldens"));
}

TEST_F(Checks, AnErrorInOneCheckStopsNoOtherAndKnowsItsPlace) {
  accept_all();
  write("lit.hlsl", "float4 main() : COLOR0 { return flaot4(1, 1, 1, 1); }\n");
  const report::CheckRun done = run();
  EXPECT_EQ(done.exit_code(), 2);
  EXPECT_EQ(done.results[0].outcome, Outcome::Ok);
  EXPECT_THAT(done.results[1].message, HasSubstr("lit.hlsl:1"));
  EXPECT_THAT(report::check_junit(done), HasSubstr("<error message=\"ERROR\">"));
}

TEST_F(Checks, ABudgetIsPartOfTheCheck) {
  file("tri", "lit", "budget_ms = 0.0001\n");
  accept_all();
  const report::CheckRun done = run();
  EXPECT_EQ(done.exit_code(), 1);
  EXPECT_EQ(done.results[0].outcome, Outcome::OverBudget);
  file("tri", "lit", "budget_ms = 33.3\n");
  EXPECT_EQ(run().exit_code(), 0);
}

TEST_F(Checks, ReportsCountAndQuote) {
  report::CheckRun done = run();
  done.results[0].name = "a<b";
  const std::string junit = report::check_junit(done);
  EXPECT_THAT(junit, HasSubstr("tests=\"2\" failures=\"2\" errors=\"0\""));
  EXPECT_THAT(junit, HasSubstr("name=\"a&lt;b\""));
  EXPECT_THAT(report::check_markdown(done), HasSubstr("**MISSING**"));
  EXPECT_THAT(report::check_text(done), HasSubstr("2 MISSING"));
}

}  // namespace
}  // namespace aluminate::test
