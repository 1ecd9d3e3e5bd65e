// libFuzzer entry of the shader languages: any bytes are a program that runs or a UserError. One program for each
// language, by SHADER_FUZZ_LANGUAGE; the length's last bit chooses the stage.
//   cmake --preset fuzz && cmake --build --preset fuzz; spirv_fuzz -max_len=8192 -timeout=20 CORPUS tests/fuzz/corpus/spirv
#include "tests/fuzz/shader_input.hpp"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace aluminate;
  // Modules are whole words: their stage is in the entry point, and pixel shaders have the most to offer.
  const bool vertex = size % 4 == 1;
  fuzz::run_shader(compiler::Language::SHADER_FUZZ_LANGUAGE, vertex ? vm::Stage::Vertex : vm::Stage::Pixel,
                   {reinterpret_cast<const char*>(data), size});
  return 0;
}
