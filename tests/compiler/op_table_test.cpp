// Every SPIR-V operation and GLSL.std.450 function of the language, one row each: accepted, and with the value that
// plain double arithmetic gives; or refused by its name. Modules are written in SPIR-V assembly, so that no front end and
// no optimizer stands between the row and the lowering.
#include "tests/compiler/shader_runner.hpp"

#include <spirv-tools/libspirv.hpp>

#include <cmath>

namespace aluminate::compiler::testing {
namespace {

using V = Float4;

struct Row {
  const char* name;
  const char* body;  // makes %r, a vec4, of %x %y %z
  std::function<V(const V&, const V&, const V&)> expected;
  double tolerance = 1e-9;
};

// %x %y %z: inputs; %xi %yi: as int, %xu: |x| as uint; %xs %ys: first components; %less: x < y
std::string module_text(const std::string& body) {
  return R"(OpCapability Shader
OpCapability DerivativeControl
%glsl = OpExtInstImport "GLSL.std.450"
OpMemoryModel Logical GLSL450
OpEntryPoint Fragment %main "main" %a %b %c %o
OpExecutionMode %main OriginUpperLeft
OpDecorate %a Location 0
OpDecorate %b Location 1
OpDecorate %c Location 2
OpDecorate %o Location 0
%void = OpTypeVoid
%fn = OpTypeFunction %void
%float = OpTypeFloat 32
%int = OpTypeInt 32 1
%uint = OpTypeInt 32 0
%bool = OpTypeBool
%v2 = OpTypeVector %float 2
%v3 = OpTypeVector %float 3
%v4 = OpTypeVector %float 4
%i4 = OpTypeVector %int 4
%u4 = OpTypeVector %uint 4
%b4 = OpTypeVector %bool 4
%m2 = OpTypeMatrix %v2 2
%m4 = OpTypeMatrix %v4 4
%pair = OpTypeStruct %v4 %float
%arr = OpTypeArray %float %u3
%u3 = OpConstant %uint 3
%pin = OpTypePointer Input %v4
%pout = OpTypePointer Output %v4
%pfn = OpTypePointer Function %v4
%pff = OpTypePointer Function %float
%a = OpVariable %pin Input
%b = OpVariable %pin Input
%c = OpVariable %pin Input
%o = OpVariable %pout Output
%f0 = OpConstant %float 0
%f1 = OpConstant %float 1
%f2 = OpConstant %float 2
%fhalf = OpConstant %float 0.5
%i0 = OpConstant %int 0
%i1 = OpConstant %int 1
%i2 = OpConstant %int 2
%i3 = OpConstant %int 3
%c0 = OpConstantComposite %v4 %f0 %f0 %f0 %f0
%c1 = OpConstantComposite %v4 %f1 %f1 %f1 %f1
%c2 = OpConstantComposite %v4 %f2 %f2 %f2 %f2
%i22 = OpConstantComposite %i4 %i2 %i2 %i2 %i2
%i33 = OpConstantComposite %i4 %i3 %i3 %i3 %i3
%null4 = OpConstantNull %v4
%true = OpConstantTrue %bool
%false = OpConstantFalse %bool
%main = OpFunction %void None %fn
%entry = OpLabel
%local = OpVariable %pfn Function
%x = OpLoad %v4 %a
%y = OpLoad %v4 %b
%z = OpLoad %v4 %c
%xi = OpConvertFToS %i4 %x
%yi = OpConvertFToS %i4 %y
%xa = OpExtInst %v4 %glsl FAbs %x
%xu = OpConvertFToU %u4 %xa
%xs = OpCompositeExtract %float %x 0
%ys = OpCompositeExtract %float %y 0
%less = OpFOrdLessThan %b4 %x %y
)" + body + R"(
OpStore %o %r
OpReturn
OpFunctionEnd
)";
}

std::string assemble(const std::string& text) {
  // OpTypeArray stands before its length above only for reading: the assembler takes ids in any order, the validator not.
  std::string ordered = text;
  const std::string array = "%arr = OpTypeArray %float %u3\n", length = "%u3 = OpConstant %uint 3\n";
  if (const auto at = ordered.find(array + length); at != std::string::npos)
    ordered.replace(at, array.size() + length.size(), length + array);
  spvtools::SpirvTools tools(SPV_ENV_UNIVERSAL_1_5);
  std::string message;
  tools.SetMessageConsumer([&](spv_message_level_t, const char*, const spv_position_t& at, const char* m) {
    message += fmt::format("{}: {}\n", at.line, m);
  });
  std::vector<std::uint32_t> words;
  EXPECT_TRUE(tools.Assemble(ordered, &words)) << message;
  return {reinterpret_cast<const char*>(words.data()), words.size() * 4};
}

template <class F>
std::function<V(const V&, const V&, const V&)> each(F f) {
  return [f](const V& x, const V& y, const V& z) {
    V r{};
    for (std::size_t k = 0; k < 4; ++k) r[k] = f(x[k], y[k], z[k]);
    return r;
  };
}
template <class F>
std::function<V(const V&, const V&, const V&)> all(F f) {  // one number, in every component
  return [f](const V& x, const V& y, const V& z) {
    const double r = f(x, y, z);
    return V{r, r, r, r};
  };
}
double t(double x) { return std::trunc(x); }
double dot(const V& a, const V& b, int n = 4) {
  double sum = 0;
  for (int k = 0; k < n; ++k) sum += a[static_cast<std::size_t>(k)] * b[static_cast<std::size_t>(k)];
  return sum;
}

// A comparison's result as 0 or 1.
#define AS_NUMBER "\n%r = OpSelect %v4 %q %c1 %c0"
#define AS_FLOAT "\n%r = OpConvertSToF %v4 %q"
#define AS_UFLOAT "\n%r = OpConvertUToF %v4 %q"
#define SPREAD "\n%r = OpCompositeConstruct %v4 %q %q %q %q"
#define SPREAD_BOOL "\n%w = OpSelect %float %q %f1 %f0\n%r = OpCompositeConstruct %v4 %w %w %w %w"
#define EACH(...) each([](double x, double y, double z) -> double { (void)x, (void)y, (void)z; return __VA_ARGS__; })
#define ALL(...) all([](const V& x, const V& y, const V& z) -> double { (void)x, (void)y, (void)z; return __VA_ARGS__; })

const std::vector<Row>& operations() {
  static const std::vector<Row> rows{
      {"FNegate", "%r = OpFNegate %v4 %x", EACH(-x)},
      {"FAdd", "%r = OpFAdd %v4 %x %y", EACH(x + y)},
      {"FSub", "%r = OpFSub %v4 %x %y", EACH(x - y)},
      {"FMul", "%r = OpFMul %v4 %x %y", EACH(x * y)},
      {"FDiv", "%d = OpFAdd %v4 %xa %c1\n%r = OpFDiv %v4 %y %d", EACH(y / (std::fabs(x) + 1))},
      {"FMod", "%d = OpFAdd %v4 %xa %c1\n%r = OpFMod %v4 %y %d",
       EACH(y - (std::fabs(x) + 1) * std::floor(y / (std::fabs(x) + 1)))},
      {"FRem", "%d = OpFAdd %v4 %xa %c1\n%r = OpFRem %v4 %y %d", EACH(std::fmod(y, std::fabs(x) + 1))},
      {"VectorTimesScalar", "%r = OpVectorTimesScalar %v4 %x %ys",
       [](const V& x, const V& y, const V&) { return V{x[0] * y[0], x[1] * y[0], x[2] * y[0], x[3] * y[0]}; }},
      {"Dot", "%q = OpDot %float %x %y" SPREAD, ALL(dot(x, y))},
      {"SNegate", "%q = OpSNegate %i4 %xi" AS_FLOAT, EACH(-t(x))},
      {"IAdd", "%q = OpIAdd %i4 %xi %yi" AS_FLOAT, EACH(t(x) + t(y))},
      {"ISub", "%q = OpISub %i4 %xi %yi" AS_FLOAT, EACH(t(x) - t(y))},
      {"IMul", "%q = OpIMul %i4 %xi %yi" AS_FLOAT, EACH(t(x) * t(y))},
      {"SDiv", "%q = OpSDiv %i4 %xi %i33" AS_FLOAT, EACH(t(t(x) / 3))},
      {"UDiv", "%d = OpBitcast %u4 %i33\n%q = OpUDiv %u4 %xu %d" AS_UFLOAT, EACH(std::floor(t(std::fabs(x)) / 3))},
      {"SRem", "%q = OpSRem %i4 %xi %i33" AS_FLOAT, EACH(std::fmod(t(x), 3))},
      {"SMod", "%q = OpSMod %i4 %xi %i33" AS_FLOAT, EACH(t(x) - 3 * std::floor(t(x) / 3))},
      {"UMod", "%d = OpBitcast %u4 %i33\n%q = OpUMod %u4 %xu %d" AS_UFLOAT, EACH(std::fmod(t(std::fabs(x)), 3))},
      {"ShiftLeftLogical", "%q = OpShiftLeftLogical %i4 %xi %i22" AS_FLOAT, EACH(t(x) * 4)},
      {"ShiftRightLogical", "%q = OpShiftRightLogical %u4 %xu %i22" AS_UFLOAT, EACH(std::floor(t(std::fabs(x)) / 4))},
      {"ShiftRightArithmetic", "%q = OpShiftRightArithmetic %i4 %xi %i22" AS_FLOAT, EACH(std::floor(t(x) / 4))},
      {"BitwiseAnd", "%q = OpBitwiseAnd %i4 %xi %i33" AS_FLOAT, EACH(t(x) - 4 * std::floor(t(x) / 4))},
      {"Bitcast", "%u = OpBitcast %u4 %xi\n%q = OpBitcast %i4 %u" AS_FLOAT, EACH(t(x))},
      {"ConvertFToS", "%r = OpConvertSToF %v4 %xi", EACH(t(x))},
      {"ConvertFToU", "%r = OpConvertUToF %v4 %xu", EACH(t(std::fabs(x)))},
      {"FConvert by name of the type", "%r = OpCopyObject %v4 %x", EACH(x)},
      {"FOrdEqual", "%q = OpFOrdEqual %b4 %x %y" AS_NUMBER, EACH(x == y)},
      {"FUnordEqual", "%q = OpFUnordEqual %b4 %x %y" AS_NUMBER, EACH(x == y)},
      {"FOrdNotEqual", "%q = OpFOrdNotEqual %b4 %x %y" AS_NUMBER, EACH(x != y)},
      {"FUnordNotEqual", "%q = OpFUnordNotEqual %b4 %x %y" AS_NUMBER, EACH(x != y)},
      {"FOrdLessThan", "%q = OpFOrdLessThan %b4 %x %y" AS_NUMBER, EACH(x < y)},
      {"FUnordLessThan", "%q = OpFUnordLessThan %b4 %x %y" AS_NUMBER, EACH(x < y)},
      {"FOrdGreaterThan", "%q = OpFOrdGreaterThan %b4 %x %y" AS_NUMBER, EACH(x > y)},
      {"FUnordGreaterThan", "%q = OpFUnordGreaterThan %b4 %x %y" AS_NUMBER, EACH(x > y)},
      {"FOrdLessThanEqual", "%q = OpFOrdLessThanEqual %b4 %x %y" AS_NUMBER, EACH(x <= y)},
      {"FUnordLessThanEqual", "%q = OpFUnordLessThanEqual %b4 %x %y" AS_NUMBER, EACH(x <= y)},
      {"FOrdGreaterThanEqual", "%q = OpFOrdGreaterThanEqual %b4 %x %y" AS_NUMBER, EACH(x >= y)},
      {"FUnordGreaterThanEqual", "%q = OpFUnordGreaterThanEqual %b4 %x %y" AS_NUMBER, EACH(x >= y)},
      {"IEqual", "%q = OpIEqual %b4 %xi %yi" AS_NUMBER, EACH(t(x) == t(y))},
      {"INotEqual", "%q = OpINotEqual %b4 %xi %yi" AS_NUMBER, EACH(t(x) != t(y))},
      {"SLessThan", "%q = OpSLessThan %b4 %xi %yi" AS_NUMBER, EACH(t(x) < t(y))},
      {"SLessThanEqual", "%q = OpSLessThanEqual %b4 %xi %yi" AS_NUMBER, EACH(t(x) <= t(y))},
      {"SGreaterThan", "%q = OpSGreaterThan %b4 %xi %yi" AS_NUMBER, EACH(t(x) > t(y))},
      {"SGreaterThanEqual", "%q = OpSGreaterThanEqual %b4 %xi %yi" AS_NUMBER, EACH(t(x) >= t(y))},
      {"ULessThan", "%d = OpBitcast %u4 %i22\n%q = OpULessThan %b4 %xu %d" AS_NUMBER, EACH(t(std::fabs(x)) < 2)},
      {"ULessThanEqual", "%d = OpBitcast %u4 %i22\n%q = OpULessThanEqual %b4 %xu %d" AS_NUMBER, EACH(t(std::fabs(x)) <= 2)},
      {"UGreaterThan", "%d = OpBitcast %u4 %i22\n%q = OpUGreaterThan %b4 %xu %d" AS_NUMBER, EACH(t(std::fabs(x)) > 2)},
      {"UGreaterThanEqual", "%d = OpBitcast %u4 %i22\n%q = OpUGreaterThanEqual %b4 %xu %d" AS_NUMBER,
       EACH(t(std::fabs(x)) >= 2)},
      {"LogicalAnd", "%p = OpFOrdLessThan %b4 %y %z\n%q = OpLogicalAnd %b4 %less %p" AS_NUMBER, EACH(x < y && y < z)},
      {"LogicalOr", "%p = OpFOrdLessThan %b4 %y %z\n%q = OpLogicalOr %b4 %less %p" AS_NUMBER, EACH(x < y || y < z)},
      {"LogicalNot", "%q = OpLogicalNot %b4 %less" AS_NUMBER, EACH(!(x < y))},
      {"LogicalEqual", "%p = OpFOrdLessThan %b4 %y %z\n%q = OpLogicalEqual %b4 %less %p" AS_NUMBER, EACH((x < y) == (y < z))},
      {"LogicalNotEqual", "%p = OpFOrdLessThan %b4 %y %z\n%q = OpLogicalNotEqual %b4 %less %p" AS_NUMBER,
       EACH((x < y) != (y < z))},
      {"Any", "%q = OpAny %bool %less" SPREAD_BOOL, ALL(x[0] < y[0] || x[1] < y[1] || x[2] < y[2] || x[3] < y[3])},
      {"All", "%q = OpAll %bool %less" SPREAD_BOOL, ALL(x[0] < y[0] && x[1] < y[1] && x[2] < y[2] && x[3] < y[3])},
      {"IsNan", "%q = OpIsNan %b4 %x" AS_NUMBER, EACH(0)},
      {"IsInf", "%q = OpIsInf %b4 %x" AS_NUMBER, EACH(0)},
      {"Select", "%r = OpSelect %v4 %less %y %z", EACH(x < y ? y : z)},
      {"ConstantNull", "%r = OpFAdd %v4 %x %null4", EACH(x)},
      {"ConstantTrue", "%r = OpSelect %v4 %true %x %y", EACH(x)},
      {"Undef", "%u = OpUndef %v4\n%r = OpFAdd %v4 %x %u", EACH(x)},
      {"CopyObject", "%r = OpCopyObject %v4 %x", EACH(x)},
      {"CompositeConstruct, CompositeExtract, CompositeInsert",
       "%s = OpCompositeConstruct %pair %x %ys\n%s2 = OpCompositeInsert %pair %ys %s 0 2\n%r = OpCompositeExtract %v4 %s2 0",
       [](const V& x, const V& y, const V&) { return V{x[0], x[1], y[0], x[3]}; }},
      {"VectorShuffle", "%r = OpVectorShuffle %v4 %x %y 3 4 0 7",
       [](const V& x, const V& y, const V&) { return V{x[3], y[0], x[0], y[3]}; }},
      {"VectorExtractDynamic",
       "%u0 = OpCompositeExtract %uint %xu 0\n%q = OpVectorExtractDynamic %float %y %u0" SPREAD,
       ALL(y[static_cast<std::size_t>(std::min(t(std::fabs(x[0])), 3.0))])},
      {"VectorInsertDynamic", "%u0 = OpCompositeExtract %uint %xu 0\n%r = OpVectorInsertDynamic %v4 %y %xs %u0",
       [](const V& x, const V& y, const V&) {
         V r = y;
         const double at = t(std::fabs(x[0]));
         if (at < 4) r[static_cast<std::size_t>(at)] = x[0];
         return r;
       }},
      {"Variable, AccessChain, Load, Store",
       "OpStore %local %x\n%p = OpAccessChain %pff %local %i2\nOpStore %p %ys\n%r = OpLoad %v4 %local",
       [](const V& x, const V& y, const V&) { return V{x[0], x[1], y[0], x[3]}; }},
      {"MatrixTimesVector", "%m = OpCompositeConstruct %m4 %x %y %z %x\n%r = OpMatrixTimesVector %v4 %m %y",
       [](const V& x, const V& y, const V& z) {
         V r{};
         for (std::size_t k = 0; k < 4; ++k) r[k] = x[k] * y[0] + y[k] * y[1] + z[k] * y[2] + x[k] * y[3];
         return r;
       }},
      {"VectorTimesMatrix", "%m = OpCompositeConstruct %m4 %x %y %z %x\n%r = OpVectorTimesMatrix %v4 %y %m",
       [](const V& x, const V& y, const V& z) { return V{dot(y, x), dot(y, y), dot(y, z), dot(y, x)}; }},
      {"MatrixTimesScalar",
       "%m = OpCompositeConstruct %m4 %x %y %z %x\n%n = OpMatrixTimesScalar %m4 %m %ys\n%r = OpCompositeExtract %v4 %n 2",
       [](const V&, const V& y, const V& z) { return V{z[0] * y[0], z[1] * y[0], z[2] * y[0], z[3] * y[0]}; }},
      {"MatrixTimesMatrix",
       "%m = OpCompositeConstruct %m4 %x %y %z %x\n%n = OpMatrixTimesMatrix %m4 %m %m\n%r = OpCompositeExtract %v4 %n 1",
       [](const V& x, const V& y, const V& z) {
         V r{};
         for (std::size_t k = 0; k < 4; ++k) r[k] = x[k] * y[0] + y[k] * y[1] + z[k] * y[2] + x[k] * y[3];
         return r;
       }},
      {"Transpose", "%m = OpCompositeConstruct %m4 %x %y %z %x\n%n = OpTranspose %m4 %m\n%r = OpCompositeExtract %v4 %n 1",
       [](const V& x, const V& y, const V& z) { return V{x[1], y[1], z[1], x[1]}; }},
      {"OuterProduct", "%n = OpOuterProduct %m4 %x %y\n%r = OpCompositeExtract %v4 %n 3",
       [](const V& x, const V& y, const V&) { return V{x[0] * y[3], x[1] * y[3], x[2] * y[3], x[3] * y[3]}; }},
      {"Branch, BranchConditional, SelectionMerge, Phi",
       "%q = OpFOrdLessThan %bool %xs %ys\nOpSelectionMerge %m None\nOpBranchConditional %q %yes %no\n%yes = OpLabel\n"
       "%p1 = OpFMul %v4 %x %z\nOpBranch %m\n%no = OpLabel\n%p2 = OpFAdd %v4 %y %z\nOpBranch %m\n%m = OpLabel\n"
       "%r = OpPhi %v4 %p1 %yes %p2 %no",
       [](const V& x, const V& y, const V& z) {
         V r{};
         for (std::size_t k = 0; k < 4; ++k) r[k] = x[0] < y[0] ? x[k] * z[k] : y[k] + z[k];
         return r;
       }},
      {"Switch",
       "%k = OpCompositeExtract %int %xi 0\nOpSelectionMerge %m None\nOpSwitch %k %d 1 %one 2 %two -2 %two\n"
       "%one = OpLabel\n%p1 = OpFMul %v4 %x %z\nOpBranch %two\n%two = OpLabel\n%p2 = OpPhi %v4 %y %entry %p1 %one\n"
       "OpBranch %m\n%d = OpLabel\nOpBranch %m\n%m = OpLabel\n%r = OpPhi %v4 %p2 %two %z %d",
       [](const V& x, const V& y, const V& z) {
         const double k = t(x[0]);
         V r{};
         for (std::size_t c = 0; c < 4; ++c) r[c] = k == 1 ? x[c] * z[c] : std::fabs(k) == 2 ? y[c] : z[c];
         return r;
       }},
      {"LoopMerge, back edge, break",
       "%u0 = OpCompositeExtract %uint %xu 0\n%k = OpBitcast %int %u0\nOpBranch %h\n%h = OpLabel\n"
       "%n = OpPhi %int %i0 %entry %n1 %cont\n%s = OpPhi %v4 %x %entry %s1 %cont\nOpLoopMerge %m %cont None\nOpBranch %test\n"
       "%test = OpLabel\n%q = OpSLessThan %bool %n %k\nOpBranchConditional %q %cont %m\n%cont = OpLabel\n"
       "%s1 = OpFAdd %v4 %s %y\n%n1 = OpIAdd %int %n %i1\nOpBranch %h\n%m = OpLabel\n%r = OpCopyObject %v4 %s",
       [](const V& x, const V& y, const V&) {
         V r = x;
         for (std::size_t k = 0; k < 4; ++k) r[k] += t(std::fabs(x[0])) * y[k];
         return r;
       }},
  };
  return rows;
}

const std::vector<Row>& functions() {
#define GLSL(op) "%r = OpExtInst %v4 %glsl " op
#define GLSL_INT(op) "%q = OpExtInst %i4 %glsl " op AS_FLOAT
#define GLSL_UINT(op) "%q = OpExtInst %u4 %glsl " op AS_UFLOAT
  static const std::vector<Row> rows{
      {"Round", GLSL("Round %x"), EACH(std::floor(x + 0.5))},
      {"RoundEven", GLSL("RoundEven %x"), EACH(std::nearbyint(x))},
      {"Trunc", GLSL("Trunc %x"), EACH(t(x))},
      {"FAbs", GLSL("FAbs %x"), EACH(std::fabs(x))},
      {"SAbs", GLSL_INT("SAbs %xi"), EACH(std::fabs(t(x)))},
      {"FSign", GLSL("FSign %x"), EACH((x > 0) - (x < 0))},
      {"SSign", GLSL_INT("SSign %xi"), EACH((t(x) > 0) - (t(x) < 0))},
      {"Floor", GLSL("Floor %x"), EACH(std::floor(x))},
      {"Ceil", GLSL("Ceil %x"), EACH(std::ceil(x))},
      {"Fract", GLSL("Fract %x"), EACH(x - std::floor(x))},
      {"Radians", GLSL("Radians %x"), EACH(x * 0.017453292519943295)},
      {"Degrees", GLSL("Degrees %x"), EACH(x * 57.29577951308232)},
      {"Sin", GLSL("Sin %x"), EACH(std::sin(x)), 1e-6},
      {"Cos", GLSL("Cos %x"), EACH(std::cos(x)), 1e-6},
      {"Tan", "%q = OpVectorTimesScalar %v4 %x %fq\n" GLSL("Tan %q"), EACH(std::tan(x * 0.25)), 1e-6},
      {"Asin", "%q = OpVectorTimesScalar %v4 %x %fq\n" GLSL("Asin %q"), EACH(std::asin(x * 0.25)), 2e-4},
      {"Acos", "%q = OpVectorTimesScalar %v4 %x %fq\n" GLSL("Acos %q"), EACH(std::acos(x * 0.25)), 2e-4},
      {"Atan", GLSL("Atan %x"), EACH(std::atan(x)), 1e-4},
      {"Atan2", "%d = OpFAdd %v4 %xa %c1\n" GLSL("Atan2 %y %d"), EACH(std::atan2(y, std::fabs(x) + 1)), 1e-4},
      {"Sinh", GLSL("Sinh %x"), EACH(std::sinh(x)), 1e-5},
      {"Cosh", GLSL("Cosh %x"), EACH(std::cosh(x)), 1e-5},
      {"Tanh", GLSL("Tanh %x"), EACH(std::tanh(x)), 1e-6},
      {"Asinh", GLSL("Asinh %x"), EACH(std::asinh(x)), 1e-5},
      {"Acosh", "%d = OpFAdd %v4 %xa %c1\n" GLSL("Acosh %d"), EACH(std::acosh(std::fabs(x) + 1)), 1e-5},
      {"Atanh", "%d = OpVectorTimesScalar %v4 %x %feighth\n" GLSL("Atanh %d"), EACH(std::atanh(x * 0.125)), 1e-5},
      {"Pow", "%d = OpFAdd %v4 %xa %c1\n" GLSL("Pow %d %y"), EACH(std::pow(std::fabs(x) + 1, y)), 1e-5},
      {"Exp", GLSL("Exp %x"), EACH(std::exp(x)), 1e-6},
      {"Log", "%d = OpFAdd %v4 %xa %c1\n" GLSL("Log %d"), EACH(std::log(std::fabs(x) + 1)), 1e-7},
      {"Exp2", GLSL("Exp2 %x"), EACH(std::exp2(x)), 1e-6},
      {"Log2", "%d = OpFAdd %v4 %xa %c1\n" GLSL("Log2 %d"), EACH(std::log2(std::fabs(x) + 1)), 1e-7},
      {"Sqrt", GLSL("Sqrt %xa"), EACH(std::sqrt(std::fabs(x)))},
      {"InverseSqrt", "%d = OpFAdd %v4 %xa %c1\n" GLSL("InverseSqrt %d"), EACH(1 / std::sqrt(std::fabs(x) + 1))},
      {"FMin", GLSL("FMin %x %y"), EACH(std::min(x, y))},
      {"UMin", GLSL_UINT("UMin %xu %xu"), EACH(t(std::fabs(x)))},
      {"SMin", GLSL_INT("SMin %xi %yi"), EACH(std::min(t(x), t(y)))},
      {"FMax", GLSL("FMax %x %y"), EACH(std::max(x, y))},
      {"UMax", GLSL_UINT("UMax %xu %xu"), EACH(t(std::fabs(x)))},
      {"SMax", GLSL_INT("SMax %xi %yi"), EACH(std::max(t(x), t(y)))},
      {"FClamp", GLSL("FClamp %x %c0 %c2"), EACH(std::clamp(x, 0.0, 2.0))},
      {"UClamp", "%d = OpBitcast %u4 %i22\n%e = OpBitcast %u4 %i33\n" GLSL_UINT("UClamp %xu %d %e"),
       EACH(std::clamp(t(std::fabs(x)), 2.0, 3.0))},
      {"SClamp", "%d = OpSNegate %i4 %i22\n" GLSL_INT("SClamp %xi %d %i22"), EACH(std::clamp(t(x), -2.0, 2.0))},
      {"FMix", GLSL("FMix %x %y %z"), EACH(x * (1 - z) + y * z)},
      {"Step", GLSL("Step %x %y"), EACH(y < x ? 0 : 1)},
      {"SmoothStep", GLSL("SmoothStep %c0 %c2 %x"),
       EACH(std::clamp(x / 2, 0.0, 1.0) * std::clamp(x / 2, 0.0, 1.0) * (3 - 2 * std::clamp(x / 2, 0.0, 1.0)))},
      {"Fma", GLSL("Fma %x %y %z"), EACH(x * y + z)},
      {"Ldexp", GLSL("Ldexp %x %yi"), EACH(std::ldexp(x, static_cast<int>(t(y)))), 1e-6},
      {"Length", "%q = OpExtInst %float %glsl Length %x" SPREAD, ALL(std::sqrt(dot(x, x)))},
      {"Distance", "%q = OpExtInst %float %glsl Distance %x %y" SPREAD,
       ALL(std::sqrt(dot(x, x) - 2 * dot(x, y) + dot(y, y)))},
      {"Cross", "%p = OpVectorShuffle %v3 %x %x 0 1 2\n%q = OpVectorShuffle %v3 %y %y 0 1 2\n"
                "%s = OpExtInst %v3 %glsl Cross %p %q\n%r = OpCompositeConstruct %v4 %s %f1",
       [](const V& x, const V& y, const V&) {
         return V{x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0], 1};
       }},
      {"Normalize", "%d = OpFAdd %v4 %xa %c1\n" GLSL("Normalize %d"),
       [](const V& x, const V&, const V&) {
         V d{};
         for (std::size_t k = 0; k < 4; ++k) d[k] = std::fabs(x[k]) + 1;
         const double l = std::sqrt(dot(d, d));
         return V{d[0] / l, d[1] / l, d[2] / l, d[3] / l};
       }},
      {"FaceForward", GLSL("FaceForward %x %y %z"),
       [](const V& x, const V& y, const V& z) {
         const double s = dot(z, y) < 0 ? 1 : -1;
         return V{s * x[0], s * x[1], s * x[2], s * x[3]};
       }},
      {"Reflect", GLSL("Reflect %x %y"),
       [](const V& x, const V& y, const V&) {
         V r{};
         for (std::size_t k = 0; k < 4; ++k) r[k] = x[k] - 2 * dot(y, x) * y[k];
         return r;
       }},
      {"Refract", "%d = OpFAdd %v4 %xa %c1\n%n = OpExtInst %v4 %glsl Normalize %d\n%i = OpFNegate %v4 %n\n" GLSL("Refract %i %n %fhalf"),
       [](const V& x, const V&, const V&) {
         V d{};
         for (std::size_t k = 0; k < 4; ++k) d[k] = std::fabs(x[k]) + 1;
         const double l = std::sqrt(dot(d, d));
         return V{-d[0] / l, -d[1] / l, -d[2] / l, -d[3] / l};  // along the normal nothing bends
       }},
      {"NMin", GLSL("NMin %x %y"), EACH(std::min(x, y))},
      {"NMax", GLSL("NMax %x %y"), EACH(std::max(x, y))},
      {"NClamp", GLSL("NClamp %x %c0 %c2"), EACH(std::clamp(x, 0.0, 2.0))},
  };
  return rows;
}

