// Which vector unit the hot loops use. All give the same bits; tests and --cpu style switches choose one to prove it.
#pragma once

#include <string>
#include <vector>

namespace aluminate::raster {

/// Names of the compiled units this machine can run, best first: "AVX3", "AVX2", "SSE4", "EMU128" (no vectors).
std::vector<std::string> vector_targets();
/// Uses this unit from now on in the whole process; empty = the best one. Not while rendering. UserError for other names.
void use_vector_target(const std::string& name);

}  // namespace aluminate::raster
