// Compiled expressions against the same formula in plain C++.
#include "tests/compiler/shader_runner.hpp"

#include <algorithm>
#include <cmath>

namespace aluminate::compiler::testing {
namespace {

using Formula = std::function<Float4(const Float4& a, const Float4& b)>;

struct Case {
  const char* hlsl;  // of float4 a, b; empty = not in this language
  const char* glsl;
  Formula formula;
  double tolerance =
      2e-6;  // literals are fp32 in both languages: 2^-24 relative, a few of them in one expression
};

Float4 each(const std::function<double(double)>& f, const Float4& a) {
  return {f(a[0]), f(a[1]), f(a[2]), f(a[3])};
}
Float4 each(const std::function<double(double, double)>& f, const Float4& a, const Float4& b) {
  return {f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])};
}
Float4 all(double x) { return {x, x, x, x}; }
double dot3(const Float4& a, const Float4& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double clamp01(double x) { return std::clamp(x, 0.0, 1.0); }
double sgn(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

// Where a formula has no value the test takes another: positive(x) keeps logarithms and roots defined.
double positive(double x) { return std::fabs(x) + 0.25; }

const std::vector<Case>& cases() {
  using std::fabs;
  static const std::vector<Case> kCases = {
      {"a + b", "a + b", [](auto a, auto b) { return each([](double x, double y) { return x + y; }, a, b); }},
      {"a * b - a", "a * b - a",
       [](auto a, auto b) { return each([](double x, double y) { return x * y - x; }, a, b); }},
      {"a / (abs(b) + 0.25)", "a / (abs(b) + 0.25)",
       [](auto a, auto b) { return each([](double x, double y) { return x / positive(y); }, a, b); }},
      {"(a * 2 + 1) * 0.125 - b * b", "(a * 2 + 1) * 0.125 - b * b",
       [](auto a, auto b) {
         return each([](double x, double y) { return (x * 2 + 1) * 0.125 - y * y; }, a, b);
       }},
      {"dot(a.xyz, b.xyz)", "vec4(dot(a.xyz, b.xyz))", [](auto a, auto b) { return all(dot3(a, b)); }},
      {"dot(a, b)", "vec4(dot(a, b))", [](auto a, auto b) { return all(dot3(a, b) + a[3] * b[3]); }},
      {"dot(a.xy, b.zw) + 1", "vec4(dot(a.xy, b.zw) + 1)",
       [](auto a, auto b) { return all(a[0] * b[2] + a[1] * b[3] + 1); }},
      {"1 - dot(a.xy, a.xy)", "vec4(1 - dot(a.xy, a.xy))",
       [](auto a, auto) { return all(1 - a[0] * a[0] - a[1] * a[1]); }},
      {"saturate(1 - a * b)", "clamp(1 - a * b, 0, 1)",
       [](auto a, auto b) { return each([](double x, double y) { return clamp01(1 - x * y); }, a, b); }},
      {"saturate(-(a + b)) * a", "clamp(-(a + b), 0, 1) * a",
       [](auto a, auto b) { return each([](double x, double y) { return clamp01(-(x + y)) * x; }, a, b); }},
      {"clamp(a, -0.5, b)", "min(max(a, -0.5), b)",
       [](auto a, auto b) {
         return each([](double x, double y) { return std::min(std::max(x, -0.5), y); }, a, b);
       }},
      {"min(a, b) + max(a, b) * 2", "min(a, b) + max(a, b) * 2",
       [](auto a, auto b) {
         return each([](double x, double y) { return std::min(x, y) + std::max(x, y) * 2; }, a, b);
       }},
      {"lerp(a, b, 0.25)", "mix(a, b, 0.25)",
       [](auto a, auto b) { return each([](double x, double y) { return x + 0.25 * (y - x); }, a, b); }},
      {"lerp(a, 1, b)", "mix(a, vec4(1), b)",
       [](auto a, auto b) { return each([](double x, double y) { return x + y * (1 - x); }, a, b); }},
      {"abs(a) * -b", "abs(a) * -b",
       [](auto a, auto b) { return each([](double x, double y) { return std::fabs(x) * -y; }, a, b); }},
      {"floor(a) + ceil(b)", "floor(a) + ceil(b)",
       [](auto a, auto b) {
         return each([](double x, double y) { return std::floor(x) + std::ceil(y); }, a, b);
       }},
      {"frac(a) + trunc(b)", "fract(a) + trunc(b)",
       [](auto a, auto b) {
         return each([](double x, double y) { return x - std::floor(x) + std::trunc(y); }, a, b);
       }},
      {"sign(a) + step(a, b)", "sign(a) + step(a, b)",
       [](auto a, auto b) {
         return each([](double x, double y) { return sgn(x) + (y >= x ? 1 : 0); }, a, b);
       }},
      {"", "roundEven(a * 2) * 0.5 + round(b + 0.1)",
       [](auto a, auto b) {
         return each([](double x, double y) { return std::nearbyint(x * 2) * 0.5 + std::floor(y + 0.6); }, a,
                     b);
       }},
      {"smoothstep(-1, 2, a)", "smoothstep(-1, 2, a)",
       [](auto a, auto) {
         return each(
             [](double x) {
               const double t = clamp01((x + 1) / 3);
               return t * t * (3 - 2 * t);
             },
             a);
       }},
      {"fmod(a, abs(b) + 0.25)", "",
       [](auto a, auto b) {
         return each([](double x, double y) { return std::fmod(x, positive(y)); }, a, b);
       },
       1e-5},
      {"", "mod(a, abs(b) + 0.25)",
       [](auto a, auto b) {
         return each([](double x, double y) { return x - positive(y) * std::floor(x / positive(y)); }, a, b);
       },
       1e-5},
      {"exp2(a) + exp(b)", "exp2(a) + exp(b)",
       [](auto a, auto b) {
         return each([](double x, double y) { return std::exp2(x) + std::exp(y); }, a, b);
       }},
      {"log2(abs(a) + 0.25) * log(abs(b) + 0.25)", "log2(abs(a) + 0.25) * log(abs(b) + 0.25)",
       [](auto a, auto b) {
         return each([](double x, double y) { return std::log2(positive(x)) * std::log(positive(y)); }, a, b);
       }},
      {"pow(abs(a) + 0.25, b)", "pow(abs(a) + 0.25, b)",
       [](auto a, auto b) {
         return each([](double x, double y) { return std::pow(positive(x), y); }, a, b);
       }},
      {"pow(a, 5) + pow(b, 3)", "pow(a, vec4(5)) + pow(b, vec4(3))",
       [](auto a, auto b) {
         return each([](double x, double y) { return x * x * x * x * x + y * y * y; }, a, b);
       }},
      {"pow(2, a)", "pow(vec4(2), a)",
       [](auto a, auto) { return each([](double x) { return std::exp2(x); }, a); }},
      {"pow(10, a)", "pow(vec4(10), a)",
       [](auto a, auto) { return each([](double x) { return std::pow(10, x); }, a); }},
      {"sqrt(abs(a) + 0.25) * rsqrt(abs(b) + 0.25)", "sqrt(abs(a) + 0.25) * inversesqrt(abs(b) + 0.25)",
       [](auto a, auto b) {
         return each([](double x, double y) { return std::sqrt(positive(x)) / std::sqrt(positive(y)); }, a,
                     b);
       }},
      {"1 / sqrt(abs(a) + 0.25)", "1 / sqrt(abs(a) + 0.25)",
       [](auto a, auto) { return each([](double x) { return 1 / std::sqrt(positive(x)); }, a); }},
      {"sin(a) + cos(b)", "sin(a) + cos(b)",
       [](auto a, auto b) {
         return each([](double x, double y) { return std::sin(x) + std::cos(y); }, a, b);
       }},
      {"tan(a * 0.3)", "tan(a * 0.3)",
       [](auto a, auto) { return each([](double x) { return std::tan(x * 0.3); }, a); }, 1e-5},
      {"acos(a * 0.25)", "acos(a * 0.25)",
       [](auto a, auto) { return each([](double x) { return std::acos(x * 0.25); }, a); },
       7e-5},  // [AS64 4.4.45]
      {"asin(a * 0.25)", "asin(a * 0.25)",
       [](auto a, auto) { return each([](double x) { return std::asin(x * 0.25); }, a); }, 7e-5},
      {"atan(a * 3)", "atan(a * 3)",
       [](auto a, auto) { return each([](double x) { return std::atan(x * 3); }, a); }},
      {"atan2(a, abs(b) + 0.25) + atan2(a, -abs(b) - 0.25)",
       "atan(a, abs(b) + 0.25) + atan(a, -abs(b) - 0.25)",
       [](auto a, auto b) {
         return each(
             [](double x, double y) { return std::atan2(x, positive(y)) + std::atan2(x, -positive(y)); }, a,
             b);
       }},
      {"tanh(a) + sinh(b) + cosh(b)", "tanh(a) + sinh(b) + cosh(b)",
       [](auto a, auto b) {
         return each([](double x, double y) { return std::tanh(x) + std::sinh(y) + std::cosh(y); }, a, b);
       },
       1e-5},
      {"length(a.xyz) + distance(a.xyz, b.xyz)", "vec4(length(a.xyz) + distance(a.xyz, b.xyz))",
       [](auto a, auto b) {
         const Float4 d{a[0] - b[0], a[1] - b[1], a[2] - b[2], 0};
         return all(std::sqrt(dot3(a, a)) + std::sqrt(dot3(d, d)));
       }},
      {"float4(normalize(a.xyz + float3(5, 0, 0)), a.w)", "vec4(normalize(a.xyz + vec3(5, 0, 0)), a.w)",
       [](auto a, auto) {
         const Float4 v{a[0] + 5, a[1], a[2], 0};
         const double s = 1 / std::sqrt(dot3(v, v));
         return Float4{v[0] * s, v[1] * s, v[2] * s, a[3]};
       }},
      {"float4(cross(a.xyz, b.xyz), 1)", "vec4(cross(a.xyz, b.xyz), 1)",
       [](auto a, auto b) {
         return Float4{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], 1};
       }},
      {"float4(reflect(a.xyz, b.xyz), 0)", "vec4(reflect(a.xyz, b.xyz), 0)",
       [](auto a, auto b) {
         const double d = 2 * dot3(a, b);
         return Float4{a[0] - d * b[0], a[1] - d * b[1], a[2] - d * b[2], 0};
       }},
      {"float4(refract(a.xyz * 0.1, float3(0, 0, 1), 0.7), 0)",
       "vec4(refract(a.xyz * 0.1, vec3(0, 0, 1), 0.7), 0)",
       [](auto a, auto) {
         const double d = a[2] * 0.1, k = 1 - 0.49 * (1 - d * d);
         return Float4{0.07 * a[0], 0.07 * a[1], 0.07 * a[2] - (0.7 * d + std::sqrt(k)), 0};
       }},
      {"float4(faceforward(a.xyz, b.xyz, a.zxy), 0)", "vec4(faceforward(a.xyz, b.xyz, a.zxy), 0)",
       [](auto a, auto b) {
         const double s = a[2] * b[0] + a[0] * b[1] + a[1] * b[2] < 0 ? 1 : -1;
         return Float4{s * a[0], s * a[1], s * a[2], 0};
       }},
      {"a < b ? a * 2 : b - 1", "mix(b - 1, a * 2, lessThan(a, b))",
       [](auto a, auto b) { return each([](double x, double y) { return x < y ? x * 2 : y - 1; }, a, b); }},
      {"a.x >= b.x ? a : b", "a.x >= b.x ? a : b", [](auto a, auto b) { return a[0] >= b[0] ? a : b; }},
      {"a.x == 1 ? a : b", "a.x == 1 ? a : b", [](auto a, auto b) { return a[0] == 1 ? a : b; }},
      {"a.x != -1 ? a : b", "a.x != -1 ? a : b", [](auto a, auto b) { return a[0] != -1 ? a : b; }},
      {"(a.x > 0 && b.x <= 0) || !(a.y < b.y) ? 1 : 0", "vec4((a.x > 0 && b.x <= 0) || !(a.y < b.y) ? 1 : 0)",
       [](auto a, auto b) { return all((a[0] > 0 && b[0] <= 0) || !(a[1] < b[1]) ? 1 : 0); }},
      {"any(a > b) ? 2 : all(a < b + 1) ? 3 : 4",
       "vec4(any(greaterThan(a, b)) ? 2 : all(lessThan(a, b + 1)) ? 3 : 4)",
       [](auto a, auto b) {
         bool any = false, every = true;
         for (std::size_t k = 0; k < 4; ++k) {
           any = any || a[k] > b[k];
           every = every && a[k] < b[k] + 1;
         }
         return all(any ? 2 : every ? 3 : 4);
       }},
      {"float4(a.wzyx.xy, b.xz) * a.yxwz", "vec4(a.wzyx.xy, b.xz) * a.yxwz",
       [](auto a, auto b) {
         return Float4{a[3] * a[1], a[2] * a[0], b[0] * a[3], b[2] * a[2]};
       }},
      {"float4(a.xyz, 1) * float4(-b.x, abs(b.y), b.z, 2)", "vec4(a.xyz, 1) * vec4(-b.x, abs(b.y), b.z, 2)",
       [](auto a, auto b) {
         return Float4{-a[0] * b[0], a[1] * std::fabs(b[1]), a[2] * b[2], 2};
       }},
      {"float4(mul(float3x3(a.xyz, b.xyz, a.zxy), b.yzw), 1)", "vec4(b.yzw * mat3(a.xyz, b.xyz, a.zxy), 1)",
       [](auto a, auto b) {
         const Float4 v{b[1], b[2], b[3], 0};
         return Float4{dot3(a, v), dot3(b, v), dot3({a[2], a[0], a[1], 0}, v), 1};
       }},
      {"float4(mul(b.yzw, float3x3(a.xyz, b.xyz, a.zxy)), 1)", "vec4(mat3(a.xyz, b.xyz, a.zxy) * b.yzw, 1)",
       [](auto a, auto b) {
         return Float4{b[1] * a[0] + b[2] * b[0] + b[3] * a[2], b[1] * a[1] + b[2] * b[1] + b[3] * a[0],
                       b[1] * a[2] + b[2] * b[2] + b[3] * a[1], 1};
       }},
      {"transpose(float4x4(a, b, a * 2, b * 2))[1]", "transpose(mat4(a, b, a * 2, b * 2))[1]",
       [](auto a, auto b) {
         return Float4{a[1], b[1], a[1] * 2, b[1] * 2};
       }},
      {"mul(mul(float4x4(a, b, a.wzyx, b.wzyx), float4x4(b, a, b, a)), a)",
       "a * (mat4(b, a, b, a) * mat4(a, b, a.wzyx, b.wzyx))",
       [](auto a, auto b) {
         const Float4 rows[4] = {a, b, {a[3], a[2], a[1], a[0]}, {b[3], b[2], b[1], b[0]}},
                      right[4] = {b, a, b, a};
         Float4 mid{}, r{};
         for (std::size_t k = 0; k < 4; ++k)
           for (std::size_t c = 0; c < 4; ++c) mid[k] += right[k][c] * a[c];
         for (std::size_t k = 0; k < 4; ++k)
           for (std::size_t c = 0; c < 4; ++c) r[k] += rows[k][c] * mid[c];
         return r;
       }},
      {"radians(a) + degrees(b)", "radians(a) + degrees(b)",
       [](auto a, auto b) {
         return each([](double x, double y) { return x * M_PI / 180 + y * 180 / M_PI; }, a, b);
       }},
      {"float4((int)(a.x * 100) / 7, (int)(a.x * 100) % 7, (int)(a.y * 10) / max((int)abs(b.x * 5), 1), "
       "(int)a.z * 3 - (int)b.z)",
       "vec4(int(a.x * 100) / 7, int(a.x * 100) - int(a.x * 100) / 7 * 7, int(a.y * 10) / max(int(abs(b.x * "
       "5)), 1), int(a.z) * 3 - int(b.z))",
       [](auto a, auto b) {
         const int i = static_cast<int>(a[0] * 100);
         return Float4{
             double(i / 7), double(i % 7),
             double(static_cast<int>(a[1] * 10) / std::max(static_cast<int>(std::fabs(b[0] * 5)), 1)),
             double(static_cast<int>(a[2]) * 3 - static_cast<int>(b[2]))};
       },
       0},
      {"float4((int)(a.x * 100) / 8, (uint)(abs(a.x) * 100) / 16u, ((int)(a.x * 100)) & 7, ((int)(a.y * "
       "100)) >> 2)",
       "vec4(int(a.x * 100) / 8, uint(abs(a.x) * 100) / 16u, int(a.x * 100) & 7, int(a.y * 100) >> 2)",
       [](auto a, auto) {
         const int i = static_cast<int>(a[0] * 100), j = static_cast<int>(a[1] * 100);
         return Float4{double(i / 8), double(static_cast<unsigned>(std::fabs(a[0]) * 100) / 16u),
                       double(i & 7), double(j >> 2)};
       },
       0},
      {"a[(int)(abs(b.x) * 0.99)]", "vec4(a[int(abs(b.x) * 0.99)])",
       [](auto a, auto b) { return all(a[static_cast<std::size_t>(std::fabs(b[0]) * 0.99)]); }},
  };
  return kCases;
}

void expect_case(const Case& c, Language language, bool optimise) {
  const bool hlsl = language == Language::Hlsl;
  const char* expression = hlsl ? c.hlsl : c.glsl;
  if (*expression == 0) return;
  Options o = options_for(
      hlsl ? std::string("float4 main(float4 a : TEXCOORD0, float4 b : TEXCOORD1) : COLOR0 { return ") +
                 expression + "; }"
           : std::string("#version 450\nlayout(location = 0) in vec4 a; layout(location = 1) in vec4 b; "
                         "layout(location = 0) out vec4 color;\nvoid main() { color = ") +
                 expression + "; }",
      language);
  o.optimise = optimise;
  SCOPED_TRACE(expression);
  const vm::Program p = compile_valid(o);
  const Outcome r = run(p, test_value);
  for (int lane = 0; lane < vm::kLanes; ++lane) {
    Float4 a{}, b{};
    for (int k = 0; k < 4; ++k) {
      a[static_cast<std::size_t>(k)] = test_value("TEXCOORD0", k, lane);
      b[static_cast<std::size_t>(k)] = test_value("TEXCOORD1", k, lane);
    }
    const Float4 expected = c.formula(a, b), got = r.outputs.at("COLOR0")[static_cast<std::size_t>(lane)];
    for (std::size_t k = 0; k < 4; ++k)
      ASSERT_NEAR(got[k], expected[k], c.tolerance * std::max(1.0, std::fabs(expected[k])))
          << "lane " << lane << " component " << k << "\n"
          << listing(p);
  }
}

TEST(Values, HlslExpressionsEqualTheirFormulae) {
  for (const Case& c : cases()) expect_case(c, Language::Hlsl, true);
}

TEST(Values, GlslExpressionsEqualTheirFormulae) {
  for (const Case& c : cases()) expect_case(c, Language::Glsl, true);
}

TEST(Values, UnoptimisedModulesGiveTheSameValues) {
  for (const Case& c : cases()) expect_case(c, Language::Hlsl, false);
  for (const Case& c : cases()) expect_case(c, Language::Glsl, false);
}

// Both sides of every multiple, where a quotient that is off by any fraction shows.
TEST(Values, IntegerDivisionIsExactBelowTwoToTheTwenty) {
  const vm::Program p =
      compile_valid(options_for("float4 main(float4 a : TEXCOORD0) : COLOR0 { int n = (int)a.x, d = "
                                "(int)a.y; return float4(n / d, n % d, "
                                "(uint)abs(a.x) / (uint)abs(a.y), 0); }"));
  for (const char* format : {"fx31", "fx24", "ref64"})
    for (int round = 0; round < 60; ++round) {
      const auto operands = [&](int lane) {
        const std::int64_t k = round * vm::kLanes + lane;
        const std::int64_t d = 1 + k * k * 7919 % 60000;
        const std::int64_t multiple = std::max<std::int64_t>(1, (k * 104729) % ((1 << 20) / d + 1)) * d;
        const std::int64_t n = std::min<std::int64_t>(multiple - k % 2, (1 << 20) - 1);
        return std::pair(k % 4 < 2 ? n : -n, k % 8 < 4 ? d : -d);
      };
      const Outcome r = run(
          p,
          [&](const std::string&, int component, int lane) {
            const auto [n, d] = operands(lane);
            return static_cast<double>(component == 0 ? n : d);
          },
          {}, format);
      for (int lane = 0; lane < vm::kLanes; ++lane) {
        const auto [n, d] = operands(lane);
        const Float4 got = r.outputs.at("COLOR0")[static_cast<std::size_t>(lane)];
        ASSERT_EQ(got[0], static_cast<double>(n / d)) << n << " / " << d << " " << format;
        ASSERT_EQ(got[1], static_cast<double>(n % d)) << n << " % " << d << " " << format;
        ASSERT_EQ(got[2], static_cast<double>(std::abs(n) / std::abs(d))) << n << " / " << d << " " << format;
      }
    }
}

TEST(Values, ConstantsWithASuffixKeepTheirFullPrecision) {
  const vm::Program p =
      compile_valid(options_for("float4 main(float4 a : TEXCOORD0) : COLOR0 { return float4(a.x * 0.1L, a.x "
                                "* 0.1, a.x * (0.1L / 3), 0); }"));
  const Outcome r = run(p, test_value);
  for (int lane = 0; lane < vm::kLanes; ++lane) {
    const double x = test_value("TEXCOORD0", 0, lane);
    const Float4 got = r.outputs.at("COLOR0")[static_cast<std::size_t>(lane)];
    EXPECT_EQ(got[0], x * 0.1);
    EXPECT_EQ(got[1], x * double{0.1f});
    EXPECT_NEAR(got[2], x * (0.1 / 3), 0x1p-52);  // the quotient may be folded as a product
  }
}

// One difference per quad, as the hardware takes it: against pixel (0, 0).
TEST(Values, DerivativesAreQuadDifferences) {
  const vm::Program p =
      compile_valid(options_for("float4 main(float4 a : TEXCOORD0) : COLOR0 { return float4(ddx(a.x), "
                                "ddy(-a.y), fwidth(a.z), ddx(abs(a.w))); }"));
  const Outcome r = run(p, test_value);
  for (int lane = 0; lane < vm::kLanes; ++lane) {
    const int quad = lane & ~3;
    const auto v = [&](int k, int l) { return test_value("TEXCOORD0", k, l); };
    const Float4 got = r.outputs.at("COLOR0")[static_cast<std::size_t>(lane)];
    EXPECT_EQ(got[0], v(0, quad + 1) - v(0, quad));
    EXPECT_EQ(got[1], -(v(1, quad + 2) - v(1, quad)));
    EXPECT_EQ(got[2], std::fabs(v(2, quad + 1) - v(2, quad)) + std::fabs(v(2, quad + 2) - v(2, quad)));
    EXPECT_EQ(got[3], std::fabs(v(3, quad + 1)) - std::fabs(v(3, quad)));
  }
}

TEST(Values, TheFarCry3ShaderEqualsItsFormulae) {
  for (int visibility : {0, 1, 2})
    for (const LoopMode loops : {LoopMode::Rolled, LoopMode::Unrolled})
      for (const char* file : {"fc3_reference.hlsl", "fc3_reference.frag"}) {
        Options o;
        o.source_path = std::string(ALUMINATE_SOURCE_DIR "/tests/compiler/") + file;
        o.loops = loops;
        o.defines = {{"LIGHTS", "3"}, {"VISIBILITY", std::to_string(visibility)}};
        const vm::Program p = compile_valid(o);
        const auto input = [](const std::string& semantic, int k, int lane) {
          const double x = test_value(semantic, k, lane) * 0.2;
          const int axis = semantic == "TEXCOORD2"   ? 2
                           : semantic == "TEXCOORD3" ? 0
                           : semantic == "TEXCOORD4" ? 1
                                                     : -1;
          return x + (k == axis ? 1 : 0);
        };
        const std::map<std::string, std::vector<double>> uniforms = {
            {"eye", {0.5, 1, 6}},
            {"exposure", {0.8}},
            {"white", {1.5}},
            {"light_position", {2, 3, 4, 0.01, -3, 2, 5, 0.02, 0, -1, 7, 0.005}},
            {"light_color", {1, 0.9, 0.8, 0, 0.2, 0.5, 1.5, 0, 2, 0.3, 0.1, 0}},
            {"sh", {0.1,  0.2, 0.3, 0.4, 0.05, 0.1,  0.2,  0.3, 0.02, 0.04, 0.1,  0.5,  0.1,  0,
                    0.05, 0,   0,   0.1, 0,    0.02, 0.03, 0,   0,    0.1,  0.05, 0.06, 0.07, 0}}};
        const Outcome r = run(p, input, uniforms);
        // Unbound textures give (0, 0, 0, 1): albedo 0, gloss 1, tangent-space normal (1, -1, ...) with z =
        // 0.
        for (int lane = 0; lane < vm::kLanes; lane += 7) {
          const auto in = [&](const char* s) {
            return std::array<double, 3>{input(s, 0, lane), input(s, 1, lane), input(s, 2, lane)};
          };
          using V = std::array<double, 3>;
          const auto dot = [](const V& x, const V& y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
          const auto unit = [&](V x) {
            const double s = 1 / std::sqrt(dot(x, x));
            return V{x[0] * s, x[1] * s, x[2] * s};
          };
          const V position = in("TEXCOORD1"), tangent = in("TEXCOORD3"), binormal = in("TEXCOORD4");
          const V n = unit({tangent[0] - binormal[0], tangent[1] - binormal[1], tangent[2] - binormal[2]});
          const V v = unit({0.5 - position[0], 1 - position[1], 6 - position[2]});
          const double m = 8192;
          V sum{};
          for (std::size_t k = 0; k < 3; ++k) {
            const auto& light = uniforms.at("light_position");
            const V to{light[4 * k] - position[0], light[4 * k + 1] - position[1],
                       light[4 * k + 2] - position[2]};
            const double d2 = dot(to, to);
            const V l = unit(to), h = unit({l[0] + v[0], l[1] + v[1], l[2] + v[2]});
            const double nl = clamp01(dot(n, l)), nh = clamp01(dot(n, h)), hv = clamp01(dot(h, l)),
                         nv = clamp01(dot(n, v));
            const double attenuation = std::pow(clamp01(1 - d2 * light[4 * k + 3]), 2);
            double d = (visibility == 1 ? 2 * m + 1 : m + 2) / 8 * std::pow(nh, m);
            const double a = 1 / std::sqrt(M_PI / 4 * m + M_PI / 2);
            if (visibility == 2) d /= (nl * (1 - a) + a) * (nv * (1 - a) + a);
            for (std::size_t c = 0; c < 3; ++c)
              sum[c] += std::pow(1 - hv, 5) * d * uniforms.at("light_color")[4 * k + c] * nl * attenuation;
          }
          for (std::size_t c = 0; c < 3; ++c) {
            const double lit = std::max(sum[c] * 0.8, 0.0);
            const double expected =
                ((lit * (0.22 * lit + 0.03) + 0.002) / (lit * (0.3 * lit + 0.5) + 0.06) - 0.0666667) * 1.5;
            // fp32 literals, and (n.h)^8192 magnifies a relative error of 2^-46 in n.h to 1e-10
            EXPECT_NEAR(r.outputs.at("COLOR0")[static_cast<std::size_t>(lane)][c], expected, 1e-6)
                << file << " lane " << lane;
          }
        }
      }
}

}  // namespace
}  // namespace aluminate::compiler::testing
