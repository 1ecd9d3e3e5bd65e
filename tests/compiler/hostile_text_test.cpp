// Text made to break parsers ends in a UserError, never in a crash and never in an internal error.
#include "tests/compiler/shader_runner.hpp"

#include <random>

namespace aluminate::compiler::testing {
namespace {

std::string repeated(const std::string& s, int n) {
  std::string r;
  for (int i = 0; i < n; ++i) r += s;
  return r;
}

void expect_survives(const std::string& text, Language language, const std::string& what) {
  SCOPED_TRACE(what);
  Options o = options_for(text, language);
  if (language == Language::Spirv) o.source_path = "test.spv";
  try {
    compile(o);
  } catch (const UserError& e) {
    EXPECT_NE(std::string(e.what()), "");
  } catch (const std::exception& e) {
    ADD_FAILURE() << e.what();
  }
}

TEST(HostileText, EndsInAnErrorMessage) {
  const std::string in = "float4 main(float4 v : TEXCOORD0) : COLOR0 { ", out = " }";
  const std::pair<std::string, std::string> texts[] = {
      {"nothing", ""},
      {"blank", " \n\t\n"},
      {"megabyte", repeated("x1 { ;; \" @ $ ` \\ \n", 60000)},
      {"open brackets", in + "return " + repeated("(", 100000)},
      {"open braces", in + repeated("{", 100000)},
      {"prefix operators", in + "return " + repeated("- ", 100000) + "v;" + out},
      {"conditionals", in + "return " + repeated("v.x ? v : ", 30000) + "v;" + out},
      {"sum", in + "return v" + repeated("+v", 15000) + ";" + out},
      {"else if", in + repeated("if (v.x > 1) return v; else ", 3000) + "return v;" + out},
      {"ifs", in + repeated("if (v.x > 1) ", 3000) + "return v; return v;" + out},
      {"nested ifs",
       in + repeated("if (v.x > 1) {", 190) + "return v;" + repeated("}", 190) + "return v * 2;" + out},
      {"comment", "/* " + in},
      {"string", "float4 main() : COLOR0 { return \"abc"},
      {"zero", std::string("float4 main() : COLOR0 { return 1; }\0 x", 39)},
      {"self macro", "#define A A A\n" + in + "return A;" + out},
      {"directive", "#if 1\n#if 1\n#if"},
      {"endless array", "float4 a[1000000000];\n" + in + "return a[3];" + out},
      {"endless local",
       in + "float a[100000]; for (int i = 0; i < 100000; i++) a[i] = v.x * i; return a[(int)v.y];" + out},
      {"huge unroll",
       in + "float r = 0; [unroll] for (int i = 0; i < 60000; i++) r += sin(v.x * i); return r;" + out},
      {"division by zero", in + "return v / 0 + 1 % 0;" + out},
      {"infinity", in + "return v * (1e38 * 1e38);" + out},
      {"not a number", in + "return v * sqrt(-1.0) + log(0.0);" + out},
      {"empty struct", "struct S {}; " + in + "S s; return v;" + out},
      {"endless loop", in + "while (true) { v += 1; } return v;" + out},
      {"uninitialised", in + "float4 r; if (v.x > 0) r = v; return r;" + out},
      {"no result", "void main() {}"},
  };
  for (const auto& [what, text] : texts) {
    expect_survives(text, Language::Hlsl, what + " HLSL");
    expect_survives("#version 450\n" + text, Language::Glsl, what + " GLSL");
    expect_survives(text, Language::Spirv, what + " SPIR-V");
  }
}

std::string refusal(const std::string& text) {
  try {
    compile(options_for(text));
  } catch (const UserError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(HostileText, LimitsAreNamedBeforeTheyAreFelt) {
  const std::string in = "float4 main(float4 v : TEXCOORD0) : COLOR0 { ", out = " return v; }";
  const auto many = [](int n, const std::function<std::string(int)>& f) {
    std::string s;
    for (int i = 0; i < n; ++i) s += f(i);
    return s;
  };
  const auto number = [](int i) { return std::to_string(i); };
  const std::pair<std::string, std::string> cases[] = {
      {"#define A0 v+v\n" + many(29, [&](int i) { return "#define A" + number(i + 1) + " A" + number(i) + "+A" + number(i) + "\n"; }) +
           in + "v = A29;" + out,
       "words and signs with its macros expanded"},
      {"#define F(x) ((x) + (x) + (x))\n" + in + "v = " + repeated("F(", 20) + "v" + repeated(")", 20) + ";" + out,
       "words and signs with its macros expanded"},
      {"float4 f0(float4 x) { return x * x; }\n" +
           many(24, [&](int i) { return "float4 f" + number(i + 1) + "(float4 x) { return f" + number(i) + "(x) + f" + number(i) + "(x * 2); }\n"; }) +
           in + "v = f24(v);" + out,
       "calls inlined"},
      {in + many(401, [&](int i) { return "if (v.x > " + number(i) + ") v = v.yzwx + 1;\n"; }) + out,
       "ifs, switches and loops"},
      {in + many(131, [&](int i) { return "if (v.x > " + number(i) + ") "; }) + "v = 0;" + out, "test.hlsl:1:"},
      {in + many(64, [&](int i) { return "[branch] if (v.x > " + number(i) + ") { v.y = v.y * v.z + " + number(i) + ";\n"; }) + repeated("}", 64) + out,
       "test.hlsl:64: ifs and loops are nested deeper than 63"},
      {in + "\n[loop] for (int i = 0; i < 60000; i++)\n [loop] for (int j = 0; j < 60000; j++) v = v * v + 1;" + out,
       "one pixel would run more than"},
      {"struct S0 { float4 a[8]; };\n" +
           many(11, [&](int i) { return "struct S" + number(i + 1) + " { S" + number(i) + " a, b, c, d; };\n"; }) + "S11 u;\n" + in +
           "v = u" + repeated(".a", 12) + "[0];" + out,
       "a type of"},
  };
  for (const auto& [text, what] : cases) {
    const std::string is = refusal(text);
    EXPECT_NE(is.find(what), std::string::npos) << is.substr(0, 300) << "\n" << text.substr(0, 200);
  }
}

TEST(HostileText, WhatLooksDeepButIsNotCompiles) {
  const std::string in = "float4 main(float4 v : TEXCOORD0) : COLOR0 { ", out = " return v; }";
  std::string ifs, chain, macros = "#define SQR(x) ((x) * (x))\n#define NAME float4\n";
  for (int i = 0; i < 150; ++i) ifs += "if (v.x > " + std::to_string(i) + ") { v = v.yzwx + 1; } else v.x += 2;\n";
  for (int i = 0; i < 50; ++i) chain += "if (v.x > " + std::to_string(i) + ") v.y += 1; else ";
  EXPECT_EQ(refusal(in + ifs + out), "accepted");
  EXPECT_EQ(refusal(in + chain + "v.z = 1;" + out), "accepted");
  EXPECT_EQ(refusal(macros + in + "v = SQR(SQR(SQR(v))) + NAME(1, 2, 3, 4);" + out), "accepted");
}

TEST(HostileText, DamagedSourceNeverCrashes) {
  Options o;
  const std::string good =
      "sampler2D s; float4 c[4]; struct I { float2 uv : TEXCOORD0; float3 n : TEXCOORD1; };\n"
      "float4 main(I i) : COLOR0 { float4 t = tex2D(s, i.uv); float3 r = 0; for (int k = 0; k < 4; k++) { if "
      "(dot(i.n, c[k].xyz) < 0) continue; r += c[k].rgb * pow(t.a, 5); }\n"
      "if (t.a < 0.5) discard; return float4(normalize(r), c[(int)t.x].w); }";
  std::mt19937 random(7);
  for (int trial = 0; trial < 300; ++trial) {
    std::string text = good;
    const int edits = 1 + static_cast<int>(random() % 3);
    for (int e = 0; e < edits; ++e) {
      const std::size_t at = random() % text.size(), size = random() % 12;
      switch (random() % 3) {
        case 0:
          text.erase(at, size);
          break;
        case 1:
          text.insert(at, text.substr(random() % text.size(), size));
          break;
        default:
          text[at] = "(){};,.<>=+-*/%!&|^~?:[]#0123abc \n"[random() % 34];
          break;
      }
    }
    expect_survives(text, Language::Hlsl, text);
  }
}

TEST(HostileText, DamagedModulesEndInTheValidatorsMessage) {
  const char* bytes = "\x03\x02\x23\x07\x00\x03\x01\x00\x0b\x00\x08\x00\x40\x00\x00\x00\x00\x00\x00\x00";
  expect_survives(std::string(bytes, 20), Language::Spirv, "header");
  expect_survives(std::string(bytes, 20) + repeated("\x01", 64), Language::Spirv, "garbage");
  expect_survives(std::string(bytes, 7), Language::Spirv, "short");
  Options o = options_for(std::string(bytes, 20) + std::string(400, '\x11'), Language::Spirv);
  o.source_path = "broken.spv";
  try {
    compile(o);
    FAIL() << "accepted";
  } catch (const UserError& e) {
    EXPECT_NE(std::string(e.what()).find("not a valid SPIR-V module"), std::string::npos) << e.what();
    EXPECT_EQ(e.place().file, "broken.spv");
  }
}

}  // namespace
}  // namespace aluminate::compiler::testing
