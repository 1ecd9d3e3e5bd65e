// Shaders whose Direct3D 9 instruction counts are printed in public microcode listings.
#include "tests/compiler/shader_runner.hpp"

#include <filesystem>

namespace aluminate::compiler::testing {
namespace {

struct Published {
  const char* name;
  int d3d9_alu, output_moves;
};

// The period compiler moved the finished colour to oC0 in an instruction of its own; ours writes the output
// where the last operation allows it. output_moves is that difference.
constexpr Published kPublished[] = {
    {"add_constant", 2, 1}, {"tinted_particle", 8, 1}, {"soft_additive", 4, 1}, {"toon_cube", 5, 1}};

TEST(PublishedFigures, SlotsAgreeExceptForTheMoveToTheOutput) {
  if (!std::filesystem::exists(ALUMINATE_SHARED_DIR "/xenos/add_constant.hlsl"))
    GTEST_SKIP() << "the public shaders are not there";
  for (const Published& shader : kPublished) {
    Options o;
    o.source_path = std::string(ALUMINATE_SHARED_DIR "/xenos/") + shader.name + ".hlsl";
    EXPECT_EQ(slots(compile_valid(o)) + shader.output_moves, shader.d3d9_alu) << shader.name;
  }
}

TEST(PublishedFigures, BumpedSpecularStaysBelowThePeriodCompiler) {
  if (!std::filesystem::exists(ALUMINATE_SHARED_DIR "/xenos/bumpspec_dir.hlsl"))
    GTEST_SKIP() << "the public shaders are not there";
  Options o;
  o.source_path = ALUMINATE_SHARED_DIR "/xenos/bumpspec_dir.hlsl";
  // 25 were printed. As written: mad, 2 mad, sqrt (2), dp3, max, mul, log, mul, exp, mul, dp3, max, 2 mul,
  // mad, mul, mad, mov.
  EXPECT_EQ(slots(compile_valid(o)), 20);
}

}  // namespace
}  // namespace aluminate::compiler::testing
