// What every hostile-shader test does with its bytes: compile, and if that works validate, price, prepare and run one
// batch. Anything but a UserError or finite numbers in range is a failure.
#pragma once

#include "shading/compiler/compile.hpp"

#include <cstdint>
#include <string>
#include <string_view>

namespace aluminate::fuzz {

/// Returns the refusal's message, or "" when the shader ran. Throws what a shader must never cause.
std::string run_shader(compiler::Language language, vm::Stage stage, std::string_view bytes);

/// One batch of 64 lanes on fixed inputs. UserError when a loop does not end.
void run_batch(const vm::Program& program);

/// Languages by the folder a corpus file lies in: "spirv", "hlsl", "glsl", "assembly". A name that starts with "vertex"
/// is a vertex shader.
std::string run_corpus_file(const std::string& path);

}  // namespace aluminate::fuzz
