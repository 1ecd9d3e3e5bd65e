// Instruction counts against hand counts. The Far Cry 3 shader is counted statement by statement in its own
// comments.
#include "tests/compiler/shader_runner.hpp"

namespace aluminate::compiler::testing {
namespace {

vm::Program fc3(const char* file, LoopMode loops, int lights, int visibility, int fresnel) {
  Options o;
  o.source_path = std::string(ALUMINATE_SOURCE_DIR "/tests/compiler/") + file;
  o.loops = loops;
  o.defines = {{"LIGHTS", std::to_string(lights)},
               {"VISIBILITY", std::to_string(visibility)},
               {"FRESNEL", std::to_string(fresnel)}};
  return compile_valid(o);
}

class Fc3 : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Languages, Fc3, ::testing::Values("fc3_reference.hlsl", "fc3_reference.frag"),
                         [](const auto& i) {
                           return std::string(i.param).ends_with("hlsl") ? "Hlsl" : "Glsl";
                         });

struct Expected {
  int visibility, rolled, unrolled, fixed;
};
// none, cheap, schlick-smith with Schlick's Fresnel; schlick-smith costs 8 more rolled, 4 per light and 5
// once unrolled
constexpr Expected kExpected[] = {{0, 28, 26, 45}, {1, 28, 26, 45}, {2, 36, 30, 50}};

TEST_P(Fc3, RolledLoopBodyCostsWhatTheHandCountSays) {
  for (const Expected& e : kExpected)
    for (int fresnel : {0, 1})  // the spherical gaussian saves one
      EXPECT_EQ(loop_slots(fc3(GetParam(), LoopMode::Rolled, 4, e.visibility, fresnel)), e.rolled - fresnel)
          << "visibility " << e.visibility << " fresnel " << fresnel;
}

TEST_P(Fc3, UnrolledTotalsCostWhatTheHandCountSays) {
  for (const Expected& e : kExpected)
    for (int fresnel : {0, 1})
      for (int lights : {1, 2, 3, 4, 8}) {
        // With one light v has a single use, unless n.v reads it too: one product less.
        const int fused = lights == 1 ? 1 : 0;
        const vm::Program p = fc3(GetParam(), LoopMode::Unrolled, lights, e.visibility, fresnel);
        const int expected = e.fixed + lights * (e.unrolled - fresnel) - (e.visibility == 2 ? 0 : fused);
        EXPECT_EQ(slots(p), expected)
            << "visibility " << e.visibility << " fresnel " << fresnel << " lights " << lights;
        EXPECT_EQ(count(p, vm::Opcode::Tex), 3);
        EXPECT_TRUE(p.straight_line());
      }
}

TEST_P(Fc3, RolledModeIgnoresNothingButTheTripCount) {
  for (const Expected& e : kExpected)
    EXPECT_EQ(slots(fc3(GetParam(), LoopMode::Rolled, 1, e.visibility, 0)),
              slots(fc3(GetParam(), LoopMode::Rolled, 8, e.visibility, 0)));
}

TEST(Fc3Hlsl, RolledModeKeepsLoopsMarkedUnroll) {
  Options o;
  o.source_path = ALUMINATE_SOURCE_DIR "/tests/compiler/fc3_reference.hlsl";
  o.defines = {{"UNROLL", "1"}, {"VISIBILITY", "2"}};
  o.loops = LoopMode::Rolled;
  EXPECT_EQ(loop_slots(compile_valid(o)), 36);
  o.loops = LoopMode::AsWritten;
  EXPECT_EQ(slots(compile_valid(o)), 170);
  o.defines.erase(o.defines.begin());
  EXPECT_EQ(loop_slots(compile_valid(o)), 36);
}

int slots_of(const std::string& expression, const std::string& type) {
  const std::string text = type + " x : TEXCOORD0, " + type + " y : TEXCOORD1) : COLOR0 { " + type +
                           " r = " + expression + "; return float4(r" +
                           (type == "float3" ? ".xyz, 0" : ", 0, 0, 0") + "); }";
  return slots(compile_valid(options_for("float4 main(" + text)));
}

TEST(ConstantFolding, AffineTimesConstantIsOneMadHoweverItIsWritten) {
  for (const std::string type : {"float", "float3"}) {
    const int one_mad = slots_of("x * 0.3 + 0.7", type);
    for (const char* same :
         {"(x + 2) * 0.3", "(2 * x + 1) * 0.3", "(x + 2) / 8", "(2 * x + 1) / 8", "0.3 * (2 + x)",
          "(x * 3 + 1) * 2 + 0", "((x + 1) * 2 + 3) / 4", "(1 - 2 * x) * 0.3", "(3 - x) / 7",
          "-(x + 2) * 0.3", "(x * 2) * 3 + 1", "x * 2 + 1 + 5"})
      EXPECT_EQ(slots_of(same, type), one_mad) << type << " " << same;
  }
}

TEST(ConstantFolding, LazarovShapesCostTheSameBehindAVariable) {
  EXPECT_EQ(slots_of("(exp2(13 * x) + 2) / 8 * y", "float"),
            slots_of("(2 * exp2(13 * x) + 1) / 8 * y", "float"));
}

struct Idiom {
  const char *expression, *opcodes;
};

TEST(Idioms, CompileToTheInstructionsOfThePeriod) {
  // x, y: float3 inputs; the last mov (alpha) is not listed
  static constexpr Idiom kIdioms[] = {
      {"x * y", "mul"},
      {"x * y + x", "mad"},
      {"x - y * x", "mad"},
      {"saturate(x)", "mov_sat"},
      {"saturate(x * y + 1)", "mad_sat"},
      {"min(max(x * y, 0), 1)", "mul_sat"},
      {"max(min(x * y, 1), 0)", "mul_sat"},
      {"clamp(x + y, 0, 1)", "add_sat"},
      {"saturate(-dot(x, y)) * y", "dp3_sat mul"},
      {"dot(x.xy, y.xy) * y", "dp2add mul"},
      {"(dot(x.xy, y.xy) + y.z) * y", "dp2add mul"},
      {"normalize(x)", "dp3 rsq mul"},
      {"x / length(x)", "dp3 rsq mul"},
      {"x * (1 / sqrt(y.x))", "rsq mul"},
      {"x / y.x", "rcp mul"},
      {"x / y", "rcp rcp rcp mul"},
      {"length(x) * y", "dp3 sqrt mul"},
      {"lerp(x, y, 0.3)", "add mad"},
      {"lerp(x, y, y.z)", "add mad"},
      {"pow(x.x, y.x) * y", "log mul exp mul"},
      {"pow(x, 2)", "mul"},
      {"pow(x, 4)", "mul mul"},
      {"pow(x.x, 5) * y", "mul mul mul mul"},
      {"cross(x, y)", "mul mad"},
      {"reflect(x, y)", "dp3 mul mad"},
      {"abs(x) + abs(y)", "add"},
      {"-x + -y", "add"},
      {"x.x < 0 ? x : y", "cndgt"},
      {"x.x >= 0 ? x : y", "cndge"},
      {"x.x > y.x ? x : y", "add cndgt"},
      {"x.x == 0 ? x : y", "cndeq"},
      {"step(y, x)", "sge"},
      {"frac(x)", "frc"},
      {"exp(x.x) * y", "mul exp mul"},
      {"exp(-6 * x.x) * y", "mul exp mul"},
      {"x * 2 * 3 * y", "mul mul"},
      {"float3(x.z, x.x, x.y) * y.zzz", "mul"},
      {"x * 0 + y * 1", "mov"},
  };
  for (const Idiom& idiom : kIdioms) {
    const vm::Program p = compile_valid(options_for(
        std::string("float4 main(float3 x : TEXCOORD0, float3 y : TEXCOORD1) : COLOR0 { return float4(") +
        idiom.expression + ", 0); }"));
    std::string opcodes;
    for (const auto& i : p.code) {
      if (i.dst.file == vm::RegisterFile::Output && i.dst.mask == 8) continue;
      opcodes +=
          (opcodes.empty() ? "" : " ") + std::string(vm::info(i.op).mnemonic) + (i.saturate ? "_sat" : "");
    }
    EXPECT_EQ(opcodes, idiom.opcodes) << idiom.expression << "\n" << listing(p);
  }
}

TEST(Idioms, MatricesReadRegistersAsTheyLie) {
  const auto ops = [](const std::string& product) {
    const vm::Program p = compile_valid(
        options_for("float4x4 m; row_major float4x4 r; float4 main(float4 v : TEXCOORD0) : COLOR0 { return " +
                    product + "; }"));
    std::string text;
    for (const auto& i : p.code) text += std::string(vm::info(i.op).mnemonic) + " ";
    return text;
  };
  EXPECT_EQ(ops("mul(v, m)"), "dp4 dp4 dp4 dp4 ");
  EXPECT_EQ(ops("mul(m, v)"), "mul mad mad mad ");
  EXPECT_EQ(ops("mul(r, v)"), "dp4 dp4 dp4 dp4 ");
  EXPECT_EQ(ops("mul(v, r)"), "mul mad mad mad ");
  EXPECT_EQ(ops("mul(m, float4(v.xyz, 1))"), "mul mad mad add ");
}

TEST(Idioms, ClipIsOneKill) {
  const vm::Program p =
      compile_valid(options_for("float4 main(float4 v : TEXCOORD0) : COLOR0 { clip(v.a - 0.5); return v; }"));
  EXPECT_EQ(count(p, vm::Opcode::KillGt), 1) << listing(p);
  EXPECT_EQ(count(p, vm::Opcode::If), 0);
  EXPECT_TRUE(p.straight_line());
}

TEST(SpecialisationConstants, ReachTheCountsOfTheDefines) {
  const std::string hlsl_body =
      "float4 main(float4 v : TEXCOORD0, float3 n : TEXCOORD1) : COLOR0 {\n"
      "  float m = exp2(13 * v.a); float d = 0; float nl = saturate(dot(n, v.xyz));\n"
      "  if (MODE == 0) d = (m + 2) / 8; else if (MODE == 1) d = (2 * m + 1) / 8; else { float a = 1 / "
      "sqrt(m * 0.5 + 1); d = (m + 2) / 8 / (nl * (1 - a) + a); }\n"
      "  float3 sum = v.rgb; for (int i = 0; i < COUNT; i++) sum += d * n * v.x; return float4(sum, d); }\n";
  const std::string glsl_body =
      "layout(location = 0) in vec4 v; layout(location = 1) in vec3 n; layout(location = 0) out vec4 color;\n"
      "void main() {\n"
      "  float m = exp2(13 * v.a); float d = 0; float nl = clamp(dot(n, v.xyz), 0, 1);\n"
      "  if (MODE == 0) d = (m + 2) / 8; else if (MODE == 1) d = (2 * m + 1) / 8; else { float a = 1 / "
      "sqrt(m * 0.5 + 1); d = (m + 2) / 8 / (nl * (1 - a) + a); }\n"
      "  vec3 sum = v.rgb; for (int i = 0; i < COUNT; i++) sum += d * n * v.x; color = vec4(sum, d); }\n";
  for (const Language language : {Language::Hlsl, Language::Glsl})
    for (int mode : {0, 1, 2}) {
      const bool hlsl = language == Language::Hlsl;
      Options defined = options_for((hlsl ? "" : "#version 450\n") + (hlsl ? hlsl_body : glsl_body), language,
                                    LoopMode::Unrolled);
      defined.defines = {{"MODE", std::to_string(mode)}, {"COUNT", "3"}};
      const std::string declared =
          hlsl ? "[[vk::constant_id(0)]] const int MODE = 0; [[vk::constant_id(7)]] const int COUNT = 1;\n"
               : "layout(constant_id = 0) const int MODE = 0; layout(constant_id = 7) const int COUNT = 1;\n";
      Options specialised =
          options_for((hlsl ? "" : "#version 450\n") + declared + (hlsl ? hlsl_body : glsl_body), language,
                      LoopMode::Unrolled);
      specialised.spec_constants = {{"0", mode}, {"COUNT", 3}};
      const vm::Program a = compile_valid(defined), b = compile_valid(specialised);
      EXPECT_EQ(slots(a), slots(b)) << "mode " << mode << "\n" << listing(a) << "\n" << listing(b);
      EXPECT_TRUE(b.straight_line());
    }
}

TEST(Lines, EveryInstructionKnowsItsLine) {
  const vm::Program p = fc3("fc3_reference.hlsl", LoopMode::Unrolled, 4, 2, 0);
  for (const auto& i : p.code) {
    ASSERT_GT(i.line.line, 0u) << vm::disassemble(p, i);
    ASSERT_LT(i.line.file, p.files.size());
  }
  EXPECT_TRUE(p.files[p.code[0].line.file].ends_with("fc3_reference.hlsl"));
}

}  // namespace
}  // namespace aluminate::compiler::testing
