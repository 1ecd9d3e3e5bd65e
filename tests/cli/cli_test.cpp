#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/cli/process.hpp"

namespace aluminate::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kWall = std::string(ALUMINATE_SOURCE_DIR) + "/scenes/samples/material_wall.gltf";

class Cli : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("aluminate_cli_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
  static std::string read(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
  }

  // Exit 2, one line that begins with the program's name and says `what`, nothing on stdout, nothing left
  // behind.
  void expect_user_error(const std::vector<std::string>& arguments, const std::string& what) {
    const std::vector<std::string> before = files();
    const Finished run = run_program(arguments);
    EXPECT_EQ(run.code, 2) << run.error;
    EXPECT_THAT(run.error, StartsWith("aluminate: "));
    EXPECT_THAT(run.error, HasSubstr(what));
    EXPECT_LE(std::count(run.error.begin(), run.error.end(), '\n'), 3) << run.error;
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(files(), before) << "partial output";
  }

  fs::path folder_;
};

TEST_F(Cli, MistypedOptionsGetASuggestion) {
  expect_user_error({"render", kWall, "-o", path("a.png"), "--visibilty", "cheap"}, "--visibility");
  expect_user_error({"render", kWall, "-o", path("a.png"), "--visibility", "cheep"}, "cheap");
  expect_user_error({"rendr", kWall}, "render");
  expect_user_error({"compare", kWall, "--a", "visibilty=cheap", "--b", "visibility=none", "-o", path("out")},
                    "visibility");
  expect_user_error({"render", kWall, "-o", path("a.png"), "--platform", "xeno"}, "xenos");
  expect_user_error({"render", kWall, "-o", path("a.png"), "--number", "fx99"}, "fx31");
  expect_user_error({"render", kWall, "-o", path("a.png"), "--no-skip", "facign"}, "facing");
}

