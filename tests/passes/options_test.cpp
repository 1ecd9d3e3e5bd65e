#include <gtest/gtest.h>

#include "platform/host/error.hpp"
#include "shading/passes/options.hpp"

namespace aluminate::passes {
namespace {

TEST(Options, EveryListedNameCanBeSet) {
  const std::vector<std::pair<std::string, std::string>> examples = {
      {"size", "64x48"},          {"msaa", "4"},
      {"camera", "inside"},       {"lights", "lamps:3"},
      {"ambient", "hemisphere"},  {"sky", "fc3"},
      {"time", "06:30"},          {"sun", "10,45"},
      {"polarizer", "0.5,0.8,1"}, {"background", "0,0.5,1"},
      {"pipeline", "deferred"},   {"visibility", "cheap"},
      {"fresnel", "sg"},          {"toksvig", "dxt5"},
      {"textures", "dxt"},        {"anisotropy", "8"},
      {"shadows", "on"},          {"reflections", "cube.exr"},
      {"tonemap", "reinhard"},
      {"number", "fx28"},         {"platform", "rsx"},
      {"shader", "a.hlsl"},       {"light-loop", "rolled"},
      {"vm", "interpreter"},      {"no-skip", "facing"},
      {"checked", "true"},        {"D", "A=1"}};
  ASSERT_EQ(examples.size(), option_table().size());
  for (std::size_t i = 0; i < examples.size(); ++i) {
    EXPECT_EQ(option_table()[i].name, examples[i].first);
    FrameOptions options;
    EXPECT_NO_THROW(set_option(options, examples[i].first, examples[i].second)) << examples[i].first;
  }
}

TEST(Options, AssignmentsMayHoldCommasInTheirValues) {
  FrameOptions options;
  set_options(options, "camera=1,2,3:0,0,0:45,visibility=cheap,background=0.1,0.2,0.3");
  EXPECT_EQ(options.camera, "1,2,3:0,0,0:45");
  EXPECT_EQ(options.visibility, brdf::Visibility::Cheap);
  EXPECT_EQ(options.background, glm::dvec3(0.1, 0.2, 0.3));
}

TEST(Options, NonsenseIsRefused) {
  FrameOptions options;
  for (const char* text :
       {"visibility", "visibility=", "size=10", "size=10x", "size=1e3x10000000", "ambient=flat:nan",
        "ambient=flat:-1", "lights=rig:2.5", "background=2,0,0", "D=1A", "number=fx", "sky=16", "time=24:00",
        "sun=91,0", "polarizer=1,2", "shadows=maybe", "textures=png", "anisotropy=3", "no-skip=everything",
        "nothing=1", "checked=maybe"})
    EXPECT_THROW(set_options(options, text), UserError) << text;
}

}  // namespace
}  // namespace aluminate::passes
