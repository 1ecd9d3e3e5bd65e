// HLSL or GLSL text in, SPIR-V out. The only place that knows glslang: when its HLSL half is gone one day,
// another front end takes this one's place. Errors carry file:line:column of the user's text, includes and
// #line respected.
#pragma once

#include "shading/compiler/compile.hpp"

#include <cstdint>
#include <set>
#include <string>
#include <vector>

namespace aluminate::compiler {

struct FrontEndResult {
  std::vector<std::uint32_t> spirv;
  std::set<std::string> explicit_registers;  // uniforms declared with register(cN)
};

/// language is Hlsl or Glsl. Runs on the caller's thread: deep recursion is bounded by limits on nesting and
/// size.
FrontEndResult run_front_end(const Options& options, Language language, const std::string& text);

}  // namespace aluminate::compiler
