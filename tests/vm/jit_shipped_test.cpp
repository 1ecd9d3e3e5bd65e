// Every kind of shipped program, compiled and interpreted: the same bits and counts.
#include <gtest/gtest.h>

#include "shading/passes/programs.hpp"
#include "tests/vm/jit_agreement.hpp"

namespace aluminate::vm::testing {
namespace {

using passes::FrameOptions;
using passes::SurfaceFeatures;

void expect_same(const Program& program, const char* format_name = "fx31") {
  JitCoverage coverage;
  for (std::uint64_t seed : {1, 2}) {
    JitCase c;
    c.seed = seed;
    c.format = format_name;
    c.numbers = seed == 1 ? Numbers::Tame : Numbers::Hostile;
    c.options.assume = seed == 1 ? Assume::Typical : Assume::Nothing;
    const std::string difference = compare_tiers(program, c, coverage);
    ASSERT_TRUE(difference.empty()) << program.name << ": " << difference;
  }
  EXPECT_EQ(coverage.refused, 0);
}

SurfaceFeatures textured() {
  SurfaceFeatures f;
  for (const auto map : {passes::kBaseColorMap, passes::kMetallicRoughnessMap, passes::kNormalMap, passes::kOcclusionMap, passes::kEmissiveMap})
    f.maps[map] = true;
  return f;
}

TEST(JitShipped, EveryVisibilityAndFresnelTerm) {
  for (const char* visibility : {"none", "schlick-smith", "integrated", "cheap"})
    for (const char* fresnel : {"schlick", "sg", "sg-lagarde"}) {
      FrameOptions options;
      passes::set_option(options, "visibility", visibility);
      passes::set_option(options, "fresnel", fresnel);
      expect_same(passes::compile_pixel(options, {}, {1, false}, false));
      expect_same(passes::compile_eval_brdf(options.visibility, options.fresnel));
    }
}

TEST(JitShipped, SurfacesLightsAndFormats) {
  const FrameOptions options;
  expect_same(passes::compile_pixel(options, textured(), {4, false}, false));
  expect_same(passes::compile_pixel(options, textured(), {16, false}, true));
  expect_same(passes::compile_pixel(options, {}, {2, true}, false));
  SurfaceFeatures masked = textured();
  masked.alpha_mask = masked.double_sided = masked.vertex_color = true;
  expect_same(passes::compile_pixel(options, masked, {2, false}, true));
  SurfaceFeatures glossy;
  glossy.specular_glossiness = true;
  expect_same(passes::compile_pixel(options, glossy, {1, false}, false));
  SurfaceFeatures unlit;
  unlit.unlit = true;
  expect_same(passes::compile_pixel(options, unlit, {0, false}, false));
  for (const char* name : {"fx24", "fx40", "q16.16", "q8.24", "ref64"})
    expect_same(passes::compile_pixel(options, textured(), {1, false}, false), name);
}

TEST(JitShipped, VerticesAndToneMaps) {
  expect_same(passes::compile_vertex({}));
  expect_same(passes::compile_vertex(textured()));
  expect_same(passes::compile_tonemap(passes::Tonemap::Reinhard));
  expect_same(passes::compile_tonemap(passes::Tonemap::Filmic));
}

}  // namespace
}  // namespace aluminate::vm::testing
