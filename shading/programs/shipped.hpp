// The shipped shader sources, embedded: the program needs no data files. User shaders may #include them by
// name.
#pragma once

#include <span>
#include <string_view>

#include "shading/compiler/compile.hpp"

namespace aluminate::programs {

struct ShippedSource {
  std::string_view name;  // "forward_lit.hlsl"
  std::string_view text;
};
std::span<const ShippedSource> shipped_sources();

/// Options that compile a shipped source by name. InternalError when there is none.
compiler::Options shipped(std::string_view name);

/// Makes every shipped source available to #include.
void add_shipped_includes(compiler::Options& options);

}  // namespace aluminate::programs
