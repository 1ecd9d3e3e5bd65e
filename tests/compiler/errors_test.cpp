// What is refused, by which name, at which place, with which hint.
#include "tests/compiler/shader_runner.hpp"

#include <filesystem>
#include <fstream>

namespace aluminate::compiler::testing {
namespace {

struct Refusal {
  const char* text;
  int line, column;  // 0 = not checked
  const char *what, *hint;
};

void expect_refused(const Refusal& r, Language language) {
  SCOPED_TRACE(r.text);
  try {
    compile(options_for(r.text, language));
    ADD_FAILURE() << "accepted";
  } catch (const UserError& e) {
    EXPECT_EQ(e.place().file, language == Language::Hlsl ? "test.hlsl" : "test.frag") << e.what();
    if (r.line > 0) {
      EXPECT_EQ(e.place().line, r.line) << e.what();
    }
    if (r.column > 0) {
      EXPECT_EQ(e.place().column, r.column) << e.what();
    }
    EXPECT_NE(std::string(e.what()).find(r.what), std::string::npos) << e.what();
    EXPECT_NE(e.hint().find(r.hint), std::string::npos) << e.what() << "\nhint: " << e.hint();
  }
}

TEST(Errors, HlslMistakesNameTheirPlace) {
  const Refusal refusals[] = {
      {"float4 main() : COLOR0 { return foo(1); }", 1, 33, "'foo'", "check the name"},
      {"float4 main() : COLOR0 {\n  float a = b + 1;\n  return a; }", 2, 13, "'b'", "declare it"},
      {"float4 main() : COLOR0 { return float4(1,2,3,4) }", 1, 0, "expected ';'", "semicolon"},
      {"sampler2D s;\nfloat4 main() : COLOR0 { return tex2D(s, 1, 2, 3, 4, 5); }", 2, 33, "'tex2D'",
       "gradients"},
      {"sampler2D s;\nfloat4 main(float2 t : TEXCOORD0) : COLOR0 { return tex2Dlod(s, t); }", 2, 53,
       "'tex2Dlod'", "float4"},
      {"float4 f(float4 x) { return f(x); }\nfloat4 main() : COLOR0 { return f(1); }", 0, 0, "ecursi", ""},
      {"float4 other() : COLOR0 { return 1; }", 0, 0, "entry point not found", "--entry"},
      {"#line 40\nfloat4 main() : COLOR0 { return q; }", 40, 0, "'q'", "declare it"},
      {"#error no good\nfloat4 main() : COLOR0 { return 1; }", 1, 0, "no good", ""},
      {"", 0, 0, "empty", ""},
      {"/* not closed", 1, 0, "comment", ""},
  };
  for (const Refusal& r : refusals) expect_refused(r, Language::Hlsl);
}

TEST(Errors, EffectSyntaxIsRefusedWithAWayOut) {
  const Refusal refusals[] = {
      {"float4 main() : COLOR0 { return 1; }\ntechnique T { pass P { PixelShader = compile ps_3_0 main(); } "
       "}",
       2, 1, "technique", "--entry"},
      {"texture t;\nfloat4 main() : COLOR0 { return 1; }", 1, 1, "texture", "sampler2D"},
      {"sampler2D s = sampler_state { MinFilter = Linear; };\nfloat4 main() : COLOR0 { return 1; }", 1, 15,
       "sampler_state", "sampler2D"},
      {"float4 main(float2 u : TEXCOORD0) : COLOR0 { float4 r; asm { tfetch2D r, u, s }; return r; }", 1, 56,
       "asm", "tex2D"},
  };
  for (const Refusal& r : refusals) expect_refused(r, Language::Hlsl);
}

TEST(Errors, UnsupportedOperationsAreNamed) {
  const Refusal hlsl[] = {
      {"Texture2D t; float4 main(float2 u : TEXCOORD0) : COLOR0 {\n return t.Load(int3(u, 0)); }", 2, 0,
       "OpImageFetch", "tex2Dlod"},
      {"Texture2D t; SamplerState s; float4 main(float2 u : TEXCOORD0) : COLOR0 {\n return t.Gather(s, u); }",
       2, 0, "OpImageGather", "one by one"},
      {"Texture2D t; SamplerState s; float4 main(float2 u : TEXCOORD0) : COLOR0 {\n return t.Sample(s, u, "
       "int2(1, 0)); }",
       2, 0, "offset", "coordinates"},
      {"Texture2DArray t; SamplerState s; float4 main(float3 u : TEXCOORD0) : COLOR0 {\n return t.Sample(s, "
       "u); }",
       2, 0, "kind of texture", "2D, 3D or cube"},
      {"float4 main(float4 u : TEXCOORD0) : COLOR0 {\n int i = (int)u.x | (int)u.y; return i; }", 2, 0,
       "OpBitwiseOr", "arithmetic"},
      {"float4 main(float4 u : TEXCOORD0) : COLOR0 {\n return asuint(u.x) & 255; }", 2, 0, "OpBitcast",
       "bit patterns"},
      {"float4 main(float4 u : TEXCOORD0) : COLOR0 {\n return determinant(float2x2(u)); }", 2, 0,
       "Determinant", "outside"},
      {"RWTexture2D<float4> t; float4 main(float2 u : TEXCOORD0) : COLOR0 {\n t[int2(u)] = 1; return 1; }", 0,
       0, "OpImageWrite", ""},
      {"float4 main(uint id : SV_PrimitiveID) : COLOR0 { return id; }", 0, 0, "input", "VPOS"},
  };
  for (const Refusal& r : hlsl) expect_refused(r, Language::Hlsl);
  const Refusal glsl[] = {
      {"#version 450\nlayout(location = 0) out vec4 c;\nuniform sampler2D s;\nvoid main() { c = "
       "texelFetch(s, ivec2(1), 0); }",
       4, 0, "OpImageFetch", "tex2Dlod"},
      {"#version 450\nlayout(location = 0) out vec4 c;\nlayout(location = 0) in vec4 v;\nvoid main() { c = "
       "vec4(inverse(mat2(v.x, v.y, v.z, v.w))[0], 0, 1); }",
       4, 0, "MatrixInverse", "outside"},
      {"#version 450\nvoid main() { foo(); }", 2, 15, "'foo'", ""},
      {"#version 450\nvoid main() { int a = 1 +; }", 2, 0, "syntax error", ""},
  };
  for (const Refusal& r : glsl) expect_refused(r, Language::Glsl);
}

TEST(Errors, IncludesCarryTheirOwnName) {
  Options o = options_for("#include \"broken.hlsl\"\nfloat4 main() : COLOR0 { return value(); }");
  o.files["broken.hlsl"] = "\n\nfloat4 value() { return missing; }\n";
  try {
    compile(o);
    FAIL() << "accepted";
  } catch (const UserError& e) {
    EXPECT_EQ(e.place().file, "broken.hlsl") << e.what();
    EXPECT_EQ(e.place().line, 3) << e.what();
    EXPECT_EQ(e.place().column, 25) << e.what();
  }
  o.files.clear();
  try {
    compile(o);
    FAIL() << "accepted";
  } catch (const UserError& e) {
    EXPECT_NE(std::string(e.what()).find("broken.hlsl"), std::string::npos) << e.what();
    EXPECT_NE(e.hint().find("include"), std::string::npos);
  }
}

TEST(Errors, EndlessIncludesStop) {
  Options o = options_for("#include \"a.hlsl\"\nfloat4 main() : COLOR0 { return 1; }");
  o.files["a.hlsl"] = "#include \"a.hlsl\"\n";
  EXPECT_THROW(compile(o), UserError);
}

TEST(Errors, SpecialisationConstantsAreNamed) {
  Options o =
      options_for("[[vk::constant_id(3)]] const int MODE = 0; float4 main() : COLOR0 { return MODE; }");
  o.spec_constants = {{"MOOD", 1}};
  try {
    compile(o);
    FAIL() << "accepted";
  } catch (const UserError& e) {
    EXPECT_NE(std::string(e.what()).find("MOOD"), std::string::npos);
    EXPECT_NE(e.hint().find("MODE (3)"), std::string::npos) << e.hint();
  }
}

TEST(Errors, FilesThatAreNotShaders) {
  Options o;
  o.source_path = "missing.hlsl";
  EXPECT_THROW(compile(o), UserError);
  o.source_path = "shader.txt";
  o.source = "void main() {}";
  EXPECT_THROW(compile(o), UserError);
  o.source_path = ALUMINATE_SOURCE_DIR;
  o.source.reset();
  o.language = Language::Hlsl;
  EXPECT_THROW(compile(o), UserError);
  o = options_for("float4 main() : COLOR0 { return 1; }");
  o.defines = {{"not a name", "1"}};
  EXPECT_THROW(compile(o), UserError);
}

}  // namespace
}  // namespace aluminate::compiler::testing
