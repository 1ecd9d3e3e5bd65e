// Branches, loops, jumps and discards against the same function in C++, in every loop mode, optimised or not.
#include "tests/compiler/shader_runner.hpp"

#include <cmath>

namespace aluminate::compiler::testing {
namespace {

struct Flow {
  const char* name;
  const char* body;  // of float main: x, y in [-4, 4), uniforms n (int) and w[8]
  std::function<double(double x, double y)> formula;
  const char* glsl = "";  // where it differs from HLSL
};

constexpr int kN = 5;
double w(int i) { return 0.5 * i - 1; }
constexpr double kTable[4] = {3, 1, 4, 1.5};

const std::vector<Flow>& flows() {
  static const std::vector<Flow> kFlows = {
      {"If", "float r = x; if (x > y) r = y * 2; return r;",
       [](double x, double y) { return x > y ? y * 2 : x; }},
      {"IfElse", "float r; if (x > y) { r = x * y; } else { r = x - y; if (x < 0) r += 1; } return r + 1;",
       [](double x, double y) { return (x > y ? x * y : x - y + (x < 0 ? 1 : 0)) + 1; }},
      {"EarlyReturn", "if (x < 0) return y; if (y < 0) return x * 2; return x + y;",
       [](double x, double y) { return x < 0   ? y
                                       : y < 0 ? x * 2
                                               : x + y; }},
      {"EarlyReturnNested",
       "float r = 0; if (x < 0) { r = 1; if (y < 0) return y; r = r + x; } else if (y > 2) return 7; return "
       "r * 2;",
       [](double x, double y) {
         double r = 0;
         if (x < 0) {
           r = 1;
           if (y < 0) return y;
           r = r + x;
         } else if (y > 2)
           return 7.0;
         return r * 2;
       }},
      {"CountedLoop", "float r = 0; for (int i = 0; i < 8; i++) r += x * w[i] + y; return r;",
       [](double x, double y) {
         double r = 0;
         for (int i = 0; i < 8; ++i) r += x * w(i) + y;
         return r;
       }},
      {"CountedBackwards", "float r = x; for (int i = 7; i >= 2; i -= 2) r = r * 0.5 + w[i]; return r + y;",
       [](double x, double y) {
         double r = x;
         for (int i = 7; i >= 2; i -= 2) r = r * 0.5 + w(i);
         return r + y;
       }},
      {"CountedFromOne",
       "float r = x; for (int i = 1; i < 7; i += 3) r = r * 0.5 + w[i + 1] * i; return r + y;",
       [](double x, double y) {
         double r = x;
         for (int i = 1; i < 7; i += 3) r = r * 0.5 + w(i + 1) * i;
         return r + y;
       }},
      {"CounterAfterLoop", "float r = x; int i; for (i = 0; i < 5; i++) r += y; return r + i;",
       [](double x, double y) {
         double r = x;
         int i;
         for (i = 0; i < 5; ++i) r += y;
         return r + i;
       }},
      {"NestedLoops",
       "float r = 0; for (int i = 0; i < 3; i++) for (int j = 0; j < 2; j++) r += x * i + y * j + w[i * 2 + "
       "j]; return r;",
       [](double x, double y) {
         double r = 0;
         for (int i = 0; i < 3; ++i)
           for (int j = 0; j < 2; ++j) r += x * i + y * j + w(i * 2 + j);
         return r;
       }},
      {"UniformBound", "float r = x; for (int i = 0; i < n; i++) r = r * 0.5 + y; return r;",
       [](double x, double y) {
         double r = x;
         for (int i = 0; i < kN; ++i) r = r * 0.5 + y;
         return r;
       }},
      {"DataBound", "float r = 0; float t = abs(x); while (t > 0.5) { t *= 0.5; r += 1; } return r + y;",
       [](double x, double y) {
         double r = 0, t = std::fabs(x);
         while (t > 0.5) {
           t *= 0.5;
           r += 1;
         }
         return r + y;
       }},
      {"DoWhile", "float r = 0; float t = x; do { t += 1; r += t; } while (t < y); return r;",
       [](double x, double y) {
         double r = 0, t = x;
         do {
           t += 1;
           r += t;
         } while (t < y);
         return r;
       }},
      {"Break", "float r = 0; for (int i = 0; i < 8; i++) { if (r > x) break; r += abs(y) + 0.1; } return r;",
       [](double x, double y) {
         double r = 0;
         for (int i = 0; i < 8; ++i) {
           if (r > x) break;
           r += std::fabs(y) + 0.1f;
         }
         return r;
       }},
      {"BreakWithValue",
       "float r = -1; for (int i = 0; i < 8; i++) { if (w[i] > x) { r = i; break; } } return r + y;",
       [](double x, double y) {
         double r = -1;
         for (int i = 0; i < 8; ++i)
           if (w(i) > x) {
             r = i;
             break;
           }
         return r + y;
       }},
      {"Continue",
       "float r = 0; for (int i = 0; i < 8; i++) { float a = w[i] * x; if (a <= 0) continue; r += a * y; } "
       "return r;",
       [](double x, double y) {
         double r = 0;
         for (int i = 0; i < 8; ++i) {
           const double a = w(i) * x;
           if (a <= 0) continue;
           r += a * y;
         }
         return r;
       }},
      {"ContinueTwice",
       "float r = 0; for (int i = 0; i < 8; i++) { r += 0.25; if (w[i] < x) continue; r += y; if (w[i] < y) "
       "{ r += x; continue; } r -= 1; } return r;",
       [](double x, double y) {
         double r = 0;
         for (int i = 0; i < 8; ++i) {
           r += 0.25;
           if (w(i) < x) continue;
           r += y;
           if (w(i) < y) {
             r += x;
             continue;
           }
           r -= 1;
         }
         return r;
       }},
      {"ContinueInOpenLoop",
       "float r = 0; int i = 0; while (i < n) { i++; if (w[i] < x) continue; r += y + i; } return r;",
       [](double x, double y) {
         double r = 0;
         int i = 0;
         while (i < kN) {
           i++;
           if (w(i) < x) continue;
           r += y + i;
         }
         return r;
       }},
      {"BreakAndContinue",
       "float r = 0; for (int i = 0; i < 8; i++) { if (w[i] < x) continue; if (r > 3) break; r += abs(y); if "
       "(w[i] > 1) r += 1; } return r;",
       [](double x, double y) {
         double r = 0;
         for (int i = 0; i < 8; ++i) {
           if (w(i) < x) continue;
           if (r > 3) break;
           r += std::fabs(y);
           if (w(i) > 1) r += 1;
         }
         return r;
       }},
      {"BreakFromNestedIf",
       "float r = 0; for (int i = 0; i < 8; i++) { if (x > 0) { r += 1; if (r > y) break; r += 0.5; } r += "
       "0.25; } return r;",
       [](double x, double y) {
         double r = 0;
         for (int i = 0; i < 8; ++i) {
           if (x > 0) {
             r += 1;
             if (r > y) break;
             r += 0.5;
           }
           r += 0.25;
         }
         return r;
       }},
      {"ReturnFromLoop", "for (int i = 0; i < 8; i++) { if (w[i] > x) return i + y; } return -9;",
       [](double x, double y) {
         for (int i = 0; i < 8; ++i)
           if (w(i) > x) return i + y;
         return -9.0;
       }},
      {"ReturnFromNestedLoops",
       "float r = 0; for (int i = 0; i < 3; i++) { for (int j = 0; j < 3; j++) { r += 0.5; if (r > x + 2) "
       "return r + y; } r += 0.1; } return -r;",
       [](double x, double y) {
         double r = 0;
         for (int i = 0; i < 3; ++i) {
           for (int j = 0; j < 3; ++j) {
             r += 0.5;
             if (r > x + 2) return r + y;
           }
           r += 0.1f;
         }
         return -r;
       }},
      {"Switch",
       "float r = 0; switch ((int)floor(abs(x))) { case 0: r = 1; break; case 1: r = y; break; case 2: r = x "
       "* 2; break; default: r = -1; break; } return r;",
       [](double x, double y) {
         switch (static_cast<int>(std::fabs(x))) {
           case 0:
             return 1.0;
           case 1:
             return y;
           case 2:
             return x * 2;
           default:
             return -1.0;
         }
       },
       "float r = 0; switch (int(floor(abs(x)))) { case 0: r = 1; break; case 1: r = y; break; case 2: r = x "
       "* 2; break; default: r = -1; break; } return r;"},
      {"SwitchFallsThrough", "",
       [](double x, double y) {
         double r = 0;
         switch (static_cast<int>(std::fabs(x))) {
           case 0:
             r += 1;
             [[fallthrough]];
           case 1:
             r += y;
             break;
           case 2:
             if (y > 0) break;
             r = 5;
             [[fallthrough]];
           default:
             r += 10;
         }
         return r;
       },
       "float r = 0; switch (int(floor(abs(x)))) { case 0: r += 1; case 1: r += y; break; case 2: if (y > 0) "
       "break; r = 5; default: r += 10; } return r;"},
      {"SwitchInLoop",
       "float r = 0; for (int i = 0; i < 6; i++) { switch (i) { case 1: r += x; break; case 3: r += y; "
       "break; default: r += 0.125; break; } if (r > 3) break; } return r;",
       [](double x, double y) {
         double r = 0;
         for (int i = 0; i < 6; ++i) {
           if (i == 1)
             r += x;
           else if (i == 3)
             r += y;
           else
             r += 0.125;
           if (r > 3) break;
         }
         return r;
       }},
      {"ContinueInsideSwitch", "",
       [](double x, double y) {
         double r = 0;
         for (int i = 0; i < 6; ++i) {
           switch (i & 1) {
             case 0:
               if (x > i) continue;
               r += 1;
               break;
             default:
               r += y;
           }
           r += 0.5;
         }
         return r;
       },
       "float r = 0; for (int i = 0; i < 6; i++) { switch (i & 1) { case 0: if (x > i) continue; r += 1; "
       "break; default: r += y; } r += 0.5; } return r;"},
      {"ConstantTable", "float t[4] = {3, 1, 4, 1.5}; return t[(int)floor(abs(x) * 0.99)] * y;",
       [](double x, double y) { return kTable[static_cast<int>(std::fabs(x) * 0.99f)] * y; },
       "const float t[4] = float[4](3, 1, 4, 1.5); return t[int(floor(abs(x) * 0.99))] * y;"},
      {"LocalArray", "float t[4] = {x, y, x + y, x * y}; t[1] += 1; return t[(int)floor(abs(x) * 0.99)];",
       [](double x, double y) {
         const double t[4] = {x, y + 1, x + y, x * y};
         return t[static_cast<int>(std::fabs(x) * 0.99f)];
       },
       "float t[4] = float[4](x, y, x + y, x * y); t[1] += 1; return t[int(floor(abs(x) * 0.99))];"},
      {"LocalArrayWrittenByIndex",
       "float t[4] = {0, 0, 0, 0}; for (int i = 0; i < 4; i++) t[(int)floor(abs(x) * 0.99)] += w[i + 2] * y; "
       "return t[0] - t[3] + t[1] * 2;",
       [](double x, double y) {
         double t[4] = {};
         for (int i = 0; i < 4; ++i) t[static_cast<int>(std::fabs(x) * 0.99f)] += w(i + 2) * y;
         return t[0] - t[3] + t[1] * 2;
       },
       "float t[4] = float[4](0, 0, 0, 0); for (int i = 0; i < 4; i++) t[int(floor(abs(x) * 0.99))] += w[i + "
       "2] * y; return t[0] - t[3] + t[1] * 2;"},
      {"UniformByData", "return w[(int)floor(abs(x))] + w[(int)floor(abs(y)) + 1];",
       [](double x, double y) {
         return w(static_cast<int>(std::fabs(x))) + w(static_cast<int>(std::fabs(y)) + 1);
       },
       "return w[int(floor(abs(x)))] + w[int(floor(abs(y))) + 1];"},
      {"SwapInLoop",
       "float a = x, b = y; for (int i = 0; i < 5; i++) { float t = a; a = b; b = t * 0.5; } return a - b * "
       "3;",
       [](double x, double y) {
         double a = x, b = y;
         for (int i = 0; i < 5; ++i) {
           const double t = a;
           a = b;
           b = t * 0.5;
         }
         return a - b * 3;
       }},
      {"ZeroTrips", "float r = x; for (int i = 3; i < 3; i++) r += y; return r;",
       [](double x, double) { return x; }},
      {"FloatCounter", "float r = 0; for (float t = 0; t < 1; t += 0.25) r += t * x + y; return r;",
       [](double x, double y) {
         double r = 0;
         for (double t = 0; t < 1; t += 0.25) r += t * x + y;
         return r;
       }},
  };
  return kFlows;
}

struct Mode {
  LoopMode loops;
  bool optimise;
};

class ControlFlow : public ::testing::TestWithParam<Mode> {
 protected:
  void expect(const Flow& f, Language language) {
    const bool hlsl = language == Language::Hlsl;
    const std::string body = hlsl || *f.glsl == 0 ? f.body : f.glsl;
    if (body.empty()) return;
    Options o =
        options_for(hlsl ? "int n; float w[9]; float f(float x, float y) { " + body +
                               " }\nfloat4 main(float2 v : TEXCOORD0) : COLOR0 { return f(v.x, v.y); }"
                         : "#version 450\nuniform int n; uniform float w[9]; layout(location = 0) in vec2 v; "
                           "layout(location = 0) out vec4 color;\n"
                           "float f(float x, float y) { " +
                               body + " }\nvoid main() { color = vec4(f(v.x, v.y)); }",
                    language, GetParam().loops);
    o.optimise = GetParam().optimise;
    SCOPED_TRACE(std::string(f.name) + (hlsl ? " HLSL" : " GLSL"));
    vm::Program p;
    try {
      p = compile_valid(o);
    } catch (const std::exception& e) {
      ADD_FAILURE() << e.what();
      return;
    }
    std::map<std::string, std::vector<double>> uniforms;
    for (const auto& u : p.uniforms) {
      if (u.name == "n") uniforms["n"] = {kN};
      if (u.name == "w") uniforms["w"] = {w(0), w(1), w(2), w(3), w(4), w(5), w(6), w(7), w(8)};
    }
    const Outcome r = run(p, test_value, uniforms);
    EXPECT_FALSE(r.overran);
    for (int lane = 0; lane < vm::kLanes; ++lane) {
      const double expected = f.formula(test_value("TEXCOORD0", 0, lane), test_value("TEXCOORD0", 1, lane));
      // literals such as 0.1 and 0.99 are fp32; everything else is exact
      ASSERT_NEAR(r.outputs.at("COLOR0")[static_cast<std::size_t>(lane)][0], expected,
                  1e-6 * std::max(1.0, std::fabs(expected)))
          << "lane " << lane << "\n"
          << listing(p);
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Modes, ControlFlow,
                         ::testing::Values(Mode{LoopMode::AsWritten, true}, Mode{LoopMode::Rolled, true},
                                           Mode{LoopMode::Unrolled, true}, Mode{LoopMode::Rolled, false},
                                           Mode{LoopMode::Unrolled, false}),
                         [](const auto& i) {
                           const char* loops = i.param.loops == LoopMode::AsWritten ? "AsWritten"
                                               : i.param.loops == LoopMode::Rolled  ? "Rolled"
                                                                                    : "Unrolled";
                           return std::string(loops) + (i.param.optimise ? "" : "Unoptimised");
                         });

TEST_P(ControlFlow, EqualsTheFunctionInHlsl) {
  for (const Flow& f : flows()) expect(f, Language::Hlsl);
}

TEST_P(ControlFlow, EqualsTheFunctionInGlsl) {
  for (const Flow& f : flows()) expect(f, Language::Glsl);
}

TEST(Loops, ContinueStaysContinueWhenRolledAndBecomesIfWhenUnrolled) {
  const std::string text =
      "float4 lights[4]; float4 main(float4 v : TEXCOORD0) : COLOR0 { float3 sum = 0;\n"
      "for (int i = 0; i < 4; i++) { float a = dot(lights[i].xyz, v.xyz); if (a <= 0) continue; sum += a * "
      "lights[i].w * v.xyz; } return float4(sum, 1); }";
  const vm::Program rolled = compile_valid(options_for(text, Language::Hlsl, LoopMode::Rolled));
  EXPECT_EQ(count(rolled, vm::Opcode::Continue), 1) << listing(rolled);
  EXPECT_EQ(count(rolled, vm::Opcode::If), 0) << listing(rolled);
  const vm::Program unrolled = compile_valid(options_for(text, Language::Hlsl, LoopMode::Unrolled));
  EXPECT_EQ(count(unrolled, vm::Opcode::Loop), 0) << listing(unrolled);
  EXPECT_EQ(count(unrolled, vm::Opcode::If), 4) << listing(unrolled);
}

TEST(Loops, CountedLoopsReadUniformsThroughTheCounter) {
  const vm::Program p = compile_valid(options_for(
      "struct Light { float3 position; float range; float4 color; }; Light lights[6];\n"
      "float4 main(float4 v : TEXCOORD0) : COLOR0 { float3 sum = 0; for (int i = 1; i < 6; i++) sum += "
      "lights[i].color.rgb * dot(lights[i].position, v.xyz) * lights[i].range; return float4(sum, 1); }",
      Language::Hlsl, LoopMode::Rolled));
  int relative = 0;
  for (const auto& i : p.code)
    for (int k = 0; k < vm::info(i.op).sources; ++k) {
      const auto& s = i.src[static_cast<std::size_t>(k)];
      if (s.relative.base == vm::RelativeBase::None) continue;
      ++relative;
      EXPECT_EQ(s.relative.base, vm::RelativeBase::LoopCounter);
      EXPECT_EQ(s.relative.scale, 2);
    }
  EXPECT_EQ(relative, 3) << listing(p);
  EXPECT_EQ(count(p, vm::Opcode::Break), 0);
  EXPECT_TRUE(p.straight_line());
}

TEST(Discard, EndsTheLanesItsConditionNames) {
  struct Kill {
    const char* body;
    std::function<bool(double, double)> kills;
  };
  const Kill kills[] = {
      {"clip(v.x);", [](double x, double) { return x < 0; }},
      {"if (v.x > v.y) discard;", [](double x, double y) { return x > y; }},
      {"if (v.x >= 1 || v.y < 0) discard;", [](double x, double y) { return x >= 1 || y < 0; }},
      {"if (v.x > 0 && v.y > 0) discard;", [](double x, double y) { return x > 0 && y > 0; }},
      {"clip(v.xy);", [](double x, double y) { return x < 0 || y < 0; }},
      {"if (v.x == 1) discard;", [](double x, double) { return x == 1; }},
      {"float r = v.x; if (v.x > 0) { r = 2; if (v.y > 1) discard; }",
       [](double x, double y) { return x > 0 && y > 1; }},
      {"for (int i = 0; i < 4; i++) { if (v.x > i && v.y < i) discard; }",
       [](double x, double y) {
         for (int i = 0; i < 4; ++i)
           if (x > i && y < i) return true;
         return false;
       }},
  };
  for (const Kill& k : kills)
    for (const LoopMode loops : {LoopMode::Rolled, LoopMode::Unrolled}) {
      const vm::Program p = compile_valid(options_for(
          std::string("float4 main(float2 v : TEXCOORD0) : COLOR0 { ") + k.body + " return v.xyxy; }",
          Language::Hlsl, loops));
      const Outcome r = run(p, test_value);
      for (int lane = 0; lane < vm::kLanes; ++lane)
        EXPECT_EQ((r.killed >> lane & 1) != 0,
                  k.kills(test_value("TEXCOORD0", 0, lane), test_value("TEXCOORD0", 1, lane)))
            << k.body << " lane " << lane << "\n"
            << listing(p);
    }
}

}  // namespace
}  // namespace aluminate::compiler::testing
