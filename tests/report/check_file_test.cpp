// aluminate.toml: lists become named checks, options take effect in order, and every mistake is refused where
// it stands.
#include "shading/report/check_file.hpp"

#include <gtest/gtest.h>

#include "shading/brdf/visibility.hpp"

namespace aluminate::test {
namespace {

using report::CheckFile;
using report::parse_check_file;

const std::string kHead = "schema = 1\n";

TEST(CheckFile, ListsBecomeNamedChecks) {
  const CheckFile file = parse_check_file(kHead + R"(
goldens = "accepted/"
[defaults]
size = "64x36"
lights = "rig:2"
[variant.cheap]
visibility = "cheap"
[variant.full]
visibility = "schlick-smith"
lights = "rig:3"
define = { BITS = 8 }
[[check]]
name = "frames"
scene = ["scenes/wall.gltf", "scenes/floor.glb"]
variant = ["cheap", "full"]
platform = "rsx"
[[check]]
name = "lit"
cost = "lit.hlsl"
variant = "full"
)",
                                          "aluminate.toml");
  ASSERT_EQ(file.checks.size(), 5u);
  EXPECT_EQ(file.goldens, "accepted");
  EXPECT_EQ(file.checks[0].name, "frames/wall/cheap");
  EXPECT_EQ(file.checks[3].name, "frames/floor/full");
  EXPECT_EQ(file.checks[3].options.lights, "rig:3") << "a variant is stronger than the defaults";
  EXPECT_EQ(file.checks[0].options.lights, "rig:2");
  EXPECT_EQ(file.checks[0].options.visibility, brdf::Visibility::Cheap);
  EXPECT_EQ(file.checks[2].options.width, 64);
  EXPECT_EQ(file.checks[2].options.platform, "rsx");
  EXPECT_EQ(file.checks[4].name, "lit") << "one variant by name does not lengthen the check's";
  EXPECT_EQ(file.checks[4].subject, "lit.hlsl");
  EXPECT_FALSE(file.checks[4].image);
  EXPECT_EQ(file.checks[4].options.defines.size(), 1u);
}

struct Mistake {
  const char* text;   // behind the schema line
  const char* place;  // "line:column"
  const char* what;
  const char* hint;
};

TEST(CheckFile, MistakesAreRefusedWhereTheyStand) {
  const Mistake mistakes[] = {
      {"chekc = 1\n", "2:1", "unknown key 'chekc'", "did you mean 'check'?"},
      {"[[check]]\nname = \"a\"\nscene = \"s.gltf\"\nvisibilty = \"cheap\"\n", "5:1",
       "unknown key 'visibilty'", "visibility"},
      {"[[check]]\nname = \"a\"\nscene = \"s.gltf\"\nvisibility = \"cheep\"\n", "5:14", "cheep", "cheap"},
      {"[[check]]\nname = \"a\"\nscene = \"s.gltf\"\nsize = \"64\"\n", "5:8", "size", ""},
      {"[[check]]\nname = \"a\"\nscene = \"s.gltf\"\nsize = [64, 36]\n", "5:8", "found an array", ""},
      {"[variant.v]\nfresnal = \"sg\"\n[[check]]\nname = \"a\"\nscene = \"s\"\n", "3:1",
       "unknown key 'fresnal'", "fresnel"},
      {"[variant.v]\nfresnel = \"gs\"\n[[check]]\nname = \"a\"\nscene = \"s\"\n", "3:11", "gs", "sg"},
      {"[variant.cheap]\n[[check]]\nname = \"a\"\nscene = \"s\"\nvariant = \"cheep\"\n", "6:11",
       "no [variant.cheep]", "cheap"},
      {"[[check]]\nscene = \"s\"\n", "2:1", "needs a name", ""},
      {"[[check]]\nname = \"a\"\n", "2:1", "needs a scene or a shader", ""},
      {"[[check]]\nname = \"a\"\nscene = \"s\"\ncost = \"x.hlsl\"\n", "2:1", "needs a scene or a shader", ""},
      {"[[check]]\nname = \"../a\"\nscene = \"s\"\n", "3:8", "cannot name a check", ""},
      {"[[check]]\nname = \"a/../b\"\nscene = \"s\"\n", "3:8", "cannot name a check", ""},
      {"[[check]]\nname = \"-a\"\nscene = \"s\"\n", "3:8", "cannot name a check", ""},
      {"[[check]]\nname = \"a\"\nscene = \"s\"\n[[check]]\nname = \"a\"\nscene = \"t\"\n", "5:1",
       "two checks are named 'a'", "2:1"},
      {"[[check]]\nname = \"a\"\nscene = []\n", "4:9", "empty list", ""},
      {"[[check]]\nname = \"a\"\nscene = \"s\"\nbudget_ms = -1\n", "5:13", "above 0", ""},
      {"[[check]]\nname = \"a\"\ncost = \"x.hlsl\"\nbudget_ms = 1\n", "5:13", "no frame time", ""},
      {"[[check]]\nname = \"a\"\nscene = \"s\"\ncompare = \"images\"\n", "5:11", "images", "image"},
      {"[[check]]\nname = \"a\"\ncost = \"x.hlsl\"\ncompare = \"image\"\n", "5:11", "no image", ""},
      {"[[check]]\nname = \"a\"\nscene = \"s\"\nstage = \"vertex\"\n", "5:9", "belongs to", ""},
      {"[[check]]\nname = \"a\"\ncost = \"x.hlsl\"\nstage = \"geometry\"\n", "5:9", "geometry", ""},
      {"[[check]]\nname = \n", "3:8", "not valid TOML", ""},
  };
  for (const Mistake& mistake : mistakes) {
    try {
      parse_check_file(kHead + mistake.text, "a.toml");
      ADD_FAILURE() << "accepted:\n" << mistake.text;
    } catch (const UserError& error) {
      const std::string text = error.what();
      EXPECT_EQ(text.find("a.toml:" + std::string(mistake.place) + ": "), 0u) << text << "\n" << mistake.text;
      EXPECT_NE(text.find(mistake.what), std::string::npos) << text;
      EXPECT_NE(error.hint().find(mistake.hint), std::string::npos) << error.hint();
    }
  }
}

TEST(CheckFile, NeedsASchemaAndAtLeastOneCheck) {
  EXPECT_THROW(parse_check_file("", "a.toml"), UserError);
  EXPECT_THROW(parse_check_file(kHead, "a.toml"), UserError);
  EXPECT_THROW(parse_check_file("schema = 2\n[[check]]\nname = \"a\"\nscene = \"s\"\n", "a.toml"), UserError);
}

}  // namespace
}  // namespace aluminate::test
