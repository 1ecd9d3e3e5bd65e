// Names, registers and stages: what a caller binds to.
#include "tests/compiler/shader_runner.hpp"

#include <filesystem>
#include <fstream>
#include <thread>

namespace aluminate::compiler::testing {
namespace {

const vm::UniformSymbol* uniform(const vm::Program& p, const std::string& name) {
  for (const auto& u : p.uniforms)
    if (u.name == name) return &u;
  return nullptr;
}

#define EXPECT_UNIFORM(program, symbol, register_, first, count_, width) \
  do {                                                                   \
    const vm::UniformSymbol* u = uniform(program, symbol);               \
    ASSERT_NE(u, nullptr) << symbol;                                     \
    EXPECT_EQ(u->reg, register_) << symbol;                              \
    EXPECT_EQ(u->component, first) << symbol;                            \
    EXPECT_EQ(u->registers, count_) << symbol;                           \
    EXPECT_EQ(u->components, width) << symbol;                           \
  } while (false)

TEST(Uniforms, EveryOneStartsARegisterInDeclarationOrder) {
  const vm::Program p =
      compile_valid(options_for("float a; float3 b; float2 c[3]; float4x4 m; float4 main() : COLOR0 { return "
                                "float4(b, a) + c[2].xyxy + mul(b.xyzz, m); }"));
  EXPECT_UNIFORM(p, "a", 0, 0, 1, 1);
  EXPECT_UNIFORM(p, "b", 1, 0, 1, 3);
  EXPECT_UNIFORM(p, "c", 2, 0, 3, 2);
  EXPECT_UNIFORM(p, "m", 5, 0, 4, 4);
  EXPECT_EQ(p.uniform_count, 9);
}

TEST(Uniforms, RegistersAreHonouredAndTheRestFillsUpAroundThem) {
  const vm::Program p =
      compile_valid(options_for("float a; float4 fixed2 : register(c2); float b; float c; float4 fixed9[2] : "
                                "register(c9); float4 d : register(c1);\n"
                                "float4 main() : COLOR0 { return a + b + c + fixed2 + fixed9[1] + d; }"));
  EXPECT_UNIFORM(p, "fixed2", 2, 0, 1, 4);
  EXPECT_UNIFORM(p, "fixed9", 9, 0, 2, 4);
  EXPECT_UNIFORM(p, "d", 1, 0, 1, 4);
  EXPECT_UNIFORM(p, "a", 0, 0, 1, 1);
  EXPECT_UNIFORM(p, "b", 3, 0, 1, 1);
  EXPECT_UNIFORM(p, "c", 4, 0, 1, 1);
}

TEST(Uniforms, StructMembersAreNamedAndMayShareARegister) {
  const vm::Program p = compile_valid(
      options_for("struct Light { float3 position; float range; float4 color; }; Light lights[3]; float4 "
                  "main() : COLOR0 { return lights[2].color * lights[1].range; }"));
  EXPECT_UNIFORM(p, "lights[1].position", 2, 0, 1, 3);
  EXPECT_UNIFORM(p, "lights[1].range", 2, 3, 1, 1);
  EXPECT_UNIFORM(p, "lights[2].color", 5, 0, 1, 4);
}

TEST(Uniforms, GlslBlocksAndLooseUniforms) {
  const vm::Program p =
      compile_valid(options_for("#version 450\nuniform vec3 loose; uniform float gain; layout(binding = 3) "
                                "uniform Block { vec4 first; mat4 m; } block;\n"
                                "layout(location = 2) in vec4 v; layout(location = 1) out vec4 c; void "
                                "main() { c = block.m * v * gain + block.first + loose.xyzx; }",
                                Language::Glsl));
  EXPECT_UNIFORM(p, "loose", 0, 0, 1, 3);
  EXPECT_UNIFORM(p, "gain", 1, 0, 1, 1);
  EXPECT_UNIFORM(p, "first", 2, 0, 1, 4);
  EXPECT_UNIFORM(p, "m", 3, 0, 4, 4);
  ASSERT_EQ(p.inputs.size(), 1u);
  EXPECT_EQ(p.inputs[0].semantic, "TEXCOORD2");
  EXPECT_EQ(p.outputs[0].semantic, "COLOR1");
}

TEST(Samplers, FollowTheirRegisters) {
  const vm::Program p =
      compile_valid(options_for("sampler2D second : register(s4); samplerCUBE third : register(s7); "
                                "sampler2D first : register(s1); sampler3D volume : register(s9);\n"
                                "float4 main(float3 t : TEXCOORD0) : COLOR0 { return texCUBE(third, t) + "
                                "tex2D(second, t.xy) + tex2D(first, t.yx) + tex3D(volume, t); }"));
  ASSERT_EQ(p.samplers.size(), 4u);
  EXPECT_EQ(p.samplers[0].name, "first");
  EXPECT_EQ(p.samplers[1].name, "second");
  EXPECT_EQ(p.samplers[2].name, "third");
  EXPECT_EQ(p.samplers[2].dimension, vm::SamplerDimension::TexCube);
  EXPECT_EQ(p.samplers[3].dimension, vm::SamplerDimension::Tex3D);
}

TEST(Samplers, EveryWayToSampleHasItsInstruction) {
  const vm::Program p = compile_valid(
      options_for("sampler2D s; Texture2D t; SamplerState st;\n"
                  "float4 main(float4 u : TEXCOORD0) : COLOR0 { return tex2D(s, u.xy) + tex2Dlod(s, u) + "
                  "tex2Dbias(s, u) + tex2Dgrad(s, u.xy, u.zw, u.yx) + tex2Dproj(s, u)\n"
                  " + t.Sample(st, u.zw) + t.SampleLevel(st, u.xy, 2) + t.SampleBias(st, u.xy, -1) + "
                  "t.SampleGrad(st, u.xy, u.zw, u.yx); }"));
  EXPECT_EQ(count(p, vm::Opcode::Tex), 3) << listing(p);
  EXPECT_EQ(count(p, vm::Opcode::TexLod), 2);
  EXPECT_EQ(count(p, vm::Opcode::TexBias), 2);
  EXPECT_EQ(count(p, vm::Opcode::TexGrad), 2);
  EXPECT_EQ(count(p, vm::Opcode::Rcp), 1);  // tex2Dproj
}

TEST(Semantics, PixelInputsAndOutputs) {
  const vm::Program p = compile_valid(
      options_for("struct In { float4 color : COLOR; float2 uv : texcoord3; float3 n : NORMAL; };\n"
                  "struct Out { float4 c0 : COLOR0; float4 c1 : SV_Target1; float z : DEPTH; };\n"
                  "Out main(In i, float2 at : VPOS, float face : VFACE) { Out o; o.c0 = i.color * face; o.c1 "
                  "= float4(i.uv, at); o.z = i.n.z; return o; }"));
  std::map<std::string, int> in, out;
  for (const auto& s : p.inputs) in[s.semantic] = s.mask;
  for (const auto& s : p.outputs) out[s.semantic] = s.mask;
  EXPECT_EQ(in, (std::map<std::string, int>{
                    {"COLOR0", 15}, {"TEXCOORD3", 3}, {"NORMAL0", 4}, {"VPOS0", 3}, {"VFACE0", 1}}));
  EXPECT_EQ(out, (std::map<std::string, int>{{"COLOR0", 15}, {"COLOR1", 15}, {"DEPTH0", 1}}));
}

TEST(Semantics, FacingIsPlusOrMinusOneForBothLanguages) {
  const auto sign_of = [](const std::string&, int, int lane) { return lane % 2 == 0 ? 1.0 : -1.0; };
  const vm::Program hlsl = compile_valid(
      options_for("float4 main(bool front : SV_IsFrontFace) : SV_Target { return front ? 2 : 3; }"));
  const vm::Program glsl = compile_valid(options_for(
      "#version 450\nlayout(location = 0) out vec4 c; void main() { c = vec4(gl_FrontFacing ? 2 : 3); }",
      Language::Glsl));
  for (const vm::Program* p : {&hlsl, &glsl}) {
    ASSERT_EQ(p->inputs.size(), 1u);
    EXPECT_EQ(p->inputs[0].semantic, "VFACE0");
    const Outcome r = run(*p, sign_of);
    EXPECT_EQ(r.outputs.at("COLOR0")[0][0], 2);
    EXPECT_EQ(r.outputs.at("COLOR0")[1][0], 3);
  }
}

TEST(Semantics, VertexShaders) {
  Options o = options_for(
      "float4x4 world_to_clip; struct Out { float4 p : POSITION; float2 uv : TEXCOORD0; float3 n : "
      "TEXCOORD1; };\n"
      "Out main(float4 p : POSITION, float3 n : NORMAL, float2 uv : TEXCOORD0) { Out o; o.p = mul(p, "
      "world_to_clip); o.uv = uv * 2; o.n = n; return o; }");
  o.stage = vm::Stage::Vertex;
  const vm::Program p = compile_valid(o);
  EXPECT_EQ(p.stage, vm::Stage::Vertex);
  std::map<std::string, int> out;
  for (const auto& s : p.outputs) out[s.semantic] = s.mask;
  EXPECT_EQ(out, (std::map<std::string, int>{{"POSITION0", 15}, {"TEXCOORD0", 3}, {"TEXCOORD1", 7}}))
      << listing(p);
  Options g = options_for(
      "#version 450\nuniform mat4 m; layout(location = 0) in vec4 p; layout(location = 3) out vec2 uv; void "
      "main() { gl_Position = m * p; uv = p.xy; }",
      Language::Glsl);
  g.stage = vm::Stage::Vertex;
  const vm::Program q = compile_valid(g);
  out.clear();
  for (const auto& s : q.outputs) out[s.semantic] = s.mask;
  EXPECT_EQ(out, (std::map<std::string, int>{{"POSITION0", 15}, {"TEXCOORD3", 3}})) << listing(q);
}

TEST(Semantics, InputsNobodyReadsAreNotInterpolated) {
  const vm::Program p = compile_valid(
      options_for("float4 main(float4 a : TEXCOORD0, float4 b : TEXCOORD1) : COLOR0 { return b * 2; }"));
  ASSERT_EQ(p.inputs.size(), 1u);
  EXPECT_EQ(p.inputs[0].semantic, "TEXCOORD1");
}

TEST(Entries, AnyFunctionCanBeTheEntry) {
  Options o = options_for("float4 one() : COLOR0 { return 1; } float4 two() : COLOR0 { return 2; }");
  o.entry = "two";
  EXPECT_EQ(run(compile_valid(o), test_value).outputs.at("COLOR0")[5][2], 2);
}

TEST(Includes, AreFoundBesideTheSourceInDirectoriesAndInMemory) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "aluminate_includes";
  std::filesystem::create_directories(folder / "lib");
  std::ofstream(folder / "beside.hlsl") << "#include <inside.hlsl>\nfloat beside() { return inside(); }\n";
  std::ofstream(folder / "lib" / "inside.hlsl") << "float inside() { return 3; }\n";
  std::ofstream(folder / "main.hlsl") << "#include \"beside.hlsl\"\n#include \"memory.hlsl\"\nfloat4 main() "
                                         ": COLOR0 { return beside() + memory(); }\n";
  Options o;
  o.source_path = (folder / "main.hlsl").string();
  o.include_dirs = {(folder / "lib").string()};
  o.files["memory.hlsl"] = "float memory() { return 4; }\n";
  EXPECT_EQ(run(compile_valid(o), test_value).outputs.at("COLOR0")[0][0], 7);
  std::filesystem::remove_all(folder);
}

TEST(Compile, GivesTheSameProgramEveryTimeOnEveryThread) {
  Options o;
  o.source_path = ALUMINATE_SOURCE_DIR "/tests/compiler/fc3_reference.hlsl";
  o.defines = {{"VISIBILITY", "2"}};
  const std::string expected = listing(compile(o));
  std::vector<std::string> found(6);
  std::vector<std::thread> threads;
  for (std::string& f : found) threads.emplace_back([&] { f = listing(compile(o)); });
  for (std::thread& t : threads) t.join();
  for (const std::string& f : found) EXPECT_EQ(f, expected);
}

TEST(Compile, FixedPointFormatsRunWhatTheReferenceRuns) {
  const vm::Program p = compile_valid(
      options_for("float4 main(float4 a : TEXCOORD0, float4 b : TEXCOORD1) : COLOR0 { float s = 0; for (int "
                  "i = 0; i < 3; i++) s += dot(a, b) * 0.125; return saturate(a * b) + s; }",
                  Language::Hlsl, LoopMode::Rolled));
  const Outcome exact = run(p, test_value), fixed = run(p, test_value, {}, "fx31");
  for (std::size_t lane = 0; lane < vm::kLanes; ++lane)
    for (std::size_t k = 0; k < 4; ++k)  // a dozen roundings to 2^-31
      EXPECT_NEAR(fixed.outputs.at("COLOR0")[lane][k], exact.outputs.at("COLOR0")[lane][k], 12 * 0x1p-31);
}

}  // namespace
}  // namespace aluminate::compiler::testing
