#include "shading/programs/shipped.hpp"

#include "platform/host/error.hpp"

namespace aluminate::programs {

extern const ShippedSource kSources[];  // generated from the .hlsl files of this folder
extern const std::size_t kSourceCount;

std::span<const ShippedSource> shipped_sources() { return {kSources, kSourceCount}; }

compiler::Options shipped(std::string_view name) {
  compiler::Options options;
  for (const ShippedSource& source : shipped_sources()) {
    if (source.name != name) continue;
    options.source_path = std::string(name);
    options.source = std::string(source.text);
    add_shipped_includes(options);
    return options;
  }
  ALU_CHECK(false, "no shipped shader '{}'", name);
}

void add_shipped_includes(compiler::Options& options) {
  for (const ShippedSource& source : shipped_sources()) options.files.emplace(source.name, source.text);
}

}  // namespace aluminate::programs