void expect_row(const Row& row, bool optimise) {
  SCOPED_TRACE(std::string(row.name) + (optimise ? ", optimised" : ""));
  std::string text = module_text(row.body);
  text.replace(text.find("%fhalf = "), 0, "%fq = OpConstant %float 0.25\n%feighth = OpConstant %float 0.125\n");
  Options o = options_for(assemble(text), Language::Spirv);
  o.source_path = "row.spv";
  o.optimise = optimise;
  Outcome outcome;
  try {
    outcome = run(compile_valid(o), test_value);
  } catch (const UserError& e) {
    ADD_FAILURE() << e.what();
    return;
  }
  const auto& result = outcome.outputs["COLOR0"];
  for (int lane = 0; lane < vm::kLanes; ++lane) {
    V in[3];
    for (int v = 0; v < 3; ++v)
      for (int c = 0; c < 4; ++c)
        in[v][static_cast<std::size_t>(c)] = test_value("TEXCOORD" + std::to_string(v), c, lane);
    const V expected = row.expected(in[0], in[1], in[2]);
    for (std::size_t c = 0; c < 4; ++c) {
      const double is = result[static_cast<std::size_t>(lane)][c];
      EXPECT_NEAR(is, expected[c], row.tolerance * std::max(1.0, std::fabs(expected[c]))) << "lane " << lane << " " << c;
      if (::testing::Test::HasFailure()) return;
    }
  }
}

