// What tells this build of the program from any other: the linker's build id, a hash of the program's
// content. What a build keeps on disk is keyed by it, so that no other build ever reads it.
#pragma once

#include <cstdint>
#include <vector>

namespace aluminate::host {

/// The build id of the running program's own file; empty when it was linked without one.
const std::vector<std::uint8_t>& build_identity();

}  // namespace aluminate::host
