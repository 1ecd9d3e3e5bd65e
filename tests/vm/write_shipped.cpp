// write_shipped FILE: the shipped shaders in the variants that differ most, compiled, for program_bits on other machines.
#include <cstdio>
#include <fstream>

#include "shading/passes/programs.hpp"
#include "tests/vm/program_file.hpp"

int main(int argc, char** argv) {
  using namespace aluminate;
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_shipped FILE\n");
    return 2;
  }
  std::ofstream file(argv[1], std::ios::binary);
  const auto write = [&](const vm::Program& program) { vm::testing::write_program(file, program); };
  passes::SurfaceFeatures textured;
  for (const auto map : {passes::kBaseColorMap, passes::kMetallicRoughnessMap, passes::kNormalMap, passes::kOcclusionMap,
                         passes::kEmissiveMap})
    textured.maps[map] = true;
  for (const char* visibility : {"none", "schlick-smith", "integrated", "cheap"})
    for (const char* fresnel : {"schlick", "sg", "sg-lagarde"}) {
      passes::FrameOptions options;
      passes::set_option(options, "visibility", visibility);
      passes::set_option(options, "fresnel", fresnel);
      write(passes::compile_pixel(options, textured, {4, false}, false));
      write(passes::compile_eval_brdf(options.visibility, options.fresnel));
    }
  const passes::FrameOptions options;
  write(passes::compile_pixel(options, {}, {2, true}, false));
  passes::SurfaceFeatures masked = textured;
  masked.alpha_mask = masked.double_sided = masked.vertex_color = true;
  write(passes::compile_pixel(options, masked, {2, false}, true));
  passes::SurfaceFeatures glossy;
  glossy.specular_glossiness = true;
  write(passes::compile_pixel(options, glossy, {1, false}, false));
  passes::SurfaceFeatures unlit;
  unlit.unlit = true;
  write(passes::compile_pixel(options, unlit, {0, false}, false));
  write(passes::compile_vertex({}));
  write(passes::compile_vertex(textured));
  write(passes::compile_tonemap(passes::Tonemap::Reinhard));
  write(passes::compile_tonemap(passes::Tonemap::Filmic));
  return file.flush() ? 0 : 2;
}
