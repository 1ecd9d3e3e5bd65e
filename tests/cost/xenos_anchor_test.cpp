// Five public shaders with the figures the console's own compiler printed or its microcode shows. Programs
// are written by hand here, in the shape a compiler gives them; the compiled HLSL is compared elsewhere in
// this folder.
#include "platform/console/platform_file.hpp"
#include "shading/cost/static_cost.hpp"
#include "tests/cost/program_builder.hpp"

#include <gtest/gtest.h>

namespace aluminate::test {
namespace {

struct Anchor {
  const char* name;
  const char* text;
  int words, fetches;
  double sequencer, interpolator;
  int gprs, per_vector;
};

const Anchor kAnchors[] = {
    {"add_constant", R"(
in TEXCOORD0 xy
out COLOR0 xyzw
uniform offset0 1
sampler tex0 2d
tex r0, v0.xy, s0
add r1, r0, c0.xxxx
mov o0, r1
)",
     1, 1, 6, 8, 1, 8},
    {"tinted_particle", R"(
in COLOR0 xyzw
in TEXCOORD0 xy
out COLOR0 xyzw
uniform tint 4
sampler tex0 2d
lit 2 1 0 0
tex r0, v1.xy, s0
mul r1.xyz, r0, c0
mul r1.xyz, v0, r1
mul o0.xyz, r1, l0.xxxx
mul r2.x, v0.w, c0.w
add r2.y, l0.y, -r0.w
mul r2.x, r2.x, r2.y
mul o0.w, r2.x, l0.x
)",
     5, 1, 6, 16, 3, 16},
    {"soft_additive", R"(
in COLOR0 xyzw
in TEXCOORD0 xy
out COLOR0 xyzw
sampler tex0 2d
tex r0, v1.xy, s0
mul r1, v0, r0
mul r2.xyz, r1, r1.wwww
mov o0.xyz, r2
mov o0.w, r1
)",
     4, 1, 6, 16, 2, 16},
    {"toon_cube", R"(
in TEXCOORD0 xy
in TEXCOORD1 xyz
out COLOR0 xyzw
uniform baseColor 4
sampler tex0 2d
sampler ramp cube
lit 2 0 0 0
tex r0, v0.xy, s0
mul r0, r0, c0
tex r1, v1.xyz, s1
mul r2.xyz, r1, r0
mul o0.xyz, r2, l0.xxxx
mov o0.w, r0.w
)",
     6, 2, 6, 8, 3, 8},
    {"bumpspec_dir", R"(
in TEXCOORD0 xy
in TEXCOORD1 xyz
in TEXCOORD2 xyz
in TEXCOORD3 xyz
out COLOR0 xyzw
uniform lightColor 4
uniform shininess 1
sampler tex0 2d
sampler bumpTex 2d
lit 2 -1 1 0
lit 128 0 0 0
tex r0, v0.xy, s0
tex r1, v0.xy, s1
mad r2.xy, r1.wyyy, l0.xxxx, l0.yyyy
mad r3.x, -r2.x, r2.x, l0.z
mad r3.x, -r2.y, r2.y, r3.x
sqrt r2.z, r3.x
dp3 r4.x, r2, v1
max r4.x, r4.x, l0.w
log r4.x, r4.x
mul r4.y, c1.x, l1.x
mul r4.x, r4.x, r4.y
exp r4.x, r4.x
mul r4.x, r4.x, r0.w
dp3 r4.z, r2, v2
max r4.z, r4.z, l0.w
mul r5.xyz, r0, c0
mul r5.xyz, r5, r4.zzzz
mad r5.xyz, c0, r4.xxxx, r5
mul r5.xyz, r5, l0.xxxx
mad o0.xyz, r0, v3, r5
mov o0.w, l0.w
)",
     14, 2, 10, 16, 5, 18},
};

class XenosAnchor : public ::testing::TestWithParam<Anchor> {};

TEST_P(XenosAnchor, MatchesThePeriodCompiler) {
  const Anchor& anchor = GetParam();
  const vm::Program program = program_from_text(anchor.text, anchor.name);
  const cost::StaticCost cost = cost::price(program, console::load_platform("xenos"));
  std::string listing;
  for (const cost::ListingRow& row : cost.listing)
    listing += std::to_string(row.word) + " " + row.pipe + " " + row.text + "\n";
  SCOPED_TRACE(listing);
  EXPECT_EQ(cost.fetches, anchor.fetches);
  // One word or a tenth: the bound the reference figures are meant to hold to.
  EXPECT_LE(std::abs(cost.alu_words - anchor.words), std::max(1.0, 0.1 * anchor.words))
      << cost.alu_words << " words";
  EXPECT_EQ(cost.cycles.sequencer, anchor.sequencer);
  EXPECT_EQ(cost.cycles.interpolator, anchor.interpolator);
  EXPECT_LE(std::abs(cost.gprs - anchor.gprs), 2) << cost.gprs << " registers";
  if (cost.alu_words == anchor.words) {
    EXPECT_EQ(cost.cycles_per_vector, anchor.per_vector);
  }
}

INSTANTIATE_TEST_SUITE_P(Shaders, XenosAnchor, ::testing::ValuesIn(kAnchors),
                         [](const auto& anchor) { return std::string(anchor.param.name); });

}  // namespace
}  // namespace aluminate::test