TEST_F(Cli, ACapturedCubeMapIsReflected) {
  ASSERT_EQ(run_program({"cubemap", kWall, "--face", "16", "--sky", "fc3", "-o", path("cube.exr")}).code, 0);
  const std::vector<std::string> render{"render", kWall, "--size", "64x36", "--sky", "fc3", "-o"};
  const auto with = [&](std::vector<std::string> more) {
    std::vector<std::string> all = render;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  ASSERT_EQ(run_program(with({path("plain.png"), "--reflections", "off"})).code, 0);
  ASSERT_EQ(run_program(with({path("with.png"), "--reflections", path("cube.exr"), "--json", path("with.json")})).code, 0);
  const auto inputs = nlohmann::json::parse(read(path("with.json")))["inputs"];
  EXPECT_EQ(inputs["file_hashes"][path("cube.exr")].get<std::string>().size(), 32u);
  EXPECT_NE(read(path("plain.png")), read(path("with.png")));
  expect_user_error(with({path("a.png"), "--reflections", path("none.exr")}), "none.exr");
  expect_user_error(with({path("a.png"), "--reflections", path("plain.png")}), "no captured cube map");
  expect_user_error({"cubemap", kWall, "--face", "20", "-o", path("b.exr")}, "16, 32, 64 or 128");
  expect_user_error({"cubemap", kWall, "-o", path("b.png")}, ".exr");
  expect_user_error({"cubemap", kWall, "--at", "1,2", "-o", path("b.exr")}, "--at");
}

TEST_F(Cli, BadValuesNameTheOptionAndWhatIsExpected) {
  expect_user_error({"render", kWall, "-o", path("a.png"), "--size", "0x480"}, "1 to 16384");
  expect_user_error({"render", kWall, "-o", path("a.png"), "--size", "640"}, "WIDTHxHEIGHT");
  expect_user_error({"render", kWall, "-o", path("a.png"), "--lights", "rig:0"}, "rig:N");
  expect_user_error({"render", kWall, "-o", path("a.png"), "--lights", "rig:-3"}, "rig:N");
  expect_user_error({"render", kWall, "-o", path("a.png"), "--background", "1,2"}, "R,G,B");
  expect_user_error({"render", kWall, "-o", path("a.png"), "--camera", "behind"}, "camera");
  expect_user_error({"render", kWall, "-o", path("a.bmp")}, ".png");
  expect_user_error({"pixel", kWall, "5"}, "X,Y");
  expect_user_error({"pixel", kWall, "5000,5", "--size", "64x64"}, "outside");
  expect_user_error({"render", kWall, "-o", path("a.png"), "--threads", "-1"}, "thread");
}

TEST_F(Cli, MissingAndBrokenInputsAreNamed) {
  expect_user_error({"render", path("none.glb"), "-o", path("a.png")}, "none.glb");
  write("broken.gltf", "{\"asset\":{\"version\":\"2.0\"},");
  expect_user_error({"render", path("broken.gltf"), "-o", path("a.png")}, "broken.gltf");
  write("empty.glb", "");
  expect_user_error({"render", path("empty.glb"), "-o", path("a.png")}, "empty.glb");
  write("typo.hlsl", "float4 main() : COLOR0 {\n  return flaot4(1, 1, 1, 1);\n}\n");
  expect_user_error({"cost", path("typo.hlsl")}, "typo.hlsl:2");
  expect_user_error({"render", kWall, "-o", path("a.png"), "--shader", path("typo.hlsl")}, "typo.hlsl:2");
  write("bad.toml", "id = \"x\"\n");
  expect_user_error({"render", kWall, "-o", path("a.png"), "--platform", path("bad.toml")}, "bad.toml");
  write("bad.csv", "g,n_dot_l,n_dot_v,n_dot_h,h_dot_v,cspec\n0.5,1,1,1,x,0.04\n");
  expect_user_error({"eval", "brdf", "--inputs", path("bad.csv"), "-o", path("out.csv")}, "bad.csv:2:5");
}

TEST_F(Cli, UnwritableOutputsFailBeforeAnyWork) {
  expect_user_error({"render", kWall, "-o", path("no_such_folder/a.png")}, "no_such_folder");
  expect_user_error({"render", kWall, "-o", folder_.string()}, folder_.string());
}

TEST_F(Cli, RenderWritesPictureLayersAndJson) {
  const Finished run = run_program({"render", kWall, "-o", path("a.png"), "--cost", path("cost.exr"),
                                    "--json", path("a.json"), "--size", "96x54"});
  ASSERT_EQ(run.code, 0) << run.error;
  EXPECT_EQ(files(), (std::vector<std::string>{"a.json", "a.png", "cost.exr"}));
  const auto json = nlohmann::json::parse(read(path("a.json")));
  EXPECT_EQ(json["image"]["width"], 96);
  EXPECT_EQ(json["image"]["hash"].get<std::string>().size(), 32u);
  for (const char* key : {"schema", "tool", "command", "inputs", "image", "timing", "cost", "per_pixel",
                          "skipped", "saturations"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_GT(json["cost"]["passes"][0]["alu_words"].get<double>(), 0);
  EXPECT_GT(json["per_pixel"]["alu_words"]["mean"].get<double>(), 0);
}

TEST_F(Cli, ThreadsNeverChangeAByte) {
  std::string image, layers, json;
  for (const char* threads : {"1", "2", "3", "7"}) {
    const Finished run = run_program({"render", kWall, "-o", path("a.png"), "--cost", path("cost.exr"),
                                      "--json", path("a.json"), "--size", "200x113", "--threads", threads});
    ASSERT_EQ(run.code, 0) << run.error;
    auto document = nlohmann::ordered_json::parse(read(path("a.json")));
    document.erase("timing");
    if (image.empty()) {
      image = read(path("a.png"));
      layers = read(path("cost.exr"));
      json = document.dump();
    }
    EXPECT_EQ(read(path("a.png")), image) << threads;
    EXPECT_EQ(read(path("cost.exr")), layers) << threads;
    EXPECT_EQ(document.dump(), json) << threads;
  }
}

TEST_F(Cli, CompareWritesEveryFileAndSaysHelpedOrHurt) {
  const Finished helped =
      run_program({"compare", kWall, "--a", "visibility=schlick-smith", "--b", "visibility=cheap", "--lights",
                   "rig:4", "--size", "96x54", "-o", path("out")});
  ASSERT_EQ(helped.code, 0) << helped.error;
  for (const char* name : {"a.png", "b.png", "difference.png", "cost_a.png", "cost_b.png",
                           "cost_difference.png", "cost_a.exr", "cost_b.exr", "compare.json"})
    EXPECT_TRUE(fs::exists(path(std::string("out/") + name))) << name;
  EXPECT_THAT(helped.out, HasSubstr("helped"));
  EXPECT_THAT(helped.out, HasSubstr("ps_3_0 slots"));
  const Finished hurt =
      run_program({"compare", kWall, "--a", "visibility=cheap", "--b", "visibility=schlick-smith", "--lights",
                   "rig:4", "--size", "96x54", "-o", path("out2")});
  EXPECT_EQ(hurt.code, 1);
  EXPECT_THAT(hurt.out, HasSubstr("HURT"));
  // The same picture on both sides: nothing helped, nothing hurt, no differing pixel.
  const Finished same = run_program({"compare", kWall, "--a", "visibility=none", "--b", "visibility=none",
                                     "--size", "96x54", "-o", path("out3")});
  EXPECT_EQ(same.code, 0);
  EXPECT_THAT(same.out, HasSubstr("equal"));
}

TEST_F(Cli, DiffSaysEqualOrDifferent) {
  ASSERT_EQ(run_program({"render", kWall, "-o", path("a.png"), "--size", "64x36"}).code, 0);
  ASSERT_EQ(
      run_program({"render", kWall, "-o", path("b.png"), "--size", "64x36", "--visibility", "none"}).code, 0);
  EXPECT_EQ(run_program({"diff", path("a.png"), path("a.png")}).code, 0);
  const Finished different = run_program({"diff", path("a.png"), path("b.png"), "-o", path("d.png"), "--html", path("d.html")});
  EXPECT_TRUE(fs::exists(path("d.html")));
  EXPECT_EQ(different.code, 1);
  EXPECT_THAT(different.out, HasSubstr("pixels differ"));
  EXPECT_TRUE(fs::exists(path("d.png")));
  expect_user_error({"diff", path("a.png"), path("none.png")}, "none.png");
}

TEST_F(Cli, InterruptLeavesNothingBehind) {
  const Finished run = run_program({"render", kWall, "-o", path("a.png"), "--json", path("a.json"), "--size",
                                    "6000x4000", "--lights", "rig:32"},
                                   "", 700);
  EXPECT_EQ(run.code, 130) << run.error;
  EXPECT_TRUE(files().empty());
}

TEST_F(Cli, BudgetDecidesTheExitCodeOnlyWhenAskedFor) {
  EXPECT_EQ(run_program({"render", kWall, "-o", path("a.png"), "--size", "64x36", "--budget", "33.3"}).code,
            0);
  EXPECT_EQ(run_program({"render", kWall, "-o", path("a.png"), "--size", "64x36", "--budget", "0.0001"}).code,
            1);
}

TEST_F(Cli, SkipsChangeNeitherPictureNorBill) {
  ASSERT_EQ(
      run_program({"render", kWall, "-o", path("a.png"), "--json", path("a.json"), "--size", "96x54"}).code,
      0);
  ASSERT_EQ(run_program({"render", kWall, "-o", path("b.png"), "--json", path("b.json"), "--size", "96x54",
                         "--no-skip", "all"})
                .code,
            0);
  const auto a = nlohmann::json::parse(read(path("a.json"))), b = nlohmann::json::parse(read(path("b.json")));
  EXPECT_EQ(a["image"], b["image"]);
  EXPECT_EQ(a["cost"], b["cost"]);
  EXPECT_EQ(a["per_pixel"], b["per_pixel"]);
}

TEST_F(Cli, PublishedClaimComesOutOfTheScheduler) {
  const auto per_light = [&](const std::string& variant) {
    const Finished run = run_program({"cost", variant, "--light-loop", "rolled", "--format", "json"});
    EXPECT_EQ(run.code, 0) << run.error;
    return nlohmann::json::parse(run.out)["programs"][0]["per_light"]["alu_slots"].get<int>();
  };
  const int none = per_light("none");
  EXPECT_EQ(per_light("schlick-smith") - none, 8);
  EXPECT_EQ(per_light("cheap") - none, 0);
}

TEST_F(Cli, CheckAcceptsByNameAndFindsItsFileFromBelow) {
  fs::create_directories(path("sub"));
  write("aluminate.toml", "schema = 1\n[[check]]\nname = \"lit\"\ncost = \"lit.hlsl\"\n");
  write("lit.hlsl", "float4 k;\nfloat4 main(float4 c : COLOR0) : COLOR0 { return c * k; }\n");
  const auto check = [&](std::vector<std::string> arguments, const std::string& where) {
    arguments.insert(arguments.begin(), "check");
    return run_program(arguments, path(where));
  };
  EXPECT_EQ(check({}, "sub").code, 1) << "missing";
  const Finished refused = check({"--update"}, "");
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.error, HasSubstr("needs the name"));
  EXPECT_EQ(check({"--update", "lit"}, "sub").code, 0);
  const Finished same = check({"--junit", "checks.xml", "--markdown", "-"}, "sub");
  EXPECT_EQ(same.code, 0) << same.out << same.error;
  EXPECT_THAT(same.out, StartsWith("**aluminate check**: 1 ok"));
  EXPECT_TRUE(fs::exists(path("sub/checks.xml"))) << "outputs are relative to where the user stands";
  write("lit.hlsl", "float4 k;\nfloat4 main(float4 c : COLOR0) : COLOR0 { return c * k + c.x; }\n");
  const Finished changed = check({}, "");
  EXPECT_EQ(changed.code, 1);
  EXPECT_THAT(changed.out, HasSubstr("aluminate check --update lit"));
  write("aluminate.toml", "schema = 1\n[[check]]\nname = \"lit\"\ncots = \"lit.hlsl\"\n");
  const Finished typo = check({}, "");
  EXPECT_EQ(typo.code, 2);
  EXPECT_THAT(typo.error, HasSubstr("aluminate.toml:4:1: unknown key 'cots'"));
  EXPECT_THAT(typo.error, HasSubstr("did you mean 'cost'"));
}

TEST_F(Cli, DoctorKnowsThisMachine) {
  const Finished run = run_program({"doctor"});
  EXPECT_EQ(run.code, 0) << run.out;
  EXPECT_THAT(run.out, HasSubstr("self-test"));
}

TEST_F(Cli, EveryCommandExplainsItself) {
  for (const char* command :
       {"render", "compare", "cost", "pixel", "eval", "platform", "scene", "check", "sweep", "diff", "doctor"}) {
    const Finished run = run_program({command, "--help"});
    EXPECT_EQ(run.code, 0) << command;
    EXPECT_THAT(run.out, HasSubstr(command));
    EXPECT_EQ(run.error, "");
  }
  EXPECT_EQ(run_program({"--version"}).code, 0);
  EXPECT_EQ(run_program({}).code, 2);
}

TEST_F(Cli, ShadersBeyondALimitAreErrorsThatNameIt) {
  std::string doubling = "#define A0 v+v\n";
  for (int i = 1; i < 40; ++i) doubling += fmt::format("#define A{} A{}+A{}\n", i, i - 1, i - 1);
  write("doubling.hlsl", doubling + "float4 main(float4 v : TEXCOORD0) : COLOR0 { return A39; }\n");
  expect_user_error({"cost", path("doubling.hlsl")}, "macros expanded");
}

}  // namespace
}  // namespace aluminate::test