TEST(OpTable, OperationsGiveTheValueOfPlainArithmetic) {
  for (const Row& row : operations())
    for (const bool optimise : {false, true}) expect_row(row, optimise);
}

TEST(OpTable, ExtendedFunctionsGiveTheValueOfPlainArithmetic) {
  for (const Row& row : functions())
    for (const bool optimise : {false, true}) expect_row(row, optimise);
}

TEST(OpTable, WhatIsOutsideTheLanguageIsRefusedByName) {
  struct Refused {
    const char *name, *body;
  };
  const Refused rows[] = {
      {"OpBitwiseOr", "%q = OpBitwiseOr %i4 %xi %yi" AS_FLOAT},
      {"OpBitwiseXor", "%q = OpBitwiseXor %i4 %xi %yi" AS_FLOAT},
      {"OpNot", "%q = OpNot %i4 %xi" AS_FLOAT},
      {"OpBitReverse", "%q = OpBitReverse %i4 %xi" AS_FLOAT},
      {"OpBitCount", "%q = OpBitCount %i4 %xi" AS_FLOAT},
      {"OpBitFieldSExtract", "%q = OpBitFieldSExtract %i4 %xi %i1 %i2" AS_FLOAT},
      {"OpBitFieldUExtract", "%q = OpBitFieldUExtract %u4 %xu %i1 %i2" AS_UFLOAT},
      {"OpBitFieldInsert", "%q = OpBitFieldInsert %i4 %xi %yi %i1 %i2" AS_FLOAT},
      {"OpShiftLeftLogical", "%q = OpShiftLeftLogical %i4 %xi %yi" AS_FLOAT},
      {"OpBitcast", "%q = OpBitcast %i4 %x" AS_FLOAT},
      {"Determinant",
       "%p = OpVectorShuffle %v2 %x %x 0 1\n%m = OpCompositeConstruct %m2 %p %p\n%q = OpExtInst %float %glsl Determinant %m" SPREAD},
      {"PackUnorm4x8", "%w = OpExtInst %uint %glsl PackUnorm4x8 %x\n%q = OpConvertUToF %float %w" SPREAD},
      {"UnpackUnorm4x8", "%u0 = OpCompositeExtract %uint %xu 0\n%r = OpExtInst %v4 %glsl UnpackUnorm4x8 %u0"},
      {"FindSMsb", "%q = OpExtInst %i4 %glsl FindSMsb %xi" AS_FLOAT},
  };
  for (const Refused& row : rows) {
    SCOPED_TRACE(row.name);
    Options o = options_for(assemble(module_text(row.body)), Language::Spirv);
    o.source_path = "row.spv";
    try {
      compile(o);
      ADD_FAILURE() << "accepted";
    } catch (const UserError& e) {
      EXPECT_NE(std::string(e.what()).find(row.name), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace aluminate::compiler::testing
